#include "common/graph/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "catch.hpp"
#include "check_pose.hpp"
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

constexpr LoopParameters kLoops{true, 30.0};
const int kLag = GraphConstants{}.lag;
const int kDrawingLag = GraphConstants{}.drawing_lag;

/// A drive along corridors, as it was matched.
struct Driven {
  std::vector<CriticalRays> scans;
  std::vector<ScanMatch> matches;

  void Add(const Pose2& T_world_laser) {
    static const std::vector<Wall> walls = MakeBlock(5);
    Random random(scans.size());
    const auto utime = static_cast<std::int64_t>(scans.size());
    scans.push_back({utime, SeeRays(walls, T_world_laser, random), {}});
    matches.push_back(MatchedAt(utime, Inverse(PlaceRoundBlock(5.0)) * T_world_laser));
    if (utime == 0) matches.back().state = MatchState::kFirst;
  }

  /// Another drive follows, which begins a trajectory.
  void Append(const Driven& other) {
    const std::size_t first = matches.size();
    scans.insert(scans.end(), other.scans.begin(), other.scans.end());
    matches.insert(matches.end(), other.matches.begin(), other.matches.end());
    matches[first].state = MatchState::kFirst;
  }

  CriticalRays LeaveOutMoving(const MovingObjectFilter& filter, std::size_t i) const {
    return {scans[i].utime, filter.Filter(scans[i].rays, matches[i].T_map_laser), {}};
  }

  Mapper::Step IntegrateIn(Mapper& mapper, std::size_t i) const { return mapper.Integrate(&scans[i], matches[i]); }

  Mapper Mapped(const LoopParameters& loops = kLoops) const {
    Mapper mapper(Drawing(), loops);
    for (std::size_t i = 0; i < scans.size(); ++i) IntegrateIn(mapper, i);
    return mapper;
  }
};

/// Round a block, a scan every quarter of a metre, and as far back again as `back_m`.
Driven Drive(double to_m, double back_m = 0.0) {
  Driven driven;
  for (double way_m = 5.0; way_m < to_m; way_m += 0.25) driven.Add(PlaceRoundBlock(way_m));
  for (double way_m = to_m; way_m > to_m - back_m; way_m -= 0.25) driven.Add(PlaceRoundBlock(way_m));
  return driven;
}

void Take(ByteMap& map, const std::vector<TileChange>& tiles) {
  for (const TileChange& tile : tiles) REQUIRE(map.Apply(tile));
}

ByteMap MapOf(const MapUpdater& updater) {
  ByteMap map(updater.geometry().cell_size_m());
  for (std::size_t i = 0; i < updater.num_tiles(); ++i) {
    if (const auto tile = updater.TileSince(i, -1)) map.Apply(*tile);
  }
  return map;
}
ByteMap LocalMap(const Mapper& mapper) { return MapOf(mapper.local()); }

/// All that was seen, by all that is known.
ByteMap DrawWhole(const Mapper& mapper) {
  WholeMap whole(Drawing());
  while (!whole.Draw(mapper, 7)) {
  }
  return MapOf(whole.map());
}

bool HaveEqualTiles(const MapDelta& a, const MapDelta& b) {
  return std::ranges::equal(a.tiles, b.tiles, [](const TileChange& one, const TileChange& other) {
    return one.index == other.index && one.runs == other.runs;
  });
}

std::vector<std::uint8_t> CellsOf(const ByteMap& map) { return map.ToDenseGrid().cells; }

/// The tiles in which anything is explored: of a map whose corners are a kilometre apart it is the fastest look.
std::map<TileIndex, TileBytes> ExploredTiles(const ByteMap& map) {
  std::map<TileIndex, TileBytes> explored;
  for (const auto& entry : map.tiles().entries()) {
    if (entry.tile->cells != ByteMap::Tile().cells) explored.emplace(entry.index, entry.tile->cells);
  }
  return explored;
}

/// Whether anything was seen at a place round the block.
bool Knows(const ByteMap& map, double way_m) {
  const Pose2 at = Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(way_m);
  return map.At(map.geometry().CellAt(at.x_m, at.y_m)) != kUnexploredByte;
}

