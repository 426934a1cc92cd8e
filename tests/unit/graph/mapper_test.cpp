#include "common/graph/mapper.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/graph/loop_search.hpp"
#include "common/graph/whole_map.hpp"
#include "graph/block.hpp"
#include "graph/nth.hpp"

namespace crsm {
namespace {

UpdateParameters Drawing() {
  UpdateParameters drawing = TestParameters().update;
  drawing.update_distance_m = 0.3;  // of two scans a quarter of a metre apart one is drawn
  drawing.update_angle_rad = 10.0;
  return drawing;
}

constexpr LoopParameters kNoLoops{false, 30.0};
constexpr LoopParameters kLoops{true, 30.0};
const int kLag = GraphConstants{}.lag;

/// A drive along corridors, as it was matched.
struct Driven {
  std::vector<CriticalRays> scans;
  std::vector<ScanMatch> matches;

  void Add(const std::vector<Wall>& walls, const Pose2& T_world_laser, const Pose2& T_world_map) {
    Random random(scans.size());
    const auto utime = static_cast<std::int64_t>(scans.size());
    scans.push_back({utime, SeeRays(walls, T_world_laser, random), {}});
    matches.push_back(MatchedAt(utime, Inverse(T_world_map) * T_world_laser));
    if (utime == 0) matches.back().state = MatchState::kFirst;
  }
};

/// Round a block, a scan every quarter of a metre, and as far back again as `back_m`.
Driven Drive(double to_m, double back_m = 0.0) {
  const std::vector<Wall> walls = MakeBlock(5);
  const Pose2 T_world_map = PlaceRoundBlock(5.0);
  Driven driven;
  for (double way_m = 5.0; way_m < to_m; way_m += 0.25) driven.Add(walls, PlaceRoundBlock(way_m), T_world_map);
  for (double way_m = to_m; way_m > to_m - back_m; way_m -= 0.25) {
    driven.Add(walls, PlaceRoundBlock(way_m), T_world_map);
  }
  return driven;
}

ByteMap LocalMap(const Mapper& mapper) {
  ByteMap map(mapper.local().geometry().cell_size_m());
  for (std::size_t i = 0; i < mapper.local().num_tiles(); ++i) {
    if (const auto tile = mapper.local().TileSince(i, -1)) map.Apply(*tile);
  }
  return map;
}

/// The tiles in which anything is explored: of a map whose corners are a kilometre apart it is the fastest look.
std::map<TileIndex, TileBytes> ExploredTiles(const ByteMap& map) {
  const TileBytes unexplored = ByteMap::Tile().cells;
  std::map<TileIndex, TileBytes> explored;
  for (const auto& entry : map.tiles().entries()) {
    if (entry.tile->cells != unexplored) explored.emplace(entry.index, entry.tile->cells);
  }
  return explored;
}

/// Whether anything was seen at a place round the block.
bool Knows(const ByteMap& map, double way_m) {
  const Pose2 at = Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(way_m);
  const Cell cell{static_cast<int>(std::floor(at.x_m / 0.05)), static_cast<int>(std::floor(at.y_m / 0.05))};
  return map.At(cell) != kUnexploredByte;
}

/// All that was seen, by all that is known.
ByteMap DrawWhole(const Mapper& mapper) {
  WholeMap whole(Drawing());
  while (!whole.Draw(mapper, 7)) {
  }
  ByteMap map(Drawing().cell_size_m);
  for (std::size_t i = 0; i < whole.map().num_tiles(); ++i) {
    if (const auto tile = whole.map().TileSince(i, 0)) REQUIRE(map.Apply(*tile));
  }
  return map;
}

/// Keyframes of the first trajectory, from one number to another, moved.
PoseStretch Moved(const KeyframeGraph& graph, const Pose2& T_new_old, int first, int last) {
  PoseStretch moved{Nth(first), {}};
  for (int k = first; k <= last; ++k) moved.poses.push_back(T_new_old * graph.pose(Nth(k)));
  return moved;
}

}  // namespace

TEST_CASE("without loops a mapper draws what the map's owner draws, and keeps no keyframes") {
  const Driven driven = Drive(45.0);
  MapUpdater owner(Drawing());
  Mapper mapper(Drawing(), kNoLoops);
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    const bool has_scan = i % 7 != 3;
    const MapDelta expected = has_scan ? owner.Update(driven.scans[i], driven.matches[i]) : owner.UpdateWithoutScan();
    const Mapper::Step step = mapper.Integrate(has_scan ? &driven.scans[i] : nullptr, driven.matches[i]);
    REQUIRE(step.delta.version == expected.version);
    REQUIRE(step.delta.drawn == expected.drawn);
    REQUIRE(step.delta.tiles.size() == expected.tiles.size());
    for (std::size_t k = 0; k < expected.tiles.size(); ++k) {
      REQUIRE(step.delta.tiles[k].index == expected.tiles[k].index);
      REQUIRE(step.delta.tiles[k].runs == expected.tiles[k].runs);
    }
    REQUIRE(step.keyframe == nullptr);
  }
  CHECK(mapper.graph().size() == 0);
}

