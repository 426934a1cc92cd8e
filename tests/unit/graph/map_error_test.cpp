#include "common/graph/map_error.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr double kNothing_m = 1.0;  ///< what walls that tell nothing leave open, as the matcher has it

std::optional<MapError> Estimate(const KeyframeGraph& graph, const std::vector<bool>& is_shown,
                                 const GraphConstants& constants = {}) {
  KnownMotions motions;
  motions.Add(graph, graph.poses(), is_shown, constants.edges);
  return EstimateMapError(motions, constants);
}

/// Keyframes 0.4 m and a second apart, straight on.
struct Drive {
  KeyframeGraph graph;
  WallSigma told{{1.0, 0.0}, {0.01, 0.005, 0.002}};

  Keyframe Next() const {
    Keyframe keyframe;
    keyframe.utime = (graph.size() + 1) * kSecond_us;
    if (graph.size() > 0) keyframe.T_previous_this = {0.4, 0.0, 0.0};
    return keyframe;
  }
  template <class Change>
  Drive& Add(int num, Change&& change) {
    for (int i = 0; i < num; ++i) {
      Keyframe keyframe = Next();
      change(keyframe);
      keyframe.walls = told;
      graph.Add(std::move(keyframe));
    }
    return *this;
  }
  Drive& Add(int num) {
    return Add(num, [](Keyframe&) {});
  }
  /// Of a corridor, whose walls tell nothing along it.
  Drive& AddOpen(int num, double step_m = 0.4, std::int64_t every_us = kSecond_us) {
    told.sigma.x_m = kNothing_m;
    std::int64_t utime = graph.size() * kSecond_us;
    return Add(num, [&](Keyframe& keyframe) {
      keyframe.degenerate_axis = {1.0, 0.0};
      keyframe.T_previous_this = {step_m, 0.0, 0.0};
      keyframe.utime = utime += every_us;
    });
  }
  Drive& Close(int older, int newer, double off_m = 0.0) {
    graph.AddLoop({{0, older}, {0, newer}, {0.4 * (newer - older) + off_m, 0.0, 0.0}});
    return *this;
  }

  double Most_m(const GraphConstants& constants = {}) const {
    const auto error = Estimate(graph, {true}, constants);
    REQUIRE(error);
    return error->most_m;
  }
};

ScanMatch MatchedWith(double x_m2, double xy_m2, double y_m2, double yaw_rad) {
  ScanMatch match;
  match.T_map_laser.yaw_rad = yaw_rad;
  match.covariance = {0.0025 + x_m2, xy_m2, 0.0, 0.0025 + y_m2, 0.0, 0.000025 + 0.0004};
  return match;
}

}  // namespace

TEST_CASE("the longer a way that nothing crosses, the further off it may be, and a loop brings it back") {
  const double shorter_m = Drive().Add(50).Most_m();
  const double longer_m = Drive().Add(200).Most_m();
  CHECK(shorter_m > 0.05);
  CHECK(longer_m > 1.5 * shorter_m);
  Drive closed = Drive().Add(200).Close(0, 199);
  for (int i = 20; i < 200; i += 20) closed.Close(0, i);
  CHECK(closed.Most_m() < 0.7 * longer_m);
  CHECK_FALSE(Estimate(KeyframeGraph(), {}));
  CHECK_FALSE(Estimate(Drive().Add(50).graph, {false}));
}

