#include "common/graph/background_drawing.hpp"

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

std::vector<PlacedScan> MakeDrive(int num_scans) {
  std::vector<PlacedScan> scans;
  for (int i = 0; i < num_scans; ++i) {
    const Pose2 at{0.3 * i, 0.1 * i, 0.2 * i};
    scans.push_back({AllRays(ScanRoom(at)).rays, at});
  }
  return scans;
}

std::vector<TileChange> TilesOf(const MapUpdater& map) {
  std::vector<TileChange> tiles;
  for (std::size_t i = 0; i < map.num_tiles(); ++i) tiles.push_back(*map.TileSince(i, -1));
  return tiles;
}

bool AreSame(const MapUpdater& a, const MapUpdater& b) {
  return std::ranges::equal(TilesOf(a), TilesOf(b), [](const TileChange& one, const TileChange& other) {
    return one.index == other.index && one.runs == other.runs;
  });
}

MapUpdater DrawAtOnce(std::span<const PlacedScan> scans) {
  MapUpdater map(TestParameters().update);
  map.DrawMore(scans);
  return map;
}

}  // namespace

TEST_CASE("a map that is drawn beside is the one that is drawn at once, with what was added meanwhile on top") {
  const std::vector<PlacedScan> scans = MakeDrive(30);
  BackgroundDrawing drawing(TestParameters().update);
  for (const std::size_t num_first : {1, 10, 29, 30}) {
    CAPTURE(num_first);
    drawing.Begin({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(num_first)});
    for (std::size_t i = num_first; i < scans.size(); ++i) drawing.Add(scans[i]);
    CHECK(AreSame(drawing.Take(), DrawAtOnce(scans)));
  }
}

TEST_CASE("what was begun and not taken is dropped by the next map, or at the end") {
  const std::vector<PlacedScan> scans = MakeDrive(30);
  BackgroundDrawing drawing(TestParameters().update);
  drawing.Begin(scans);
  drawing.Begin({scans[3]});
  CHECK(AreSame(drawing.Take(), DrawAtOnce({&scans[3], 1})));
  drawing.Begin({});
  CHECK(drawing.Take().num_tiles() == 0);
  drawing.Begin(scans);
}

}  // namespace crsm