TEST_CASE("the local map leaves out what is far along the path; the whole map has it") {
  const Driven driven = Drive(86.0);  // nearly all round: what it saw first is near again, as the crow flies
  Mapper mapper(Drawing(), kLoops);
  int num_drawn = 0;
  ByteMap replica(Drawing().cell_size_m);  // which hears nothing but the changes
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    const Mapper::Step step = mapper.Integrate(&driven.scans[i], driven.matches[i]);
    REQUIRE(step.delta.drawn == (step.keyframe != nullptr));
    if (step.keyframe) REQUIRE(step.keyframe->rays == driven.scans[i].rays);
    num_drawn += step.delta.drawn;
    for (const TileChange& tile : step.delta.tiles) REQUIRE(replica.Apply(tile));
  }
  CHECK(mapper.graph().size() == num_drawn);
  const ByteMap local = LocalMap(mapper);
  CHECK(replica.ToDenseGrid().cells == local.ToDenseGrid().cells);
  CHECK(Knows(local, 85.0));
  CHECK(Knows(local, 66.0));
  CHECK_FALSE(Knows(local, 20.0));
  const ByteMap whole = DrawWhole(mapper);
  for (const double way_m : {5.0, 20.0, 66.0, 85.0}) CHECK(Knows(whole, way_m));
  mapper.Finish();
  CHECK(LocalMap(mapper).ToDenseGrid().cells == whole.ToDenseGrid().cells);
}

TEST_CASE("keyframes stay in the local map for a while where the way went straight on, and only there") {
  const auto ShareDrawn = [&](const Driven& driven, double local_map_m = 10.0) {
    Mapper mapper(Drawing(), {true, local_map_m});
    for (std::size_t i = 0; i < driven.scans.size(); ++i) mapper.Integrate(&driven.scans[i], driven.matches[i]);
    return static_cast<double>(mapper.num_drawn()) / mapper.graph().size();
  };
  CHECK(ShareDrawn(Drive(25.5)) == 1.0);        // 20 m along a corridor
  CHECK(ShareDrawn(Drive(16.0, 12.0)) < 0.7);   // to and fro
  CHECK(ShareDrawn(Drive(46.0)) < 0.6);         // 41 m, by when it is far
  CHECK(ShareDrawn(Drive(46.0), 16.0) == 1.0);  // ... for a map of 10 m, not for one of 16 m
  CHECK(ShareDrawn(Drive(46.0), 30.0) == 1.0);  // nor round two corners, where it is half of 30 m away
}

TEST_CASE("where the robot comes back to, the local map has again what it had left out") {
  Driven out_and_back = Drive(75.0, 35.0);
  const std::size_t num_out = Drive(75.0).scans.size();
  for (std::size_t i = num_out; i < out_and_back.scans.size(); ++i) {  // on the way back it sees no further than 2 m
    ValidRays& rays = out_and_back.scans[i].rays;
    ValidRays near;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      if (rays.range_m[k] > 2.0f) continue;
      near.angle_rad.push_back(rays.angle_rad[k]);
      near.range_m.push_back(rays.range_m[k]);
    }
    rays = near;
  }
  Mapper mapper(Drawing(), kLoops);
  ByteMap replica(Drawing().cell_size_m);
  for (std::size_t i = 0; i < out_and_back.scans.size(); ++i) {
    if (i == num_out + 60) CHECK_FALSE(Knows(replica, 38.0));
    for (const TileChange& tile : mapper.Integrate(&out_and_back.scans[i], out_and_back.matches[i]).delta.tiles) {
      REQUIRE(replica.Apply(tile));
    }
  }
  CHECK(Knows(replica, 38.0));
  CHECK(replica.ToDenseGrid().cells == LocalMap(mapper).ToDenseGrid().cells);
}

