#include "services/map_updater/answers.hpp"

#include <algorithm>

#include "services/runtime/conversions.hpp"

namespace crsm {
namespace {

constexpr std::size_t kPartBytes = 28000;  // with one tile more still under 32 KiB
constexpr std::size_t kPageMatches = 256;  // about 15 KB
constexpr std::size_t kTileHeaderBytes = 8;

void Add(const ScanMatch& match, map_delta_t& message) {
  message.matches.push_back(ToMessage(match));
  ++message.num_matches;
}

void Add(const TileChange& change, map_delta_t& message) {
  message.tiles.push_back(ToMessage(change));
  ++message.num_tiles;
}

}  // namespace

std::vector<map_delta_t> MakeParts(const MapDelta& delta, const ScanMatch& match, const MapGeometry& geometry) {
  map_delta_t blank{};
  blank.utime = match.utime;
  blank.version = delta.version;
  blank.base_version = delta.version - 1;
  blank.cell_size_m = geometry.cell_size_m();

  std::vector<map_delta_t> parts{blank};
  Add(match, parts.front());
  std::size_t size = 0;
  for (const TileChange& change : delta.tiles) {
    if (size >= kPartBytes) {
      parts.push_back(blank);
      size = 0;
    }
    Add(change, parts.back());
    size += kTileHeaderBytes + change.runs.size();
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].part = static_cast<std::int32_t>(i);
    parts[i].num_parts = static_cast<std::int32_t>(parts.size());
  }
  return parts;
}

map_delta_t MakePage(const map_request_t& request, const MapUpdater& updater, std::span<const ScanMatch> history) {
  map_delta_t page{};
  page.utime = history.empty() ? 0 : history.back().utime;
  page.version = updater.version();
  page.base_version = request.base_version;
  page.cell_size_m = updater.geometry().cell_size_m();
  page.num_parts = 1;
  page.recipient = request.requester;

  std::size_t match = std::min(static_cast<std::size_t>(request.first_match), history.size());
  for (; match < history.size() && page.matches.size() < kPageMatches; ++match) Add(history[match], page);
  page.next_match = static_cast<std::int32_t>(match);

  std::size_t size = page.matches.size() * 64;
  auto tile = static_cast<std::size_t>(request.first_tile);
  for (; tile < updater.num_tiles() && size < kPartBytes; ++tile) {
    const auto change = updater.TileSince(tile, request.base_version);
    if (!change) continue;
    Add(*change, page);
    size += kTileHeaderBytes + change->runs.size();
  }
  page.next_tile = tile < updater.num_tiles() ? static_cast<std::int32_t>(tile) : -1;
  return page;
}

}  // namespace crsm