/// That the keyframes of the first trajectory from one number to another have moved.
GraphUpdate Move(const Mapper& mapper, const Pose2& T_new_old, int first, int last) {
  GraphUpdate update;
  update.previous = mapper.last_update();
  update.keyframe = Nth(last);
  PoseStretch& moved = update.moved.emplace_back(Nth(first));
  for (int k = first; k <= last; ++k) moved.poses.push_back(T_new_old * mapper.graph().pose(Nth(k)));
  return update;
}

}  // namespace

TEST_CASE("without loops a mapper draws what the map's owner draws, and keeps no keyframes") {
  const Driven driven = Drive(45.0);
  MapUpdater owner(Drawing());
  MovingObjectFilter filter;
  Mapper mapper(Drawing(), {false, 30.0});
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    const CriticalRays* scan = i % 7 != 3 ? &driven.scans[i] : nullptr;
    const CriticalRays still = driven.LeaveOutMoving(filter, i);
    const MapDelta expected = scan ? owner.Update(still, driven.matches[i]) : owner.UpdateWithoutScan();
    if (expected.drawn) filter.Add(driven.scans[i].rays, driven.matches[i].T_map_laser);
    const Mapper::Step step = mapper.Integrate(scan, driven.matches[i]);
    REQUIRE(step.delta.version == expected.version);
    REQUIRE(step.delta.drawn == expected.drawn);
    REQUIRE(HaveEqualTiles(step.delta, expected));
    REQUIRE(step.keyframe == nullptr);
  }
  CHECK(CellsOf(LocalMap(mapper)) == CellsOf(MapOf(owner)));
  CHECK(mapper.graph().size() == 0);
}

TEST_CASE("the local map leaves out what is far along the path; the whole map has it") {
  const Driven driven = Drive(88.0);  // nearly all round: what it saw first is near again, as the crow flies
  Mapper mapper(Drawing(), kLoops);
  MovingObjectFilter filter;
  int num_drawn = 0;
  ByteMap replica(Drawing().cell_size_m);  // which hears nothing but the changes
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    const Mapper::Step step = driven.IntegrateIn(mapper, i);
    REQUIRE(step.delta.drawn == (step.keyframe != nullptr));
    if (step.keyframe) {
      REQUIRE(step.keyframe->rays == driven.LeaveOutMoving(filter, i).rays);
      filter.Add(driven.scans[i].rays, driven.matches[i].T_map_laser);
    }
    num_drawn += step.delta.drawn;
    Take(replica, step.delta.tiles);
  }
  CHECK(mapper.graph().size() == num_drawn);
  CHECK(CellsOf(replica) == CellsOf(LocalMap(mapper)));
  const ByteMap whole = DrawWhole(mapper);
  for (const double way_m : {5.0, 20.0, 66.0, 85.0}) CHECK(Knows(whole, way_m));
  for (const double way_m : {20.0, 66.0, 85.0}) CHECK(Knows(replica, way_m) == (way_m > 20.0));
  mapper.Finish();
  CHECK(CellsOf(LocalMap(mapper)) == CellsOf(whole));
}

TEST_CASE("keyframes stay in the local map for a while where the way went straight on, and only there") {
  const auto ShareDrawn = [&](const Driven& driven, double local_map_m = 10.0) {
    const Mapper mapper = driven.Mapped({true, local_map_m});
    return static_cast<double>(mapper.num_drawn()) / mapper.graph().size();
  };
  CHECK(ShareDrawn(Drive(25.5)) == 1.0);        // 20 m along a corridor
  CHECK(ShareDrawn(Drive(16.0, 12.0)) < 0.7);   // to and fro
  CHECK(ShareDrawn(Drive(48.0)) < 0.6);         // 43 m, by when it is far
  CHECK(ShareDrawn(Drive(48.0), 16.0) == 1.0);  // ... for a map of 10 m, not for one of 16 m
  CHECK(ShareDrawn(Drive(48.0), 30.0) == 1.0);  // nor round two corners, where it is half of 30 m away
}