TEST_CASE("a keyframe has a constraint to the nearest one of long ago, where it was matched") {
  const Driven driven = Drive(22.0, 16.0);
  Mapper mapper(Drawing(), kLoops);
  for (std::size_t i = 0; i < driven.scans.size(); ++i) mapper.Integrate(&driven.scans[i], driven.matches[i]);
  const KeyframeGraph& graph = mapper.graph();
  int num_constrained = 0;
  for (const KeyframeId id : graph.ids()) {
    const auto& constraint = graph.keyframe(id).constraint;
    if (!constraint) continue;
    ++num_constrained;
    REQUIRE(graph.path_m(id) - graph.path_m(constraint->keyframe) > GraphConstants().submaps.long_ago_m);
    CheckPose(graph.pose(constraint->keyframe) * constraint->T_keyframe_this, graph.pose(id), 1e-6);
    REQUIRE(std::hypot(constraint->T_keyframe_this.x_m, constraint->T_keyframe_this.y_m) < 2.5);
  }
  CHECK(num_constrained >= 5);
  CHECK_FALSE(graph.keyframe(graph.FindByPath(0, 24.0)).constraint);
}

TEST_CASE("a keyframe says what is not known of its motion") {
  const Driven driven = Drive(8.0);
  Mapper mapper(Drawing(), kLoops);
  mapper.Integrate(&driven.scans[0], driven.matches[0]);
  ScanMatch lost = driven.matches[1];
  lost.state = MatchState::kLost;
  CHECK(mapper.Integrate(&driven.scans[1], lost).keyframe == nullptr);
  ScanMatch open = driven.matches[4];
  open.state = MatchState::kDegenerate;
  open.T_map_laser.yaw_rad = kPi / 2;
  open.degenerate_axis = {0.0, 1.0};
  const Keyframe* keyframe = mapper.Integrate(&driven.scans[4], open).keyframe;
  REQUIRE(keyframe);
  CHECK(keyframe->utime == open.utime);
  CHECK(keyframe->after_lost);
  REQUIRE(keyframe->degenerate_axis);
  CHECK(keyframe->degenerate_axis->x() == Approx(1.0));  // the map's y axis is straight ahead
  CHECK(keyframe->degenerate_axis->y() == Approx(0.0).margin(1e-9));
  keyframe = mapper.Integrate(&driven.scans[8], driven.matches[8]).keyframe;
  REQUIRE(keyframe);
  CHECK_FALSE(keyframe->after_lost);
  CHECK_FALSE(keyframe->degenerate_axis);
}

