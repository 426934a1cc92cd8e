#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "common/math/random.hpp"
#include "synthetic_scans.hpp"

// How the matcher searches as it ships: with the parameters that nobody set.

namespace crsm {
namespace {

/// A hall full of things of which no two stand or look alike, without a wall along which a climb could slide.
std::vector<Wall> MakeHall() {
  std::vector<Wall> walls;
  Random random(5);
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      const double x_m = 1.1 * i + random.Uniform(-0.3, 0.3);
      const double y_m = 1.1 * j + random.Uniform(-0.3, 0.3);
      const double side_m = random.Uniform(0.1, 0.4);
      if (j == 0 && i >= -1 && i <= 3) continue;  // where the robot drives
      const Point corners[] = {
          {x_m, y_m}, {x_m + side_m, y_m}, {x_m + side_m, y_m + side_m}, {x_m, y_m + side_m}, {x_m, y_m}};
      for (int k = 0; k < 4; ++k) walls.push_back({corners[k], corners[k + 1]});
    }
  }
  return walls;
}

/// The hall, and a matcher that knows it from a drive of 3.5 m.
class Hall {
 public:
  Hall() {
    MapUpdater updater(UpdateParameters{});
    for (int k = 0; k < 12; ++k) {
      const ScanMatch match = MatchedAt(k, {0.3 * k - 0.5, 0.3 * (k % 3) - 0.3, 0.0});
      matcher_.Apply(updater.Update(ShippedRays(ScanWalls(walls_, match.T_map_laser, k)), match).tiles);
    }
  }

  LaserScan Scan(const Pose2& truth, std::int64_t utime) const { return ScanWalls(walls_, truth, utime); }

  ScanMatch Match(const LaserScan& scan, const TrackingState& tracking) const {
    return matcher_.Match(ShippedRays(scan), tracking, {});
  }

  ScanMatch Match(const Pose2& truth, std::int64_t utime, const TrackingState& tracking) const {
    return Match(Scan(truth, utime), tracking);
  }

  /// Of 60 scans taken so far from where the robot was last seen, `num_lost` scans ago, and some time after the last
  /// one: how many are found.
  int CountFound(double way_m, int num_lost, std::int64_t after_us = 1000) const {
    const TrackingState tracking = AfterStanding({}, kUsual, num_lost);
    int num_found = 0;
    for (int k = 0; k < 60; ++k) {
      const Pose2 truth{way_m, 0.1 * (k % 5) - 0.2, k % 2 == 0 ? 0.1 : -0.1};
      const ScanMatch match = Match(truth, after_us + k, tracking);
      num_found += match.state != MatchState::kLost && std::abs(match.T_map_laser.x_m - way_m) < 0.05;
    }
    return num_found;
  }

  static constexpr double kUsual = 0.64;  ///< fitness of a scan that fits well in this hall

 private:
  std::vector<Wall> walls_ = MakeHall();
  RrhcMatcher matcher_{MatchParameters{}, 0.05};
};

/// A matcher that knows a niche from a drive.
RrhcMatcher MakeNicheMatcher(const MatchConstants& constants) {
  RrhcMatcher matcher({}, 0.05, constants);
  MapUpdater updater(UpdateParameters{});
  for (int k = 0; k < 6; ++k) {
    const ScanMatch match = MatchedAt(k, {0.31 * k - 1.0, 0.1 * k, 0.0});
    matcher.Apply(updater.Update(ShippedRays(ScanNiche(match.T_map_laser, k)), match).tiles);
  }
  return matcher;
}

}  // namespace

TEST_CASE("as shipped, a robot that turned or was pushed further than the window is found by the wide search") {
  const Hall hall;
  const TrackingState standing = AfterStanding({}, Hall::kUsual);
  for (const Pose2& truth : {Pose2{0.4, -0.3, 1.1}, {-0.3, 0.2, -1.0}, {0.5, 0.3, 0.7}}) {
    const ScanMatch match = hall.Match(truth, 100, standing);
    CHECK(match.state != MatchState::kLost);
    CheckPose(match.T_map_laser, truth, 0.025);  // half a cell
    CHECK(match.evaluations > MatchConstants{}.search.num_evaluations);
  }
}

