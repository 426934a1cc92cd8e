#include "common/graph/submap_loop_closer.hpp"

#include "catch.hpp"
#include "common/graph/loop_search.hpp"
#include "graph/block.hpp"
#include "graph/nth.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 40.0};
const int kLag = GraphConstants{}.lag;

double Distance_m(const Pose2& a, const Pose2& b) { return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }

/// Where the keyframes truly are, seen from the first.
std::vector<Pose2> FromFirst(const std::vector<Pose2>& places) {
  std::vector<Pose2> truth;
  for (const Pose2& place : places) truth.push_back(Inverse(places[0]) * place);
  return truth;
}

double LargestDistance_m(const std::vector<Pose2>& one, const std::vector<Pose2>& other) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) largest_m = std::max(largest_m, Distance_m(one[i], other[i]));
  return largest_m;
}

/// How far the loops are from the truth, at most.
double WorstLoop_m(const std::vector<Loop>& loops, const std::vector<Pose2>& truth) {
  double worst_m = 0.0;
  for (const Loop& loop : loops) {
    const Pose2 right = Inverse(truth[IndexOf(loop.older)]) * truth[IndexOf(loop.newer)];
    worst_m = std::max(worst_m, Distance_m(loop.T_older_newer, right));
  }
  return worst_m;
}

/// A constraint to the nearest keyframe of long ago, as the mapper makes it: by where the matches say that the robot
/// is.
std::optional<ProximityConstraint> ConstrainWhereMatched(const KeyframeGraph& graph, const Pose2& T_map_this) {
  std::optional<ProximityConstraint> constraint;
  double nearest_m = 2.5;
  for (KeyframeId id = Nth(0); IsLongAgo(graph, id, GraphConstants().submaps.long_ago_m); ++id.number) {
    const double away_m = Distance_m(graph.pose(id), T_map_this);
    if (away_m < nearest_m) {
      nearest_m = away_m;
      constraint = ProximityConstraint{id, Inverse(graph.pose(id)) * T_map_this};
    }
  }
  return constraint;
}

}  // namespace

TEST_CASE("a drive round a block that has drifted is corrected when it comes back") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    const std::vector<Pose2> places = DriveRoundBlock(5.0, 5.0 + 1.4 * kRoundBlock_m);
    const std::vector<Pose2> truth = FromFirst(places);
    SubmapLoopCloser closer(kLoops, UpdateParameters{});
    KeyframeGraph without;
    std::vector<Loop> closed;
    std::optional<KeyframeId> previous;
    const auto keyframes = MakeKeyframes(MakeBlock(seed), places, {0.002, 0.0, 0.0008}, seed);
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
      without.Add(keyframes[i]);
      const auto update = closer.Add(keyframes[i], {});
      if (!update) continue;
      CHECK(update->keyframe == Nth(static_cast<int>(i)));
      CHECK(update->previous == std::exchange(previous, update->keyframe));
      CHECK(closer.graph().Fits(*update));
      CHECK(update->rejected.empty());
      closed.insert(closed.end(), update->closed.begin(), update->closed.end());
    }
    const double before_m = LargestDistance_m(without.poses()[0], truth);
    REQUIRE(before_m > 1.0);
    CHECK(closed.size() >= 2);
    CHECK(closer.graph().loops() == closed);
    CHECK(WorstLoop_m(closed, truth) < 0.1);  // two cells of the map on which they are refined
    // What is left is how the first round is bent, for which the loops at its ends cannot vouch.
    CHECK(LargestDistance_m(closer.graph().poses()[0], truth) < 0.5 * before_m);
    // The second time round fits onto the first: the standard deviation of a loop is what a check takes for agreement.
    const auto at = [&](std::size_t i) { return closer.graph().poses()[0][i]; };
    for (std::size_t i = 200; i < places.size(); ++i) {
      REQUIRE(Distance_m(Inverse(at(i - 176)) * at(i), Inverse(truth[i - 176]) * truth[i]) < 0.15);
    }
  }
}

TEST_CASE("a loop that says what the graph says is taken up, and moves nothing before others tell more") {
  const std::vector<Pose2> places = DriveRoundBlock(5.0, 5.0 + 1.4 * kRoundBlock_m);
  // How many updates with loops have moved nothing.
  const auto Count = [&](const Pose2& drift, const GraphConstants& constants) {
    SubmapLoopCloser closer(kLoops, UpdateParameters{}, constants);
    int num_waiting = 0;
    for (const Keyframe& keyframe : MakeKeyframes(MakeBlock(2), places, drift, 2)) {
      const auto update = closer.Add(keyframe, {});
      num_waiting += update && !update->closed.empty() && update->moved.empty();
    }
    CHECK(closer.graph().loops().size() >= 2);
    return num_waiting;
  };
  GraphConstants patient;
  patient.loops.waits_growth = 1.0;
  patient.loops.waits_from = 0;
  CHECK(Count({}, patient) > 0);
  CHECK(Count({0.002, 0.0, 0.0008}, patient) < Count({}, patient));
  GraphConstants impatient = patient;
  impatient.loops.waits_growth = 0.0;
  CHECK(Count({}, impatient) == 0);
  GraphConstants small = patient;
  small.loops.waits_from = 2000;
  CHECK(Count({}, small) == 0);
}