TEST_CASE("what is corrected takes effect some keyframes later, and moves the map, the robot and all scans") {
  const Driven driven = Drive(20.0);
  Mapper mapper(Drawing(), kLoops);
  for (std::size_t i = 0; i < driven.scans.size(); ++i) mapper.Integrate(&driven.scans[i], driven.matches[i]);
  const auto num_scans = static_cast<std::int64_t>(driven.scans.size());
  for (std::int64_t i = 0; i < num_scans; ++i) {
    const Pose2& matched = driven.matches[static_cast<std::size_t>(i)].T_map_laser;
    CheckPose(mapper.BestPose(i, matched), matched, 1e-9);
  }
  const KeyframeGraph before = mapper.graph();
  const Pose2 turn{0.0, 0.0, 0.05};
  GraphUpdate update;
  update.keyframe = Nth(before.size() - kLag);
  update.moved = {Moved(before, turn, 0, update.keyframe.number)};
  REQUIRE(mapper.Accept(update));
  CHECK(mapper.last_update() == update.keyframe);
  CHECK(mapper.num_layouts() == 1);

  // At once it is known, and nobody on the local map has heard of it.
  CHECK(mapper.graph().poses() == before.poses());
  const KeyframeGraph best = mapper.MakeBestGraph();
  CHECK(best.poses() == mapper.best_poses());
  CheckPose(best.poses()[0].back(), turn * before.poses()[0].back(), 1e-9);
  for (std::int64_t i = 0; i < num_scans; ++i) {
    const Pose2& matched = driven.matches[static_cast<std::size_t>(i)].T_map_laser;
    CheckPose(mapper.BestPose(i, matched), turn * matched, 1e-9);
  }

  // The next keyframe was matched on the map as it was, and takes it along.
  ByteMap replica = LocalMap(mapper);
  const ScanMatch next = MatchedAt(1000, driven.matches.back().T_map_laser * Pose2{0.5, 0.0, 0.0});
  const CriticalRays scan{1000, driven.scans.back().rays, {}};
  const Mapper::Step step = mapper.Integrate(&scan, next);
  REQUIRE(step.keyframe);
  CHECK_FALSE(step.keyframe->as_of);
  CheckPose(step.keyframe->T_previous_this, Inverse(before.poses()[0].back()) * next.T_map_laser, 1e-9);
  REQUIRE(step.after.T_new_old);
  CheckPose(*step.after.T_new_old, turn, 1e-9);
  CHECK(mapper.graph().poses() == mapper.best_poses());
  CheckPose(mapper.graph().poses()[0].back(), turn * next.T_map_laser, 1e-9);
  for (const TileChange& tile : step.delta.tiles) REQUIRE(replica.Apply(tile));
  CHECK(replica.ToDenseGrid().cells == LocalMap(mapper).ToDenseGrid().cells);
  CHECK(LocalMap(mapper).ToDenseGrid().cells == DrawWhole(mapper).ToDenseGrid().cells);

  // The one after it is matched on the map that was moved.
  const ScanMatch later = MatchedAt(1001, turn * next.T_map_laser * Pose2{0.5, 0.0, 0.0});
  const CriticalRays later_scan{1001, driven.scans.back().rays, {}};
  const Mapper::Step then = mapper.Integrate(&later_scan, later);
  REQUIRE(then.keyframe);
  CHECK(then.keyframe->as_of == update.keyframe);
  CHECK_FALSE(then.after.T_new_old);
  CheckPose(then.keyframe->T_previous_this, {0.5, 0.0, 0.0}, 1e-9);
}

TEST_CASE("scans between keyframes follow the one that they were matched after, also while it moves") {
  const Driven driven = Drive(10.0);
  Mapper mapper(Drawing(), kLoops);
  std::vector<ScanMatch> matches;
  const auto MatchNext = [&](const CriticalRays& scan, const Pose2& T_map_laser) {
    matches.push_back(MatchedAt(scan.utime, T_map_laser));
    return mapper.Integrate(&scan, matches.back());
  };
  for (std::size_t i = 0; i < driven.scans.size(); ++i) MatchNext(driven.scans[i], driven.matches[i].T_map_laser);
  const int newest = mapper.graph().size() - 1;
  GraphUpdate update;
  update.keyframe = Nth(newest + 1 - kLag);  // the next keyframe brings it to the map
  const Pose2 turn{0.5, 0.0, 0.1};
  update.moved = {Moved(mapper.graph(), turn, 0, update.keyframe.number)};
  REQUIRE(mapper.Accept(update));

  const CriticalRays scan = driven.scans.back();
  const Pose2 last = matches.back().T_map_laser;
  const Pose2 nudge{0.01, 0.0, 0.0};  // too little to be drawn
  REQUIRE_FALSE(MatchNext(scan, last * nudge).keyframe);
  REQUIRE(MatchNext(scan, last * Pose2{0.5, 0.0, 0.0}).after.T_new_old);
  REQUIRE_FALSE(MatchNext(scan, turn * last * Pose2{0.51, 0.0, 0.0}).keyframe);
  const auto num_scans = static_cast<std::int64_t>(matches.size());
  const auto BestOfLast = [&](std::int64_t back) {
    const std::int64_t scan_index = num_scans - 1 - back;
    return mapper.BestPose(scan_index, matches[static_cast<std::size_t>(scan_index)].T_map_laser);
  };
  CheckPose(BestOfLast(2), turn * last * nudge, 1e-9);
  CheckPose(BestOfLast(1), turn * last * Pose2{0.5, 0.0, 0.0}, 1e-9);
  CheckPose(BestOfLast(0), turn * last * Pose2{0.51, 0.0, 0.0}, 1e-9);
}

