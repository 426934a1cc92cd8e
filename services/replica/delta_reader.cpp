#include "services/replica/delta_reader.hpp"

#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

std::size_t NumTiles(const std::map<std::int32_t, map_delta_t>& parts) {
  std::size_t num = 0;
  for (const auto& [number, part] : parts) num += part.tiles.size();
  return num;
}

/// Of the scan that made the version that is held; 0 before the first.
std::int64_t UtimeOf(const TrackingState& tracking) { return tracking.empty() ? 0 : tracking.recent().back().utime; }

}  // namespace

void DeltaReader::Handle(const map_delta_t& part) {
  if (part.epoch != replica_.epoch()) return replica_.RequestUpdate();  // the owner began anew
  if (part.cell_size_m != replica_.cell_size_m()) return;               // not the owner's: a map keeps its cells
  if (part.version == replica_.version() && replica_.synced()) {        // the last answer, sent again
    if (part.utime != UtimeOf(replica_.tracking())) replica_.BeginAgain();
    return;
  }
  replica_.Hear(part.version);
  if (part.version != replica_.version() + 1)
    return replica_.RequestUpdate();  // a version was missed, or the owner's are lost
  if (!replica_.whole()) return;      // pages are under way and will bring it
  const auto is_other = [&](const map_delta_t& other) {
    return other.version != part.version || other.utime != part.utime || other.num_parts != part.num_parts;
  };
  if (!parts_.empty() && is_other(parts_.begin()->second)) parts_.clear();
  parts_[part.part] = part;
  if (NumTiles(parts_) > kMostTiles) {  // not the owner's: no map has so many
    parts_.clear();
    return replica_.RequestUpdate();
  }
  if (static_cast<std::int32_t>(parts_.size()) == part.num_parts) Apply();
}

/// All parts of the next version are there.
void DeltaReader::Apply() {
  const auto parts = std::exchange(parts_, {});
  const map_delta_t& first = parts.begin()->second;
  const ScanMatch* match = awaited_.Find(first.utime);
  if (!match) return replica_.RequestUpdate();
  for (const auto& [number, part] : parts) {
    std::vector<TileChange> changes;
    for (const map_tile_t& tile : part.tiles) changes.push_back(FromMessage(tile));
    replica_.Advance(changes);
  }
  const bool is_moved = !first.T_new_old.empty();
  replica_.EndVersion(*match, {is_moved ? std::optional(FromMessage(first.T_new_old.front())) : std::nullopt,
                               first.trajectory, first.floating == 1});
  awaited_.DropThrough(first.utime);
}

}  // namespace crsm