TEST_CASE("where the robot comes back to, the local map has again what it had left out") {
  Driven out_and_back = Drive(75.0, 35.0);
  const std::size_t num_out = Drive(75.0).scans.size();
  Mapper mapper(Drawing(), kLoops);
  ByteMap replica(Drawing().cell_size_m);
  for (std::size_t i = 0; i < out_and_back.scans.size(); ++i) {
    if (i == num_out + 60) CHECK_FALSE(Knows(replica, 38.0));
    ValidRays& rays = out_and_back.scans[i].rays;
    for (std::size_t k = rays.size(); i >= num_out && k-- > 0;) {  // on the way back it sees no further than 2 m
      if (rays.range_m[k] <= 2.0f) continue;
      rays.angle_rad.erase(rays.angle_rad.begin() + static_cast<std::ptrdiff_t>(k));
      rays.range_m.erase(rays.range_m.begin() + static_cast<std::ptrdiff_t>(k));
    }
    Take(replica, out_and_back.IntegrateIn(mapper, i).delta.tiles);
  }
  CHECK(Knows(replica, 38.0));
  CHECK(CellsOf(replica) == CellsOf(LocalMap(mapper)));
}

TEST_CASE("a keyframe has a constraint to the nearest one of long ago, where it was matched") {
  const Mapper mapper = Drive(22.0, 16.0).Mapped();
  const KeyframeGraph& graph = mapper.graph();
  int num_constrained = 0;
  for (const KeyframeId id : graph.ids()) {
    const auto& constraint = graph.keyframe(id).constraint;
    if (!constraint) continue;
    ++num_constrained;
    REQUIRE(graph.path_m(id) - graph.path_m(constraint->keyframe) > GraphConstants().submaps.long_ago_m);
    CheckPose(graph.pose(constraint->keyframe) * constraint->T_keyframe_this, graph.pose(id), 1e-6);
    REQUIRE(Length(constraint->T_keyframe_this) < 2.5);
  }
  CHECK(num_constrained >= 5);
  CHECK_FALSE(graph.keyframe(graph.FindByPath(0, 24.0)).constraint);
}

TEST_CASE("a keyframe says what is not known of its motion") {
  Driven driven = Drive(8.0);
  driven.matches[1].state = MatchState::kLost;
  ScanMatch& open = driven.matches[4];
  open.state = MatchState::kDegenerate;
  open.T_map_laser.yaw_rad = kPi / 2;
  open.degenerate_axis = {0.0, 1.0};
  Mapper mapper(Drawing(), kLoops);
  driven.IntegrateIn(mapper, 0);
  CHECK(driven.IntegrateIn(mapper, 1).keyframe == nullptr);
  const Keyframe* keyframe = driven.IntegrateIn(mapper, 4).keyframe;
  REQUIRE(keyframe);
  CHECK(keyframe->utime == open.utime);
  CHECK(keyframe->after_lost);
  REQUIRE(keyframe->degenerate_axis);
  CHECK(keyframe->degenerate_axis->at(0) == Approx(1.0));  // the map's y axis is straight ahead
  CHECK(keyframe->degenerate_axis->at(1) == Approx(0.0).margin(1e-9));
  keyframe = driven.IntegrateIn(mapper, 8).keyframe;
  REQUIRE(keyframe);
  CHECK_FALSE(keyframe->after_lost);
  CHECK_FALSE(keyframe->degenerate_axis);
}