TEST_CASE("a local map that is drawn anew has few keyframes of each place, however often the robot passed there") {
  const std::vector<Wall> walls = MakeBlock(5);
  Driven driven;
  Mapper mapper(Drawing(), kLoops);
  const auto DriveOn = [&](int num_passes) {
    for (int pass = 0; pass < num_passes; ++pass) {
      for (int step = 0; step < 40; ++step) {
        const double way_m = 5.0 + 0.25 * (pass % 2 == 0 ? step : 40 - step);
        driven.Add(walls, PlaceRoundBlock(way_m), PlaceRoundBlock(5.0));
        mapper.Integrate(&driven.scans.back(), driven.matches.back());
      }
    }
  };
  const auto NumAfterUpdate = [&] {
    GraphUpdate update;
    update.previous = mapper.last_update();
    update.keyframe = Nth(mapper.graph().size() - kLag);
    update.moved = {Moved(mapper.graph(), {}, 0, update.keyframe.number)};
    REQUIRE(mapper.Accept(update));
    DriveOn(1);
    return mapper.num_drawn();
  };
  DriveOn(5);
  const int num_once = NumAfterUpdate();
  DriveOn(20);
  const int num_keyframes = mapper.graph().size();
  const int num_later = NumAfterUpdate();
  CHECK(num_keyframes > 4 * num_once);
  CHECK(2 * num_later < 3 * num_once);
  for (const double way_m : {5.0, 10.0, 14.0}) CHECK(Knows(LocalMap(mapper), way_m));
}

TEST_CASE(
    "a drive whose drawing was put off goes on with the same map, also where there may be no room for all of it") {
  constexpr LoopParameters kShort{true, 10.0};  // what was seen first is soon left out
  Driven driven = Drive(60.0);
  bool lacks_room = false;
  SECTION("with room") {}
  SECTION("without") {
    // Backwards and later to one side: the square between has more tiles than there may be.
    const auto SeeFar = [&](std::size_t scan, std::size_t ray) { driven.scans[scan].rays.range_m[ray] = 1000.0f; };
    for (std::size_t i = 5; i < 15; ++i) SeeFar(i, 0);
    for (std::size_t i = driven.scans.size() - 40; i < driven.scans.size(); ++i) {
      for (const std::size_t ray : {std::size_t{0}, driven.scans[i].rays.size() / 4}) SeeFar(i, ray);
    }
    lacks_room = true;
  }
  const int num_scans = static_cast<int>(driven.scans.size());
  for (const int num_put_off : {1, 20, 50, num_scans - 10}) {
    CAPTURE(num_put_off);
    Mapper whole(Drawing(), kShort);
    Mapper put_off(Drawing(), kShort);
    put_off.PutOffDrawing();
    ByteMap replica(Drawing().cell_size_m);
    const auto Tell = [&](const std::vector<TileChange>& tiles) {
      for (const TileChange& tile : tiles) REQUIRE(replica.Apply(tile));
    };
    for (int i = 0; i < num_scans; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Mapper::Step expected = whole.Integrate(&driven.scans[at], driven.matches[at]);
      const Mapper::Step step = put_off.Integrate(&driven.scans[at], driven.matches[at]);
      REQUIRE(step.delta.version == expected.delta.version);
      REQUIRE(step.delta.drawn == expected.delta.drawn);
      REQUIRE(step.after.T_new_old == expected.after.T_new_old);
      Tell(step.delta.tiles);
      if (i == 40) {
        GraphUpdate update;
        update.keyframe = *whole.graph().newest();
        update.moved = {Moved(whole.graph(), {0.1, 0.2, 0.003}, 10, update.keyframe.number)};
        REQUIRE(whole.Accept(update));
        REQUIRE(put_off.Accept(update));
      }
      if (i < num_put_off) CHECK(put_off.local().num_tiles() == 0);
      if (i + 1 == num_put_off) Tell(put_off.DrawPutOff());
      if (i + 1 < num_put_off) continue;
      const auto explored = ExploredTiles(replica);
      REQUIRE((explored == ExploredTiles(LocalMap(whole))));
      REQUIRE((explored == ExploredTiles(LocalMap(put_off))));
    }
    CHECK(put_off.graph().poses() == whole.graph().poses());
    CHECK(put_off.local().num_scans_cut() == whole.local().num_scans_cut());
    CHECK((whole.local().num_scans_cut() > 0) == lacks_room);
  }
}

