#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "common/math/random.hpp"
#include "synthetic_scans.hpp"

// How the matcher refines and judges as it ships: with the parameters that nobody set.

namespace crsm {
namespace {

/// A wall from one point to another, all of it turned about the origin.
Wall TurnedWall(const Pose2& turn, double from_x_m, double from_y_m, double to_x_m, double to_y_m) {
  const Pose2 from = turn * Pose2{from_x_m, from_y_m, 0.0};
  const Pose2 to = turn * Pose2{to_x_m, to_y_m, 0.0};
  return {{from.x_m, from.y_m}, {to.x_m, to.y_m}};
}

/// A corridor 2 m wide, whose ends the laser does not see, in that direction on the map.
std::vector<Wall> BareCorridor(double direction_rad) {
  const Pose2 turn{0.0, 0.0, direction_rad};
  return {TurnedWall(turn, -30.0, -1.0, 30.0, -1.0), TurnedWall(turn, -30.0, 1.0, 30.0, 1.0)};
}

/// The same, with its end 3 m ahead of the origin.
std::vector<Wall> DeadEnd() {
  return {{{-30.0, -1.0}, {3.0, -1.0}}, {{3.0, -1.0}, {3.0, 1.0}}, {{3.0, 1.0}, {-30.0, 1.0}}};
}

LaserScan WithNoise(LaserScan scan, double noise_m) {
  Random random(9, static_cast<std::uint64_t>(scan.utime));
  for (float& range_m : scan.ranges_m) {
    if (range_m > 0.0f) range_m += static_cast<float>(random.Uniform(-noise_m, noise_m));
  }
  return scan;
}

/// A matcher that knows walls from a drive of 5 m through the origin.
RrhcMatcher MatcherAmong(const std::vector<Wall>& walls, double direction_rad = 0.0) {
  RrhcMatcher matcher({}, 0.05);
  MapUpdater updater(UpdateParameters{});
  for (int k = 0; k < 12; ++k) {
    const double way_m = 0.4 * k - 3.2;
    const ScanMatch match = MatchedAt(k, {way_m * std::cos(direction_rad), way_m * std::sin(direction_rad), 0.0});
    matcher.Apply(updater.Update(ShippedRays(WithNoise(ScanWalls(walls, match.T_map_laser, k), 0.02)), match).tiles);
  }
  return matcher;
}

constexpr double kUsual = 0.8;  // fitness of scans that are matched on such maps

}  // namespace

TEST_CASE("as shipped, the initial guess tells how far along a corridor, where walls do not") {
  const std::vector<Wall> walls = BareCorridor(0.0);
  const RrhcMatcher matcher = MatcherAmong(walls);
  for (int k = 0; k < 10; ++k) {
    const LaserScan scan = WithNoise(ScanWalls(walls, {0.0, 0.1, 0.05}, 100 + k), 0.02);
    const ScanMatch match = matcher.Match(ShippedRays(scan), AfterStanding({}, kUsual), {});
    CHECK(match.state == MatchState::kDegenerate);
    CHECK(std::abs(match.T_map_laser.x_m) < 0.15);                         // the noise alone leads anywhere in 0.4 m
    CHECK(match.T_map_laser.y_m == Approx(0.1).margin(0.025));             // half a cell
    CHECK(match.T_map_laser.yaw_rad == Approx(0.05).margin(0.025 / 3.0));  // as much 3 m away
  }
}

TEST_CASE("as shipped, a match along a corridor says which axis is open, and its covariance is long there alone") {
  for (const double direction_rad : {0.0, 0.5, 1.3, -0.6}) {
    const std::vector<Wall> walls = BareCorridor(direction_rad);
    const ScanMatch match =
        MatcherAmong(walls, direction_rad).Match(ShippedRays(ScanWalls(walls, {}, 100)), AfterStanding({}, kUsual), {});
    CAPTURE(direction_rad);
    REQUIRE(match.state == MatchState::kDegenerate);
    const Eigen::Vector2d along(std::cos(direction_rad), std::sin(direction_rad));
    const Eigen::Vector2d axis(match.degenerate_axis[0], match.degenerate_axis[1]);
    CHECK(axis.norm() == Approx(1.0));
    CHECK(std::abs(axis.dot(along)) > 0.99);
    Eigen::Matrix2d position;
    position << match.covariance[0], match.covariance[1], match.covariance[1], match.covariance[3];
    const Eigen::Vector2d across(-along.y(), along.x());
    CHECK(std::sqrt(across.dot(position * across)) < 0.06);  // a cell
    CHECK(std::sqrt(along.dot(position * along)) > 0.12);    // more than twice that
  }
  const std::vector<Wall> end = DeadEnd();
  const ScanMatch match = MatcherAmong(end).Match(ShippedRays(ScanWalls(end, {}, 100)), AfterStanding({}, kUsual), {});
  CHECK(match.state == MatchState::kOk);
  CHECK(match.degenerate_axis == std::array<double, 2>{});
  CHECK(std::sqrt(match.covariance[0]) < 0.06);
}

TEST_CASE("as shipped, a pose that was found far off is not drawn back to where it was guessed to be") {
  const std::vector<Wall> walls = DeadEnd();
  const RrhcMatcher matcher = MatcherAmong(walls);
  // 0.6 m further on, and turned by more than the first window holds: the search of a window finds the end of the
  // corridor. The pull would draw it back, as the few rays that end there tell less than it costs.
  constexpr double kWay_m = 0.6;
  int num_found = 0;
  for (int k = 0; k < 20; ++k) {
    const LaserScan scan = WithNoise(ScanWalls(walls, {kWay_m, 0.0, 0.9}, 100 + k), 0.02);
    const ScanMatch match = matcher.Match(ShippedRays(scan), AfterStanding({}, kUsual), {});
    num_found += match.state == MatchState::kOk && std::abs(match.T_map_laser.x_m - kWay_m) < 0.025;  // half a cell
  }
  CHECK(num_found >= 15);
}

TEST_CASE("as shipped, where neither search explains a scan, the last climb is not held back by the pull either") {
  RrhcMatcher matcher({}, 0.05);
  REQUIRE(matcher.Apply(PaintTiles(-1, 1, NicheByte)));
  const Pose2 initial_guess{-1.0, 0.3, 0.0};
  int num_found = 0;
  for (int k = 0; k < 9; ++k) {  // beyond both windows, but a climb gets there
    const Pose2 truth{0.0, 0.1 + 0.1 * (k % 5), 0.1 * (k - 4)};
    const ScanMatch match =
        matcher.Match(ShippedRays(ScanNiche(truth, 1000 + k)), AfterStanding(initial_guess, 0.85), {});
    num_found += match.state == MatchState::kOk && std::abs(match.T_map_laser.x_m - truth.x_m) < 0.025;  // half a cell
  }
  CHECK(num_found >= 4);
}

TEST_CASE("as shipped, rays count by the contour that they stand for: what moved close by does not win by numbers") {
  // A room of 7 m, and 0.4 m to the left of the laser a board of 1.8 m: on it end a third of all rays, and twice as
  // many as on the wall to the right, which is three times as long.
  const auto Walls = [](double board_x_m) {
    return std::vector<Wall>{{{-3.0, -2.0}, {4.0, -2.0}},
                             {{4.0, -2.0}, {4.0, 3.0}},
                             {{4.0, 3.0}, {-3.0, 3.0}},
                             {{-3.0, 3.0}, {-3.0, -2.0}},
                             {{board_x_m, -0.9}, {board_x_m, 0.9}}};
  };
  RrhcMatcher matcher({}, 0.05);
  MapUpdater updater(UpdateParameters{});
  for (int k = 0; k < 8; ++k) {
    const ScanMatch match = MatchedAt(k, {0.3 * k, 0.0, 0.0});
    matcher.Apply(updater.Update(ShippedRays(ScanWalls(Walls(-0.4), match.T_map_laser, k)), match).tiles);
  }
  for (const double moved_m : {-0.1, 0.1}) {
    for (int k = 0; k < 5; ++k) {
      const LaserScan scan = ScanWalls(Walls(-0.4 + moved_m), {0.02, 0.01, 0.0}, 100 + k);
      const ScanMatch match = matcher.Match(ShippedRays(scan), AfterStanding({}, kUsual), {});
      CAPTURE(moved_m, k);
      CHECK(std::abs(match.T_map_laser.x_m - 0.02) <
            0.05);  // nearer to where the walls say than to where the board says
    }
  }
}

}  // namespace crsm