TEST_CASE("what is corrected is drawn beside, takes effect some keyframes later, and moves map, robot and all scans") {
  const Driven driven = Drive(20.0);
  Mapper mapper = driven.Mapped();
  const auto CheckScans = [&](const Pose2& T_new_old) {
    for (std::size_t i = 0; i < driven.matches.size(); ++i) {
      const Pose2& matched = driven.matches[i].T_map_laser;
      CheckPose(mapper.BestPose(static_cast<std::int64_t>(i), matched), T_new_old * matched, 1e-9);
    }
  };
  CheckScans({});
  const KeyframePoses before = mapper.graph().poses();
  const Pose2 turn{0.0, 0.0, 0.05};
  const GraphUpdate update = Move(mapper, turn, 0, mapper.graph().size() - kLag);
  REQUIRE(mapper.Accept(update));
  CHECK(mapper.last_update() == update.keyframe);
  CHECK(mapper.num_layouts() == 1);

  // At once it is known, and nobody on the local map has heard of it.
  CHECK(mapper.graph().poses() == before);
  CHECK(mapper.MakeBestGraph().poses() == mapper.best_poses());
  CheckPose(mapper.best_poses()[0].back(), turn * before[0].back(), 1e-9);
  CheckScans(turn);

  // The next keyframe takes it up. Those while it is drawn are matched on the map as it was.
  ByteMap replica = LocalMap(mapper);
  CriticalRays scan{1000, driven.scans.back().rays, {}};
  Pose2 matched = before[0].back();
  const int num_until_effect = kDrawingLag + 1;
  for (int i = 1; i <= num_until_effect; ++i) {
    CAPTURE(i);
    const bool takes_effect = i == num_until_effect;
    const Pose2 onward{0.45 + 0.01 * i, 0.0, 0.0};
    matched = matched * onward;
    ++scan.utime;
    const Mapper::Step step = mapper.Integrate(&scan, MatchedAt(scan.utime, matched));
    REQUIRE(step.keyframe);
    CHECK_FALSE(step.keyframe->as_of);
    CheckPose(step.keyframe->T_previous_this, onward, 1e-9);
    CHECK(mapper.is_drawing() != takes_effect);
    CHECK(mapper.graph().poses() == mapper.best_poses());
    CheckPose(mapper.graph().poses()[0].back(), turn * matched, 1e-9);
    Take(replica, step.delta.tiles);
    CHECK(CellsOf(replica) == CellsOf(LocalMap(mapper)));
    CHECK((CellsOf(replica) == CellsOf(DrawWhole(mapper))) == takes_effect);
    REQUIRE(step.after.T_new_old.has_value() == takes_effect);
    if (takes_effect) CheckPose(*step.after.T_new_old, turn, 1e-9);
  }

  // The one after it is matched on the map that was moved.
  ++scan.utime;
  const Mapper::Step then = mapper.Integrate(&scan, MatchedAt(scan.utime, turn * matched * Pose2{0.5, 0.0, 0.0}));
  REQUIRE(then.keyframe);
  CHECK(then.keyframe->as_of == update.keyframe);
  CHECK_FALSE(then.after.T_new_old);
  CheckPose(then.keyframe->T_previous_this, {0.5, 0.0, 0.0}, 1e-9);
}

TEST_CASE("scans between keyframes follow the one that they were matched after, also while it moves") {
  const Driven driven = Drive(10.0);
  Mapper mapper = driven.Mapped();
  const Pose2 turn{0.5, 0.0, 0.1};  // which the last of the next keyframes brings to the map
  const int num_until_effect = kDrawingLag + 1;
  REQUIRE(mapper.Accept(Move(mapper, turn, 0, mapper.graph().size() - kLag)));
  const Pose2 last = driven.matches.back().T_map_laser;
  const auto num_scans = static_cast<std::int64_t>(driven.scans.size());
  std::vector<std::pair<Pose2, Pose2>> best_and_matched;
  const auto Integrate = [&](double ahead_m, bool is_moved) {
    const Pose2 at = last * Pose2{ahead_m, 0.0, 0.0};
    best_and_matched.emplace_back(turn * at, is_moved ? turn * at : at);
    return mapper.Integrate(&driven.scans.back(), MatchedAt(driven.scans.back().utime, best_and_matched.back().second));
  };
  for (int i = 1; i <= num_until_effect; ++i) {
    CHECK(Integrate(0.5 * (i - 1) + 0.01, false).keyframe == nullptr);
    const Mapper::Step step = Integrate(0.5 * i, false);
    CHECK(step.keyframe != nullptr);
    CHECK(step.after.T_new_old.has_value() == (i == num_until_effect));
  }
  CHECK(Integrate(0.5 * num_until_effect + 0.01, true).keyframe == nullptr);
  for (std::size_t i = 0; i < best_and_matched.size(); ++i) {
    const auto& [best, matched] = best_and_matched[i];
    CheckPose(mapper.BestPose(num_scans + static_cast<std::int64_t>(i), matched), best, 1e-9);
  }
}