TEST_CASE("an update comes to the same whether keyframes come before it or after it") {
  const Driven driven = Drive(20.0);
  Mapper early(Drawing(), kLoops);
  Mapper late(Drawing(), kLoops);
  std::optional<GraphUpdate> update;
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    early.Integrate(&driven.scans[i], driven.matches[i]);
    late.Integrate(&driven.scans[i], driven.matches[i]);
    if (early.graph().size() < 25 || update) continue;
    update.emplace();
    update->keyframe = Nth(24);
    update->moved = {Moved(early.graph(), {0.1, 0.2, 0.003}, 10, 24)};  // those before it stay
    REQUIRE(early.Accept(*update));
    REQUIRE(early.graph().size() - 1 < 24 + kLag);
  }
  REQUIRE(update);
  REQUIRE(late.graph().size() <= 24 + kLag);  // not due yet
  REQUIRE(late.Accept(*update));
  CHECK(early.best_poses() == late.best_poses());
  CHECK(early.MakeBestGraph().poses() == early.best_poses());
  for (int k = 0; k < 10; ++k) CHECK(At(early.best_poses(), Nth(k)) == early.graph().pose(Nth(k)));
}

TEST_CASE("loops are placed by all that is known: those that hold, those that were rejected, the newest of many") {
  const Driven driven = Drive(20.0);
  Mapper mapper(Drawing(), kLoops);
  for (std::size_t i = 0; i < driven.scans.size(); ++i) mapper.Integrate(&driven.scans[i], driven.matches[i]);
  CHECK(mapper.PlaceLoops().empty());
  const auto Accept = [&](int keyframe, std::vector<Loop> closed, std::vector<Loop> rejected, double moved_m) {
    GraphUpdate update;
    update.keyframe = Nth(keyframe);
    update.previous = mapper.last_update();
    update.closed = std::move(closed);
    update.rejected = std::move(rejected);
    update.moved = {Moved(mapper.graph(), {moved_m, 0.0, 0.0}, 0, keyframe)};
    REQUIRE(mapper.Accept(update));
  };
  const auto Placed = [&](int older, int newer, double moved_m, bool rejected) {
    const Pose2 motion{moved_m, 0.0, 0.0};
    return PlacedLoop{motion * mapper.graph().pose(Nth(older)), motion * mapper.graph().pose(Nth(newer)), rejected};
  };
  Accept(10, {{Nth(1), Nth(9), {}}, {Nth(2), Nth(10), {}}}, {}, 0.5);
  CHECK(mapper.PlaceLoops() == std::vector{Placed(1, 9, 0.5, false), Placed(2, 10, 0.5, false)});
  Accept(12, {{Nth(3), Nth(12), {}}}, {{Nth(1), Nth(9), {}}}, 0.25);
  CHECK(mapper.PlaceLoops() ==
        std::vector{Placed(2, 10, 0.25, false), Placed(3, 12, 0.25, false), Placed(1, 9, 0.25, true)});
  CHECK(mapper.num_loops() == 2);
  CHECK(mapper.num_loops_rejected() == 1);

  std::vector<Loop> many;
  for (int i = 0; i < 150; ++i) many.push_back({Nth(i % 10), Nth(11), {}});
  many.push_back({Nth(4), Nth(11), {}});
  Accept(13, many, {}, 0.0);
  const std::vector<PlacedLoop> placed = mapper.PlaceLoops();
  REQUIRE(placed.size() == kMostPlacedLoops / 2 + 1);
  CHECK(placed[kMostPlacedLoops / 2 - 1] == Placed(4, 11, 0.0, false));
  CHECK(placed.back() == Placed(1, 9, 0.0, true));
}