TEST_CASE("what was found before is not searched again, and gives the same updates, to the last bit") {
  auto keyframes =
      MakeKeyframes(MakeBlock(7), DriveRoundBlock(5.0, 5.0 + 1.4 * kRoundBlock_m), {0.0, 0.001, 0.0008}, 7);
  SECTION("on one drive") {}
  SECTION("over a break") { keyframes[150].begins = true; }
  SECTION("over a break after which the robot may be anywhere") {
    keyframes[250].begins = keyframes[250].begins_anywhere = true;
  }
  SubmapLoopCloser first(kLoops, UpdateParameters{});
  SubmapLoopCloser again(kLoops, UpdateParameters{});
  SubmapLoopCloser told_all(kLoops, UpdateParameters{});
  SubmapLoopCloser told_nothing(kLoops, UpdateParameters{});
  int num_closed = 0;
  int num_found_alone = 0;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const auto update = first.Add(keyframes[i], {});
    std::optional<EarlierSearch> earlier;
    if (i < 270) earlier = EarlierSearch{update ? update->finding : std::nullopt};  // then the first session ended
    REQUIRE(again.Add(keyframes[i], earlier) == update);
    if (earlier && update) earlier->update = std::make_shared<const GraphUpdate>(*update);
    REQUIRE(told_all.Add(keyframes[i], earlier) == update);
    REQUIRE(told_all.graph().poses() == first.graph().poses());
    REQUIRE_FALSE(told_nothing.Add(keyframes[i], EarlierSearch{}));  // nothing was searched
    if (!update) continue;
    REQUIRE(update->finding);
    CHECK(update->finding->newer == update->keyframe);
    num_closed += static_cast<int>(update->closed.size());
    num_found_alone += !update->ChangesGraph();
  }
  CHECK(num_closed > 0);
  CHECK(num_found_alone > 0);
}

TEST_CASE("where a place is known the matches are checked, and a slip between two proximity constraints is corrected") {
  const std::vector<Wall> walls = MakeBlock(4);
  std::vector<Pose2> places = DriveRoundBlock(2.0, 45.0);
  const std::vector<Pose2> back = DriveRoundBlock(44.5, 3.0);
  places.insert(places.end(), back.begin(), back.end());
  const std::vector<Pose2> truth = FromFirst(places);
  constexpr int kSlip = 130;  // after 65 m, where the first ties are 9 m old
  constexpr int kSlipped = 138;
  // Eight motions of half a metre along a degenerate direction are known to two fifths of each.
  for (const double slip_m : {0.0, 0.25, 0.6}) {
    CAPTURE(slip_m);
    auto keyframes = MakeKeyframes(walls, places, {}, 4);
    for (std::size_t i = kSlip; i < kSlipped; ++i) {  // the walls left it open how far the robot went
      keyframes[i].T_previous_this = keyframes[i].T_previous_this * Pose2{slip_m / (kSlipped - kSlip), 0.0, 0.0};
      keyframes[i].degenerate_axis = {1.0, 0.0};
      keyframes[i].walls.sigma.x_m = 1.0;
    }
    SubmapLoopCloser closer(kLoops, UpdateParameters{});
    std::optional<GraphUpdate> found;
    int num_constrained = 0;
    for (Keyframe& keyframe : keyframes) {
      const KeyframeGraph& graph = closer.graph();
      if (graph.size() > 0)
        keyframe.constraint = ConstrainWhereMatched(graph, graph.poses()[0].back() * keyframe.T_previous_this);
      num_constrained += keyframe.constraint.has_value();
      if (found && graph.CountAfter(found->keyframe) >= kLag) keyframe.as_of = found->keyframe;
      auto update = closer.Add(keyframe, {});
      if (update && update->ChangesGraph() && !found) found = std::move(update);
    }
    REQUIRE(num_constrained > 10);
    REQUIRE(found.has_value() == (slip_m > 0.0));
    if (!found) continue;
    REQUIRE(found->constraints_wrong_from);
    CHECK(*found->constraints_wrong_from <= Nth(kSlipped));
    CHECK(*found->constraints_wrong_from > Nth(110));  // what was checked before it stays
    CHECK(WorstLoop_m(found->closed, truth) < 0.1);
    const KeyframeId last = std::min(Nth(found->keyframe.number + kLag), *closer.graph().newest());
    for (KeyframeId id = *found->constraints_wrong_from; id <= last; ++id.number) {
      const Keyframe& keyframe = closer.graph().keyframe(id);  // also of those that were matched until it took effect
      CHECK((!keyframe.constraint || keyframe.constraint_wrong));
    }
    CHECK(Distance_m(closer.graph().poses()[0].back(), truth.back()) < 0.15);
  }
}