TEST_CASE("as shipped, most scans that fit as well as the last ones are found by a few short climbs") {
  const RrhcMatcher matcher = MakeNicheMatcher({});
  int num_short = 0;
  for (int k = 0; k < 20; ++k) {
    const Pose2 truth{0.02 * k - 0.2, 0.01 * k - 0.1, 0.005 * k};
    const ScanMatch match = matcher.Match(ShippedRays(ScanNiche(truth, 100 + k)), AfterStanding({}, 0.8), {});
    CheckPose(match.T_map_laser, truth, 0.025);  // half a cell
    CHECK(match.fitness > 0.8);
    num_short += match.evaluations < MatchConstants{}.search.num_evaluations / 2;
  }
  CHECK(num_short > 10);
}

TEST_CASE("as shipped, a robot is looked for the further away the longer ago it was matched") {
  const Hall hall;
  // The window is 0.6 m at once, and 0.4 m more for each second, up to 1.6 m; what is found in it has moved by up to
  // 0.3 m more at the end of the climb.
  constexpr std::int64_t kSecond_us = 1'000'000;
  struct Case {
    double way_m;
    std::int64_t after_us;
    int least, most;
  };
  for (const Case& a : {Case{0.5, 1000, 58, 60},
                        {1.1, 1000, 0, 6},
                        {0.9, kSecond_us, 58, 60},
                        {1.5, kSecond_us, 0, 6},
                        {1.5, 4 * kSecond_us, 58, 60},
                        {2.1, 10 * kSecond_us, 0, 6}}) {
    for (const int num_lost : {0, 3}) {
      CAPTURE(a.way_m, a.after_us, num_lost);
      const int num_found = hall.CountFound(a.way_m, num_lost, a.after_us);
      CHECK((num_found >= a.least && num_found <= a.most));
    }
  }
}

TEST_CASE("as shipped, a robot that is not near the guess is found only where most of its rays agree with the map") {
  const Hall hall;
  const auto StateAfter = [&](std::size_t num_new_of_ten) {
    LaserScan scan = hall.Scan({0.4, -0.3, 1.1}, 100);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (i % 10 < num_new_of_ten) scan.ranges_m[i] *= 0.6f;
    }
    return hall.Match(scan, AfterStanding({}, Hall::kUsual)).state;
  };
  CHECK(StateAfter(2) != MatchState::kLost);
  CHECK(StateAfter(5) == MatchState::kLost);
}

TEST_CASE("as shipped, a robot that drives on into the open is not lost for what it has not seen yet") {
  const Hall hall;
  const auto Match = [&](const Pose2& truth, int num_lost, double share_new) {
    LaserScan scan = hall.Scan(truth, 100);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const bool is_new = static_cast<double>(i) < share_new * static_cast<double>(scan.ranges_m.size());
      if (is_new) scan.ranges_m[i] = 20.0f;  // beyond all that is explored
    }
    return hall.Match(scan, AfterStanding({}, Hall::kUsual, num_lost));
  };
  const Pose2 near{0.1, 0.05, 0.03};
  const ScanMatch match = Match(near, 0, 0.65);
  CHECK(match.state != MatchState::kLost);
  CheckPose(match.T_map_laser, near, 0.1);                              // by a third of the rays
  CHECK(Match(near, 0, 0.8).state == MatchState::kLost);                // what is left may be chance
  CHECK(Match(near, 1, 0.75).state == MatchState::kLost);               // it may have stopped, or turned
  CHECK(Match({-0.3, -0.2, 1.0}, 0, 0.65).state == MatchState::kLost);  // in a wide window it may be chance, too
}

}  // namespace crsm