TEST_CASE("what was found changes nothing before it closes a loop, and is known from then on") {
  const Driven driven = Drive(20.0);
  Mapper mapper(Drawing(), kLoops);
  CHECK_FALSE(mapper.NoteSearched(Nth(0)));
  CHECK_FALSE(mapper.searched());
  for (std::size_t i = 0; i < driven.scans.size(); ++i) mapper.Integrate(&driven.scans[i], driven.matches[i]);
  CHECK_FALSE(mapper.FindSearch(Nth(0)));
  GraphUpdate update;
  update.keyframe = Nth(20);
  update.finding = LoopFinding{Nth(3), Nth(20), {0.5, 0.25, 0.125}, 0.75};
  const auto IsRefused = [&](const std::function<void(GraphUpdate&)>& spoil) {
    GraphUpdate spoilt = update;
    spoil(spoilt);
    return !mapper.Accept(spoilt);
  };
  CHECK(IsRefused([](GraphUpdate& u) { u.finding->older = Nth(20); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.finding->older = Nth(-1); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.finding->newer = Nth(19); }));
  REQUIRE(mapper.Accept(update));
  CHECK(mapper.num_layouts() == 0);
  CHECK(mapper.last_update() == Nth(20));
  CHECK(mapper.searched() == Nth(20));
  REQUIRE(mapper.FindSearch(Nth(20)));
  CHECK(mapper.FindSearch(Nth(20))->finding == update.finding);
  REQUIRE(mapper.FindSearch(Nth(19)));
  CHECK_FALSE(mapper.FindSearch(Nth(19))->finding);
  CHECK_FALSE(mapper.FindSearch(Nth(21)));
  CHECK(mapper.NoteSearched(Nth(22)));
  CHECK(mapper.NoteSearched(Nth(21)));  // which is known
  CHECK(mapper.searched() == Nth(22));
  CHECK_FALSE(mapper.NoteSearched(Nth(mapper.graph().size())));
}

TEST_CASE("an update that does not follow the last one, or is of no such graph, changes nothing") {
  const Driven driven = Drive(20.0);
  Mapper mapper(Drawing(), kLoops);
  for (std::size_t i = 0; i < driven.scans.size(); ++i) mapper.Integrate(&driven.scans[i], driven.matches[i]);
  const KeyframePoses poses = mapper.best_poses();
  GraphUpdate good;
  good.keyframe = Nth(20);
  good.moved = {{Nth(0), std::vector<Pose2>(21)}};
  const auto IsRefused = [&](const std::function<void(GraphUpdate&)>& spoil) {
    GraphUpdate update = good;
    spoil(update);
    return !mapper.Accept(update) && mapper.best_poses() == poses && mapper.num_layouts() == 0;
  };
  CHECK(IsRefused([](GraphUpdate& u) { u.previous = Nth(5); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.previous = KeyframeId{-1, 2}; }));
  CHECK(IsRefused([](GraphUpdate& u) { u.moved[0].poses.clear(); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.moved[0].poses.emplace_back(); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.moved[0].first = Nth(1); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.moved[0].first = Nth(-1); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.closed = {{Nth(3), Nth(21), {}}}; }));
  CHECK(IsRefused([](GraphUpdate& u) { u.closed = {{Nth(3), Nth(3), {}}}; }));
  CHECK(IsRefused([](GraphUpdate& u) { u.rejected = {{Nth(-1), Nth(3), {}}}; }));
  CHECK(IsRefused([](GraphUpdate& u) { u.constraints_wrong_from = Nth(-1); }));
  CHECK(IsRefused([](GraphUpdate& u) { u.moved[0].poses[7].x_m = -1e6; }));
  CHECK(IsRefused([](GraphUpdate& u) { u.moved[0].poses[7].y_m = NAN; }));
  CHECK(IsRefused([&](GraphUpdate& u) {
    u.keyframe = Nth(mapper.graph().size());
    u.moved = {{Nth(0), std::vector<Pose2>(IndexOf(u.keyframe) + 1)}};
  }));
  CHECK(mapper.Accept(good));
  CHECK_FALSE(mapper.Accept(good));  // it is known
}

TEST_CASE("scans before the first keyframe stay where they were") {
  Mapper mapper(Drawing(), kLoops);
  ScanMatch blind = MatchedAt(1, {});
  blind.state = MatchState::kLost;
  const CriticalRays nothing{1, {}, {}};
  CHECK(mapper.Integrate(&nothing, blind).keyframe == nullptr);
  CHECK(mapper.BestPose(0, blind.T_map_laser) == Pose2{});
  CHECK(DrawWhole(mapper).empty());
  mapper.Finish();
  CHECK(LocalMap(mapper).empty());
}