TEST_CASE("a local map that is drawn anew has few keyframes of each place, however often the robot passed there") {
  Driven driven;
  GraphConstants constants;
  constants.known_ground.keyframes = 1000;  // each scan becomes one
  Mapper mapper(Drawing(), kLoops, constants);
  const auto DriveOn = [&](int num_passes) {
    for (int step = 0; step < 40 * num_passes; ++step) {
      const int to_and_fro = step / 40 % 2 == 0 ? step % 40 : 40 - step % 40;
      driven.Add(PlaceRoundBlock(5.0 + 0.25 * to_and_fro));
      driven.IntegrateIn(mapper, driven.scans.size() - 1);
    }
  };
  const auto NumAfterUpdate = [&] {
    REQUIRE(mapper.Accept(Move(mapper, {}, 0, mapper.graph().size() - kLag)));
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
  const std::size_t num_scans = driven.scans.size();
  const bool lacks_room = GENERATE(false, true);
  for (std::size_t i = 5; lacks_room && i < num_scans; ++i) {
    // Backwards and later to one side: the square between has more tiles than there may be.
    std::vector<float>& ranges_m = driven.scans[i].rays.range_m;
    if (i < 15 || i >= num_scans - 40) ranges_m[0] = 1000.0f;
    if (i >= num_scans - 40) ranges_m[ranges_m.size() / 4] = 1000.0f;
  }
  for (const std::size_t num_put_off : {std::size_t{1}, std::size_t{20}, std::size_t{50}, num_scans - 10}) {
    CAPTURE(lacks_room, num_put_off);
    Mapper whole(Drawing(), kShort);
    Mapper put_off(Drawing(), kShort);
    put_off.PutOffDrawing();
    ByteMap replica(Drawing().cell_size_m);
    for (std::size_t i = 0; i < num_scans; ++i) {
      const Mapper::Step expected = driven.IntegrateIn(whole, i);
      const Mapper::Step step = driven.IntegrateIn(put_off, i);
      REQUIRE(step.delta.version == expected.delta.version);
      REQUIRE(step.delta.drawn == expected.delta.drawn);
      REQUIRE(step.after.T_new_old == expected.after.T_new_old);
      Take(replica, step.delta.tiles);
      if (i == 40) {
        const GraphUpdate update = Move(whole, {0.1, 0.2, 0.003}, 10, whole.graph().size() - 1);
        REQUIRE(whole.Accept(update));
        REQUIRE(put_off.Accept(update));
      }
      if (i < num_put_off) CHECK(put_off.local().num_tiles() == 0);
      if (i + 1 == num_put_off) Take(replica, put_off.DrawPutOff());
      if (i >= num_put_off) CHECK(HaveEqualTiles(step.delta, expected.delta));
      if (i + 1 == num_put_off || i + 1 == num_scans) {
        const auto explored = ExploredTiles(replica);
        CHECK((explored == ExploredTiles(LocalMap(whole))));
        CHECK((explored == ExploredTiles(LocalMap(put_off))));
      }
    }
    CHECK(put_off.graph().poses() == whole.graph().poses());
    CHECK(put_off.local().num_scans_cut() == whole.local().num_scans_cut());
    CHECK((whole.local().num_scans_cut() > 0) == lacks_room);
  }
}

TEST_CASE("where the robot was often a scan is drawn now and then, or where something has changed") {
  GraphConstants constants;
  constants.known_ground = {.keyframes = 8, .every_m = 4.0, .least_fitness = 0.6};
  Driven to_and_fro;
  for (int pass = 0; pass < 20; ++pass) {
    for (double way_m = 5.0; way_m < 20.0; way_m += 0.25) to_and_fro.Add(PlaceRoundBlock(way_m));
    for (double way_m = 20.0; way_m > 5.0; way_m -= 0.25) to_and_fro.Add(PlaceRoundBlock(way_m));
  }
  const std::size_t per_pass = to_and_fro.scans.size() / 20;
  const std::size_t last_pass = 19 * per_pass;
  for (ScanMatch& match : to_and_fro.matches) match.fitness = 0.8;
  const auto FindDrawn = [&](const Driven& driven) {
    Mapper mapper(Drawing(), kLoops, constants);
    std::vector<bool> drawn;
    for (std::size_t i = 0; i < driven.scans.size(); ++i) drawn.push_back(driven.IntegrateIn(mapper, i).delta.drawn);
    return drawn;
  };
  const auto CountInPass = [&](const std::vector<bool>& drawn, std::size_t first) {
    const auto begin = drawn.begin() + static_cast<std::ptrdiff_t>(first);
    return std::count(begin, begin + static_cast<std::ptrdiff_t>(per_pass), true);
  };
  const std::vector<bool> drawn = FindDrawn(to_and_fro);
  CHECK(CountInPass(drawn, 0) == 60);
  CHECK(CountInPass(drawn, last_pass) <= 8);
  CHECK(CountInPass(drawn, last_pass) >= 6);

  Driven changed = to_and_fro;
  for (std::size_t i = last_pass; i < changed.matches.size(); ++i) changed.matches[i].fitness = 0.5;
  CHECK(CountInPass(FindDrawn(changed), last_pass) == 60);
  Driven elsewhere = to_and_fro;  // another trajectory has a frame of its own
  elsewhere.matches[last_pass].state = MatchState::kFirst;
  CHECK(CountInPass(FindDrawn(elsewhere), last_pass) == 60);
  Driven lost = to_and_fro;  // behind it a keyframe tells where the robot is
  const auto next = static_cast<std::size_t>(
      std::find(drawn.begin() + static_cast<std::ptrdiff_t>(last_pass), drawn.end(), true) - drawn.begin());
  REQUIRE_FALSE(drawn[next + 5]);
  lost.matches[next + 4].state = MatchState::kLost;
  CHECK(FindDrawn(lost)[next + 5]);
}

TEST_CASE("an update comes to the same whether keyframes come before it or after it") {
  constexpr int kUpdated = 24;
  const Driven driven = Drive(20.0);
  Mapper late = driven.Mapped();
  REQUIRE(late.graph().size() <= kUpdated + kLag);                         // not due yet
  const GraphUpdate update = Move(late, {0.1, 0.2, 0.003}, 10, kUpdated);  // those before the tenth stay
  REQUIRE(late.Accept(update));
  Mapper early(Drawing(), kLoops);
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    const Mapper::Step step = driven.IntegrateIn(early, i);
    if (step.keyframe && early.graph().size() == kUpdated + 1) REQUIRE(early.Accept(update));
  }
  CHECK(early.last_update() == update.keyframe);
  CHECK(early.best_poses() == late.best_poses());
  CHECK(early.MakeBestGraph().poses() == early.best_poses());
  for (int k = 0; k < 10; ++k) CHECK(At(early.best_poses(), Nth(k)) == early.graph().pose(Nth(k)));
}

