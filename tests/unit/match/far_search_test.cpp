#include "common/match/far_search.hpp"

#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// A room of 8 m by 6 m with a niche, as a map of hits; and what a laser sees of its walls.
std::vector<Eigen::Vector2d> RoomWalls() {
  std::vector<Eigen::Vector2d> points;
  const auto Line = [&](double x1, double y1, double x2, double y2) {
    const double way = std::hypot(x2 - x1, y2 - y1);
    for (double at = 0.0; at < way; at += 0.05)
      points.emplace_back(x1 + at * (x2 - x1) / way, y1 + at * (y2 - y1) / way);
  };
  Line(-4.0, -3.0, 4.0, -3.0);
  Line(4.0, -3.0, 4.0, 3.0);
  Line(4.0, 3.0, 1.0, 3.0);
  Line(1.0, 3.0, 1.0, 1.5);
  Line(1.0, 1.5, -1.0, 1.5);
  Line(-1.0, 1.5, -1.0, 3.0);
  Line(-1.0, 3.0, -4.0, 3.0);
  Line(-4.0, 3.0, -4.0, -3.0);
  return points;
}

/// Two walls that have no end.
std::vector<Eigen::Vector2d> CorridorWalls() {
  std::vector<Eigen::Vector2d> points;
  for (double x = -20.0; x < 20.0; x += 0.05) {
    points.emplace_back(x, -1.0);
    points.emplace_back(x, 1.0);
  }
  return points;
}

ByteMap MapOf(const std::vector<Eigen::Vector2d>& walls) {
  ByteMap map(0.05);
  for (const Eigen::Vector2d& at : walls) map.Set(map.geometry().CellAt(at.x(), at.y()), kOccupiedByte);
  return map;
}

Eigen::Matrix2Xd SeenFrom(const std::vector<Eigen::Vector2d>& walls, const Pose2& laser, double reach_m) {
  std::vector<Eigen::Vector2d> seen;
  for (const Eigen::Vector2d& at : walls) {
    const Pose2 hit = Inverse(laser) * Pose2{at.x(), at.y(), 0.0};
    if (std::hypot(hit.x_m, hit.y_m) < reach_m) seen.emplace_back(hit.x_m, hit.y_m);
  }
  Eigen::Matrix2Xd hits_m(2, static_cast<Eigen::Index>(seen.size()));
  for (std::size_t i = 0; i < seen.size(); ++i) hits_m.col(static_cast<Eigen::Index>(i)) = seen[i];
  return hits_m;
}

std::vector<ScanMatch> DriveAt(double step_m, double turn_rad, std::int64_t period_us) {
  std::vector<ScanMatch> recent;
  Pose2 pose;
  for (int i = 0; i < 5; ++i, pose = pose * Pose2{step_m, 0.0, turn_rad})
    recent.push_back(MatchedAt(i * period_us, pose));
  return recent;
}

}  // namespace

TEST_CASE("the window follows from the time between scans, and from how the robot moved and turned") {
  constexpr std::int64_t kSecond_us = 1'000'000;
  const auto Window = [](const std::vector<ScanMatch>& recent, std::int64_t later_us) {
    return FindFarWindow(recent, recent.back().utime + later_us);
  };
  CHECK_FALSE(Window(DriveAt(0.1, 0.0, 200'000), 200'000));
  CHECK_FALSE(Window(DriveAt(0.1, 0.0, 200'000), kSecond_us));  // a pause
  CHECK_FALSE(FindFarWindow({}, kSecond_us));
  const auto slow = Window(DriveAt(0.2, 0.1, kSecond_us), kSecond_us);
  const auto fast = Window(DriveAt(1.0, 0.1, kSecond_us), kSecond_us);
  const auto turning = Window(DriveAt(0.2, 0.6, kSecond_us), kSecond_us);
  const auto later = Window(DriveAt(0.2, 0.1, kSecond_us), 2 * kSecond_us);
  REQUIRE((slow && fast && turning && later));
  CHECK(fast->reach_m == Approx(slow->reach_m + 0.8));
  CHECK(turning->reach_rad == Approx(slow->reach_rad + 0.5));
  CHECK(later->reach_m > slow->reach_m);
  CHECK(later->reach_rad > slow->reach_rad);
  CHECK(Window(DriveAt(20.0, 3.0, kSecond_us), 100 * kSecond_us)->reach_m <= 3.0);
  std::vector<ScanMatch> lost = DriveAt(0.2, 0.1, kSecond_us);
  lost.back().state = MatchState::kLost;
  CHECK_FALSE(Window(lost, kSecond_us));
}

TEST_CASE("a place that is metres from where it is guessed is found") {
  const auto walls = RoomWalls();
  const ByteMap map = MapOf(walls);
  for (const Pose2& truth : {Pose2{1.4, -0.8, 0.7}, {-1.6, -1.2, -0.9}, {0.3, 0.2, 0.1}}) {
    const auto found = SearchFar(map, SeenFrom(walls, truth, 10.0), {}, {2.0, 1.2});
    REQUIRE(found);
    CheckPose(*found, truth, 0.25);  // two cells, and what is left of the next search
  }
}

TEST_CASE("where all is alike along the way, or too little fits, nothing is found") {
  const auto walls = CorridorWalls();
  CHECK_FALSE(SearchFar(MapOf(walls), SeenFrom(walls, {1.0, 0.0, 0.1}, 8.0), {}, {2.0, 0.5}));
  const auto room = RoomWalls();
  CHECK_FALSE(SearchFar(MapOf(walls), SeenFrom(room, {}, 10.0), {}, {2.0, 1.2}));
  CHECK_FALSE(SearchFar(MapOf(room), Eigen::Matrix2Xd(2, 0), {}, {2.0, 1.2}));
  CHECK_FALSE(SearchFar(ByteMap(0.05), SeenFrom(room, {}, 10.0), {}, {2.0, 1.2}));
}

}  // namespace crsm