TEST_CASE("a first scan amid a drive begins a map of its own, and what is shown is the component with more keyframes") {
  Driven driven = Drive(20.0);
  const std::size_t num_before = driven.scans.size();
  const Driven later = Drive(40.0);
  for (std::size_t i = 60; i < later.scans.size(); ++i) {
    driven.scans.push_back(later.scans[i]);
    driven.matches.push_back(later.matches[i]);
  }
  driven.matches[num_before].state = MatchState::kFirst;
  Mapper mapper(Drawing(), kLoops);
  bool has_changed = false;
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    const Mapper::Step step = mapper.Integrate(&driven.scans[i], driven.matches[i]);
    if (i != num_before) continue;
    REQUIRE(step.keyframe);
    CHECK(step.keyframe->begins);
    CHECK_FALSE(step.keyframe->constraint);
    CHECK(mapper.num_drawn() == 1);  // nothing that came before is matched any more
    CHECK(mapper.IsScanOnMap(0));
    CHECK_FALSE(mapper.IsScanOnMap(static_cast<std::int64_t>(i)));
    CHECK(mapper.num_layouts() == 0);
    has_changed = true;
  }
  REQUIRE(has_changed);
  // The second part is longer by now.
  CHECK(mapper.num_layouts() == 1);
  CHECK_FALSE(mapper.IsScanOnMap(0));
  CHECK(mapper.IsScanOnMap(static_cast<std::int64_t>(driven.scans.size()) - 1));
  CHECK_FALSE(mapper.IsKeyframeOnMap(mapper.graph().LastOf(0)));
  CHECK(mapper.IsKeyframeOnMap({1, 0}));
}

TEST_CASE("a trajectory floats until it has the most keyframes or is joined, by what has taken effect") {
  Driven driven = Drive(20.0);
  const std::size_t num_before = driven.scans.size();
  const Driven later = Drive(30.0);
  driven.scans.insert(driven.scans.end(), later.scans.begin(), later.scans.end());
  driven.matches.insert(driven.matches.end(), later.matches.begin(), later.matches.end());
  driven.matches[num_before].state = MatchState::kFirst;
  const bool is_joined = GENERATE(true, false);
  Mapper mapper(Drawing(), kLoops);
  int num_joined = 0;  // keyframes of the second trajectory when the join comes
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    CAPTURE(i, is_joined);
    ScanMatch match = driven.matches[i];
    const auto newest = mapper.graph().newest();
    if (is_joined && newest == KeyframeId{1, 20} && num_joined == 0) {
      GraphUpdate update;
      update.keyframe = *newest;
      update.closed = {{{0, 20}, {1, 20}, {}}};
      REQUIRE(mapper.Accept(update));
      num_joined = 20;
      CHECK(mapper.IsKeyframeOnMap(*newest));  // is known at once, but takes effect some keyframes later
    }
    const Mapper::Step step = mapper.Integrate(&driven.scans[i], match);
    const int num_first = mapper.graph().size(0);
    const int num_second = mapper.graph().size() - num_first;
    CHECK(step.after.trajectory == (i < num_before ? 0 : 1));
    const bool has_joined = num_joined > 0 && num_second > num_joined + kLag;
    CHECK(step.after.floating == (i >= num_before && num_second <= num_first && !has_joined));
    match.state = MatchState::kLost;
    const auto scan = static_cast<std::int64_t>(i > num_before ? i + 1 : i);
    CHECK(mapper.BestMatch(scan, match).floating == !mapper.IsScanOnMap(scan));
    CHECK(mapper.MoveToBest(scan, match).floating == !mapper.IsScanOnMap(scan));
    if (i == num_before) {  // a scan that is not drawn changes nothing
      CHECK(mapper.Integrate(nullptr, match).after == AfterMatch{std::nullopt, 1, true});
    }
  }
  CHECK(num_joined == (is_joined ? 20 : 0));
}

TEST_CASE("without loops, and once the map is finished, nothing floats") {
  const Driven driven = Drive(20.0);
  ScanMatch first = driven.matches[3];
  first.state = MatchState::kFirst;
  LoopParameters none;
  none.loops = false;
  Mapper without(Drawing(), none);
  without.Integrate(&driven.scans[0], driven.matches[0]);
  CHECK(without.Integrate(&driven.scans[3], first).after == AfterMatch());
  Mapper finished(Drawing(), kLoops);
  for (std::size_t i = 0; i < 3; ++i) finished.Integrate(&driven.scans[i], driven.matches[i]);
  REQUIRE(finished.Integrate(&driven.scans[3], first).after == AfterMatch{std::nullopt, 1, true});
  finished.Finish();
  CHECK(finished.Integrate(&driven.scans[4], driven.matches[4]).after == AfterMatch());
}

}  // namespace crsm
