#include "common/graph/whole_map.hpp"

#include "catch.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

UpdateParameters Drawing() { return TestParameters().update; }

/// The keyframes of a drive along two sides of a block.
KeyframeGraph DriveAlong(double to_m) {
  KeyframeGraph graph;
  for (Keyframe& keyframe : MakeKeyframes(MakeBlock(3), DriveRoundBlock(5.0, to_m), {}, 3)) graph.Add(keyframe);
  return graph;
}

/// Takes over what has changed since a version; how many tiles that are.
int TakeOver(const MapUpdater& from, std::int64_t since, ByteMap& map) {
  int num_tiles = 0;
  for (std::size_t i = 0; i < from.num_tiles(); ++i) {
    const auto tile = from.TileSince(i, since);
    if (!tile) continue;
    REQUIRE(map.Apply(*tile));
    ++num_tiles;
  }
  return num_tiles;
}

std::vector<std::uint8_t> CellsOf(const MapUpdater& updater) {
  ByteMap map(Drawing().cell_size_m);
  CHECK(TakeOver(updater, -1, map) == static_cast<int>(updater.num_tiles()));
  return map.ToDenseGrid().cells;
}

/// The map of keyframes at these poses, drawn by who draws all maps.
std::vector<std::uint8_t> Expected(const KeyframeGraph& graph, const KeyframePoses& poses) {
  std::vector<PlacedScan> scans;
  for (const KeyframeId id : graph.ids()) scans.push_back({graph.keyframe(id).rays, At(poses, id)});
  MapUpdater updater(Drawing());
  updater.Redraw(scans);
  return CellsOf(updater);
}

/// All of it at once.
WholeMap DrawAll(const KeyframeGraph& graph, const KeyframePoses& poses, std::int64_t version) {
  WholeMap whole(Drawing());
  REQUIRE(whole.Draw(graph, poses, version, graph.size()));
  return whole;
}

}  // namespace

TEST_CASE("a whole map that is drawn piece by piece is the one that is drawn at once") {
  const KeyframeGraph graph = DriveAlong(30.0);
  const auto expected = Expected(graph, graph.poses());
  CHECK(CellsOf(DrawAll(graph, graph.poses(), 3).map()) == expected);
  WholeMap whole(Drawing());
  int num_pieces = 1;
  for (std::int64_t version = 5; !whole.Draw(graph, graph.poses(), version, 10); ++version) {
    CHECK(whole.map().version() == version);
    ++num_pieces;
  }
  CHECK(num_pieces == (graph.size() + 9) / 10);
  CHECK(CellsOf(whole.map()) == expected);
  CHECK(whole.Draw(graph, graph.poses(), 20, 10));  // there is nothing left to draw
  CHECK(whole.map().version() == 20);
  CHECK(CellsOf(whole.map()) == expected);
  WholeMap of_none(Drawing());
  CHECK(of_none.Draw(KeyframeGraph(), {}, 4, 10));
  CHECK((of_none.map().num_tiles() == 0 && of_none.map().version() == 4));
}

TEST_CASE("what is corrected is drawn anew where it belongs by now, and nothing of it is left where it was") {
  const KeyframeGraph graph = DriveAlong(30.0);
  WholeMap whole = DrawAll(graph, graph.poses(), 5);
  KeyframePoses poses = graph.poses();
  for (std::size_t i = 20; i < poses[0].size(); ++i) poses[0][i] = Pose2{3.0, 8.0, 0.5} * poses[0][i];
  whole.Forget();
  CHECK_FALSE(whole.Draw(graph, poses, 6, 10));
  while (!whole.Draw(graph, poses, 6, 10)) {
  }
  const auto expected = Expected(graph, poses);
  CHECK(CellsOf(whole.map()) == expected);
  CHECK(expected != Expected(graph, graph.poses()));
  CHECK(whole.map().num_tiles() == DrawAll(graph, poses, 6).map().num_tiles());
  CHECK(whole.map().version() == 6);
}

TEST_CASE(
    "keyframes that come are drawn into the map that is there, and who has that map lacks only what has changed") {
  const KeyframeGraph before = DriveAlong(15.0);
  const KeyframeGraph graph = DriveAlong(40.0);
  WholeMap whole = DrawAll(before, before.poses(), 5);
  ByteMap replica(Drawing().cell_size_m);
  TakeOver(whole.map(), 0, replica);
  CHECK(TakeOver(whole.map(), 5, replica) == 0);

  CHECK_FALSE(whole.Draw(graph, graph.poses(), 8, 10));
  while (!whole.Draw(graph, graph.poses(), 9, 10)) {
  }
  CHECK(CellsOf(whole.map()) == Expected(graph, graph.poses()));
  const int num_changed = TakeOver(whole.map(), 5, replica);
  CHECK(num_changed > 0);
  CHECK(num_changed < static_cast<int>(whole.map().num_tiles()));
  CHECK(replica.ToDenseGrid().cells == CellsOf(whole.map()));
  CHECK(TakeOver(whole.map(), 9, replica) == 0);
}

}  // namespace crsm