TEST_CASE(
    "along a corridor a map may be off by a share of the way, or by what a robot that stood there may have driven") {
  const double known_m = Drive().Add(60).Most_m();
  const double open_m = Drive().Add(30).AddOpen(30).Most_m();
  CHECK(open_m > 2.0 * known_m);
  // In a minute the robot goes 24 m as a rule.
  const double stood_m = Drive().Add(30).AddOpen(2, 0.01, 60 * kSecond_us).Add(5).Most_m();
  CHECK(stood_m > 10.0);
  const auto error = [&] {
    const Drive drive = Drive().Add(30).AddOpen(2, 0.01, 60 * kSecond_us).Add(5);
    return *Estimate(drive.graph, {true});
  }();
  CHECK(error.at.x_m > 11.0);  // past the open piece
  const Drive endless = Drive().Add(30).AddOpen(2, 0.01, 1'000'000'000 * kSecond_us).Add(5);
  CHECK(endless.Most_m() < 1e5);
  // Walls that tell a little bound it, whatever the time.
  Drive told = Drive().Add(30);
  told.told.sigma.x_m = 0.1;
  told.Add(2, [](Keyframe& keyframe) {
    keyframe.degenerate_axis = {1.0, 0.0};
    keyframe.T_previous_this = {0.01, 0.0, 0.0};
  });
  CHECK(told.Most_m() < 2.0);
  // But for what the noise of the normals seems to tell where a wall is near.
  told.told.sigma = {0.1, 0.005, 0.002};
  told.AddOpen(1, 0.01, 60 * kSecond_us);
  CHECK(told.Most_m() > 5.0);
}

TEST_CASE("a robot that waits before its first step stands") {
  const auto WaitFirst = [](std::int64_t waits_us) {
    Drive drive;
    drive.Add(1);
    drive.AddOpen(1, 0.4, waits_us);
    drive.told.sigma.x_m = 0.01;
    return drive.Add(40, [&](Keyframe& keyframe) { keyframe.utime += waits_us; }).Most_m();
  };
  CHECK(WaitFirst(100 * kSecond_us) == Approx(WaitFirst(kSecond_us)).epsilon(0.05));
}

TEST_CASE("wheels bound what a corridor leaves open") {
  const auto WithWheels = [](double sigma_m) {
    Drive drive = Drive().Add(30);
    drive.told.sigma.x_m = kNothing_m;
    drive.Add(30, [&](Keyframe& keyframe) {
      keyframe.degenerate_axis = {1.0, 0.0};
      keyframe.by_wheels = WheelMotion{{0.4, 0.0, 0.0}, sigma_m, 0.01};
    });
    return drive.Most_m();
  };
  CHECK(WithWheels(0.002) < 0.7 * WithWheels(0.5));
}

TEST_CASE("how far off a map may be goes by the constants") {
  const Drive drive = Drive().Add(30).AddOpen(20);
  const double usual_m = drive.Most_m();
  CHECK(drive.Most_m({.map_error = {.least_m = 0.15}}) == Approx(usual_m + 0.1));
  CHECK(drive.Most_m({.edges = {.uneven = 2.0}}) > 1.5 * usual_m);
  CHECK(drive.Most_m({.map_error = {.quantile = 0.2}}) < usual_m);
  const Drive known = Drive().Add(100);
  CHECK(known.Most_m({.edges = {.walls = 3.0}}) > 1.5 * known.Most_m());
  CHECK(known.Most_m({.edges = {.step = {0.1, 0.1, 0.01}}}) > 1.5 * known.Most_m());
}

TEST_CASE("doubts are told along the path, few of them, and grow with the way that nothing crosses") {
  const auto error = [](const Drive& drive) { return *Estimate(drive.graph, {true}); };
  const MapError open = error(Drive().Add(40).AddOpen(40));
  REQUIRE(open.doubts.size() > 20);
  const auto At = [&](double x_m) {
    return std::ranges::min(open.doubts, {}, [&](const Doubt& doubt) { return std::abs(doubt.at.x_m - x_m); }).off_m;
  };
  CHECK(At(32.0) > 1.5 * At(12.0));  // a map is laid on the building by its middle
  CHECK(std::ranges::max(open.doubts, {}, &Doubt::off_m).off_m == Approx(open.most_m).epsilon(0.5));
  CHECK(error(Drive().Add(4000)).doubts.size() <= MapError::kMostDoubts);
}

namespace {

/// Three sides of a square of 40 m. On the second the robot seemed to stand for ten seconds, and may have driven on.
KeyframeGraph DriveRoundThreeSides(double along_m) {
  KeyframeGraph graph;
  std::int64_t utime = 0;
  for (int i = 0; i <= 300; ++i) {
    Keyframe keyframe;
    keyframe.utime = utime += (i == 150 ? 10 : 1) * kSecond_us;
    keyframe.walls.sigma.x_m = along_m;
    if (i > 0) keyframe.T_previous_this = {0.4, 0.0, i == 100 || i == 200 ? kPi / 2 : 0.0};
    if (i == 150) keyframe.degenerate_axis = {1.0, 0.0};
    graph.Add(std::move(keyframe));
  }
  return graph;
}

}  // namespace

TEST_CASE("the drive that would tell most leads across what is open, and a loop there leaves no more than it says") {
  KeyframeGraph graph = DriveRoundThreeSides(kNothing_m);
  GraphConstants constants;
  constants.edges.step.yaw_rad = constants.edges.walls = 1e-5;  // nothing but the open side matters
  const MapError error = *Estimate(graph, {true}, constants);
  REQUIRE(error.way_back);
  const auto& [from, to, then_m] = *error.way_back;
  CHECK(then_m < 0.67 * error.most_m);
  const double drive_m = std::hypot(from.x_m - to.x_m, from.y_m - to.y_m);
  CHECK(drive_m > 10.0);  // not along the open side once more
  CHECK(drive_m < 60.0);
  CHECK_FALSE(Estimate(DriveRoundThreeSides(1e-3), {true}, constants)->way_back);  // nothing is open
  GraphConstants none = constants;
  none.map_error.way_back_m = 1e3;
  CHECK_FALSE(Estimate(graph, {true}, none)->way_back);
  const auto Nearest = [&](const Point& place) {
    return std::ranges::min(graph.ids(), {}, [&](KeyframeId id) {
      return std::hypot(graph.pose(id).x_m - place.x_m, graph.pose(id).y_m - place.y_m);
    });
  };
  const KeyframeId older = std::min(Nearest(from), Nearest(to)), newer = std::max(Nearest(from), Nearest(to));
  graph.AddLoop({older, newer, Inverse(graph.pose(older)) * graph.pose(newer)});
  CHECK(Estimate(graph, {true}, constants)->most_m < then_m);
}

TEST_CASE("a slip is the step that loops moved most, on the map that is shown") {
  KeyframeGraph graph;
  for (int i = 0; i < 40; ++i) {
    Keyframe keyframe;
    keyframe.utime = (i + 1) * kSecond_us;
    if (i > 0) keyframe.T_previous_this = {i == 20 ? 1.3 : 0.4, 0.0, 0.0};
    if (i == 20) keyframe.degenerate_axis = {1.0, 0.0}, keyframe.walls.sigma.x_m = kNothing_m;
    graph.Add(std::move(keyframe));
  }
  CHECK_FALSE(FindSlip(graph, graph.poses(), {true}, 0.3));
  for (const int i : {5, 10, 15}) graph.AddLoop({{0, i}, {0, i + 20}, {0.4 * 20, 0.0, 0.0}});
  CHECK(graph.Optimise().empty());
  const auto slip = FindSlip(graph, graph.poses(), {true}, 0.3);
  REQUIRE(slip);
  CHECK(slip->off_m == Approx(0.9).margin(0.1));
  CHECK(slip->at.x_m == Approx(8.0).margin(0.1));
  CHECK_FALSE(FindSlip(graph, graph.poses(), {false}, 0.3));
  CHECK_FALSE(FindSlip(graph, graph.poses(), {true}, 1.0));
}

TEST_CASE(
    "what walls told of a match is along the axis of its covariance, laser frame, without what the map is good for") {
  const WallSigma ahead = FindWallSigma(MatchedWith(0.04, 0.0, 0.0001, 0.0));
  CHECK(std::abs(ahead.axis[0]) == Approx(1.0));
  CHECK(ahead.sigma.x_m == Approx(0.2));
  CHECK(ahead.sigma.y_m == Approx(0.01));
  CHECK(ahead.sigma.yaw_rad == Approx(0.02));
  const WallSigma turned = FindWallSigma(MatchedWith(0.04, 0.0, 0.0001, kPi / 2));
  CHECK(std::abs(turned.axis[1]) == Approx(1.0));
  const WallSigma aslant = FindWallSigma(MatchedWith(0.02, 0.019, 0.02, 0.0));
  CHECK(aslant.axis[0] * aslant.axis[1] == Approx(0.5));
  CHECK(aslant.sigma.x_m == Approx(std::sqrt(0.039)));
}

}  // namespace crsm