TEST_CASE("loops are placed by all that is known: those that hold, those that were rejected, the newest of many") {
  Mapper mapper = Drive(20.0).Mapped();
  CHECK(mapper.PlaceLoops().empty());
  const auto Accept = [&](int keyframe, std::vector<Loop> closed, std::vector<Loop> rejected, double moved_m) {
    GraphUpdate update = Move(mapper, {moved_m, 0.0, 0.0}, 0, keyframe);
    update.closed = std::move(closed);
    update.rejected = std::move(rejected);
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
  const MapPieces pieces = mapper.FindPieces();
  CHECK((pieces.num_closed == 2 && pieces.num_rejected == 1 && pieces.num_keyframes == mapper.graph().size()));

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
  CHECK_FALSE(Mapper(Drawing(), kLoops).NoteSearched(Nth(0)));
  Mapper mapper = Drive(20.0).Mapped();
  CHECK_FALSE(mapper.searched());
  CHECK_FALSE(mapper.FindSearch(Nth(0)));
  GraphUpdate update;
  update.keyframe = Nth(20);
  update.finding = LoopFinding{Nth(3), Nth(20), {0.5, 0.25, 0.125}, 0.75};
  REQUIRE(mapper.Accept(update));
  CHECK(mapper.num_layouts() == 0);
  CHECK(mapper.last_update() == Nth(20));
  CHECK(mapper.searched() == Nth(20));
  for (const int keyframe : {19, 20, 21}) {
    const auto search = mapper.FindSearch(Nth(keyframe));
    REQUIRE(search.has_value() == (keyframe <= 20));
    if (search) CHECK(search->finding == (keyframe == 20 ? update.finding : std::nullopt));
  }
  for (const int keyframe : {22, 21}) CHECK(mapper.NoteSearched(Nth(keyframe)));  // which is known
  CHECK(mapper.searched() == Nth(22));
  CHECK_FALSE(mapper.NoteSearched(Nth(mapper.graph().size())));
}

TEST_CASE("an update that does not follow the last one, or is of no such graph, changes nothing") {
  Mapper mapper = Drive(20.0).Mapped();
  const KeyframePoses poses = mapper.best_poses();
  const GraphUpdate good = Move(mapper, {0.5, 0.0, 0.0}, 0, 20);
  GraphUpdate follows_another = good;
  follows_another.previous = Nth(5);
  GraphUpdate of_another_graph = good;
  of_another_graph.moved[0].first = Nth(1);
  for (const GraphUpdate& update : {follows_another, of_another_graph}) {
    CHECK_FALSE(mapper.Accept(update));
    CHECK(mapper.best_poses() == poses);
    CHECK(mapper.num_layouts() == 0);
  }
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

TEST_CASE(
    "a first scan amid a drive begins a trajectory, which floats until it has the most keyframes or is joined, by what "
    "has taken effect") {
  Driven driven = Drive(20.0);
  const std::size_t num_before = driven.scans.size();
  driven.Append(Drive(30.0));
  const bool is_joined = GENERATE(true, false);
  Mapper mapper(Drawing(), kLoops);
  int num_joined = 0;  // keyframes of the second trajectory when the join comes
  for (std::size_t i = 0; i < driven.scans.size(); ++i) {
    CAPTURE(i, is_joined);
    const auto newest = mapper.graph().newest();
    if (is_joined && newest == KeyframeId{1, 20} && num_joined == 0) {
      GraphUpdate update;
      update.keyframe = *newest;
      update.closed = {{{0, 20}, {1, 20}, {}}};
      REQUIRE(mapper.Accept(update));
      num_joined = 20;
      CHECK(mapper.IsKeyframeOnMap(*newest));  // is known at once, but takes effect some keyframes later
    }
    const Mapper::Step step = driven.IntegrateIn(mapper, i);
    const int num_first = mapper.graph().size(0);
    const int num_second = mapper.graph().size() - num_first;
    CHECK(step.after.trajectory == (i < num_before ? 0 : 1));
    const bool has_joined = num_joined > 0 && num_second > num_joined + kLag + kDrawingLag;
    CHECK(step.after.floating == (i >= num_before && num_second <= num_first && !has_joined));
    ScanMatch lost = driven.matches[i];
    lost.state = MatchState::kLost;
    const auto scan = static_cast<std::int64_t>(i > num_before ? i + 1 : i);
    CHECK(mapper.BestMatch(scan, lost).floating == !mapper.IsScanOnMap(scan));
    CHECK(mapper.BestMatch(scan, driven.matches[i]).state == driven.matches[i].state);  // what floats is not lost
    if (i != num_before) continue;
    REQUIRE(step.keyframe);
    CHECK(step.keyframe->begins);
    CHECK_FALSE(step.keyframe->constraint);
    CHECK(mapper.num_drawn() == 1);  // nothing that came before is matched any more
    CHECK((mapper.IsScanOnMap(0) && !mapper.IsScanOnMap(scan)));
    CHECK(mapper.num_layouts() == 0);
    // A scan that is not drawn changes nothing.
    CHECK(mapper.Integrate(nullptr, lost).after == AfterMatch{std::nullopt, 1, true});
  }
  CHECK(mapper.IsKeyframeOnMap({1, 0}));  // the second one is longer by now
  CHECK(mapper.IsScanOnMap(0) == is_joined);
  CHECK(mapper.IsKeyframeOnMap(mapper.graph().LastOf(0)) == is_joined);
  CHECK(mapper.num_layouts() == 1);
}

TEST_CASE("without loops, and once the map is finished, nothing floats") {
  Driven driven = Drive(20.0);
  driven.matches[3].state = MatchState::kFirst;
  Mapper without(Drawing(), {false, 30.0});
  Mapper finished(Drawing(), kLoops);
  for (std::size_t i = 0; i <= 3; ++i) {
    CHECK(driven.IntegrateIn(without, i).after == AfterMatch());
    const AfterMatch floats{std::nullopt, 1, true};
    CHECK(driven.IntegrateIn(finished, i).after == (i == 3 ? floats : AfterMatch()));
  }
  finished.Finish();
  CHECK(driven.IntegrateIn(finished, 4).after == AfterMatch());
}

}  // namespace crsm
