#include "services/map_updater/delta_parts.hpp"

#include <algorithm>

#include "catch.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr AnswerOptions kOptions{5, 32000};
constexpr std::size_t kLargestTileMessageBytes = kMaxRunBytes + 300;
const MapGeometry kGeometry(0.05);

/// A delta of whole tiles, or of tiles with one changed cell each.
MapDelta MakeDelta(int num_tiles, bool whole) {
  MapDelta delta{8, true, {}};
  for (int i = 0; i < num_tiles; ++i) {
    TileChange change{{i % 64, i / 64}, {0, 0, 0, 1, 9}};
    if (whole) change.runs.assign(kMaxRunBytes, 16);
    delta.tiles.push_back(std::move(change));
  }
  return delta;
}

}  // namespace

TEST_CASE("a match that changed nothing is answered by one empty part") {
  const auto parts = MakeParts({8, false, {}}, 5, kGeometry, kOptions);
  REQUIRE(parts.size() == 1);
  CHECK(Encode(parts[0]) ==
        Encode(map_delta_t{.utime = 5, .epoch = 5, .version = 8, .cell_size_m = 0.05, .num_parts = 1}));
  CHECK(Decode<map_delta_t>(Encode(parts[0])));
}

TEST_CASE("a large change is split into well-formed parts of a size that hold each tile once, in order") {
  const auto most_bytes = GENERATE(as<std::size_t>{}, 32000, 1400, 48000);
  for (const bool whole : {true, false}) {
    for (const int num_tiles : {1, 7, 100, 6000}) {
      const MapDelta delta = MakeDelta(whole ? std::min(num_tiles, 100) : num_tiles, whole);
      const auto parts = MakeParts(delta, 5, kGeometry, {5, most_bytes});
      CAPTURE(most_bytes, whole, num_tiles, parts.size());
      std::size_t next = 0;
      int num_wrong = 0;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto bytes = Encode(parts[i]);
        CHECK(bytes.size() <= (parts[i].num_tiles == 1 ? std::max(most_bytes, kLargestTileMessageBytes) : most_bytes));
        CHECK(Decode<map_delta_t>(bytes));
        CHECK(parts[i].part == static_cast<int>(i));
        CHECK(parts[i].num_parts == static_cast<int>(parts.size()));
        for (const map_tile_t& tile : parts[i].tiles) {
          num_wrong += FromMessage(tile).index != delta.tiles.at(next++).index;
        }
      }
      CHECK(num_wrong == 0);
      CHECK(next == delta.tiles.size());
    }
  }
}

TEST_CASE("what a match has brought about is said once, in the first part") {
  const Pose2 T_new_old{0.25, -0.5, 1.0 / 3.0};
  for (const int num_tiles : {0, 100}) {
    const MapDelta delta = MakeDelta(num_tiles, true);
    const auto parts = MakeParts(delta, 5, kGeometry, kOptions, {T_new_old, 3, true});
    REQUIRE((parts.size() > 1) == (num_tiles > 0));
    for (const map_delta_t& part : parts) {
      const bool is_first = part.part == 0;
      const auto bytes = Encode(part);
      CHECK(bytes.size() <= kOptions.most_bytes);
      CHECK(Decode<map_delta_t>(bytes));
      REQUIRE(part.num_corrections == (is_first ? 1 : 0));
      if (is_first) CHECK(FromMessage(part.T_new_old[0]) == T_new_old);
      CHECK(part.trajectory == (is_first ? 3 : 0));
      CHECK(part.floating == (is_first ? 1 : 0));
    }
    for (const map_delta_t& part : MakeParts(delta, 5, kGeometry, kOptions)) CHECK(part.num_corrections == 0);
  }
}

}  // namespace crsm