TEST_CASE("loops that are rejected one by one win together against a way on which one match has slipped") {
  const std::vector<Pose2> places = DriveRoundBlock(5.0, 5.0 + 1.35 * kRoundBlock_m);
  const std::vector<Pose2> truth = FromFirst(places);
  auto keyframes = MakeKeyframes(MakeBlock(5), places, {}, 5);
  for (Keyframe& keyframe : keyframes) keyframe.walls.sigma = {0.005, 0.005, 0.0001};
  keyframes[120].T_previous_this = keyframes[120].T_previous_this * Pose2{1.0, 0.0, 0.0};
  SubmapLoopCloser closer(kLoops, UpdateParameters{});
  SubmapLoopCloser again(kLoops, UpdateParameters{});
  std::vector<Loop> rejected;
  int num_taken_back = 0;
  for (const Keyframe& keyframe : keyframes) {
    const auto update = closer.Add(keyframe, {});
    EarlierSearch earlier{update ? update->finding : std::nullopt};
    if (update) earlier.update = std::make_shared<const GraphUpdate>(*update);
    REQUIRE(again.Add(keyframe, earlier) == update);
    REQUIRE(again.graph().loops() == closer.graph().loops());
    if (!update) continue;
    for (const Loop& loop : update->closed) num_taken_back += static_cast<int>(std::erase(rejected, loop));
    rejected.insert(rejected.end(), update->rejected.begin(), update->rejected.end());
  }
  CHECK(num_taken_back >= 2);
  CHECK(rejected.empty());
  CHECK(WorstLoop_m(closer.graph().loops(), truth) < 0.1);
  CHECK(Distance_m(closer.graph().poses()[0].back(), truth.back()) < 0.3);
}

namespace {

/// A second drive through the lower corridor of a block, as if the robot had been carried there: seen in `walls`.
/// Returns the updates that change the loops.
std::vector<GraphUpdate> DriveAgain(SubmapLoopCloser& closer, const std::vector<Wall>& walls) {
  for (const Keyframe& keyframe : MakeKeyframes(MakeBlock(3), DriveRoundBlock(0.5, 24.5), {}, 1)) {
    closer.Add(keyframe, {});
  }
  std::vector<Keyframe> again = MakeKeyframes(walls, DriveRoundBlock(2.0, 26.5), {}, 2);
  again[0].begins = true;
  again[0].T_previous_this = {5.0, 7.0, 1.0};
  std::vector<GraphUpdate> updates;
  for (Keyframe& keyframe : again) {
    keyframe.utime += 60'000'000;
    auto update = closer.Add(std::move(keyframe), {});
    if (update && !(update->closed.empty() && update->rejected.empty())) updates.push_back(std::move(*update));
  }
  return updates;
}

}  // namespace

TEST_CASE(
    "a robot that was carried is joined after two findings, which share nothing of what was seen if there is much") {
  const bool much = GENERATE(false, true);
  GraphConstants constants;
  if (much) constants.joins.few_m = 0.0;
  SubmapLoopCloser closer(kLoops, UpdateParameters{}, constants);
  const auto updates = DriveAgain(closer, MakeBlock(3));
  REQUIRE_FALSE(updates.empty());
  REQUIRE(updates[0].closed.size() == 2);
  const auto [first, second] = std::pair(updates[0].closed[0], updates[0].closed[1]);
  const double apart_m = closer.graph().path_m(second.newer) - closer.graph().path_m(first.newer);
  CHECK(apart_m >= (much ? constants.submaps.recent_m : constants.joins.least_apart_of_few_m));
  CHECK((apart_m < constants.submaps.recent_m) == !much);
  CHECK(closer.graph().is_one_component());
  CHECK(closer.graph().num_loops_dropped() == 0);
}

TEST_CASE("a join falls apart where the robot then sees walls that others saw to be free") {
  std::vector<Wall> walls = MakeBlock(3);
  for (const double y_m : {1.1, 1.9}) walls.push_back({{14.0, y_m}, {27.0, y_m}});  // a narrower corridor further on
  SubmapLoopCloser closer(kLoops, UpdateParameters{});
  const auto updates = DriveAgain(closer, walls);
  REQUIRE(updates.size() >= 2);
  CHECK(updates.front().closed.size() == 2);
  const GraphUpdate& last = updates.back();
  CHECK(last.closed.empty());
  CHECK(last.rejected.size() >= 2);
  CHECK(last.previous >= updates[updates.size() - 2].keyframe);
  CHECK(closer.graph().Fits(last));
  CHECK_FALSE(closer.graph().is_one_component());
}

}  // namespace crsm
