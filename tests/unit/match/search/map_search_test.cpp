#include "common/match/search/map_search.hpp"

#include <cmath>
#include <utility>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/math/random.hpp"
#include "common/scan/hits.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// A map in which scans are looked for.
struct TestMap {
  template <class Paint>
  TestMap(int low, int high, Paint&& paint, double cell_size_m = 0.05) : map(PaintMap(low, high, paint, cell_size_m)) {}

  FoundOnMap Search(const LaserScan& scan) const {
    const ValidRays rays = FindValidRays(scan, TestParameters().scan);
    return SearchWholeMap(map, ComputeHits(rays));
  }

  ScoredMap map;
};

TestMap Niche() { return TestMap(-1, 1, NicheByte); }
TestMap Room() { return TestMap(-1, 1, RoomByte); }

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

ScoredMap MapOf(const std::vector<Eigen::Vector2d>& walls) {
  ByteMap map(0.05);
  for (const Eigen::Vector2d& at : walls) map.Set(map.geometry().CellAt(at.x(), at.y()), kOccupiedByte);
  return ScoredMap(std::move(map));
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
    return FindReach(recent, recent.back().utime + later_us);
  };
  CHECK(FindReach({}, kSecond_us).reach_m == MatchConstants::MapSearch{}.least_m);
  const PlaceReach slow = Window(DriveAt(0.2, 0.1, kSecond_us), kSecond_us);
  CHECK(Window(DriveAt(1.0, 0.1, kSecond_us), kSecond_us).reach_m == Approx(slow.reach_m + 0.8));
  CHECK(Window(DriveAt(0.2, 0.3, kSecond_us), 100'000).reach_rad ==
        Approx(Window(DriveAt(0.2, 0.1, kSecond_us), 100'000).reach_rad + 0.2));
  const PlaceReach later = Window(DriveAt(0.2, 0.1, kSecond_us), 2 * kSecond_us);
  CHECK(later.reach_m > slow.reach_m);
  CHECK(Window(DriveAt(20.0, 3.0, kSecond_us), 100 * kSecond_us).reach_m <= 3.0);
  CHECK(Window(DriveAt(20.0, 3.0, kSecond_us), 100 * kSecond_us).reach_rad <= 1.6);
}

TEST_CASE("a place that is metres from where it is guessed is found") {
  const auto walls = RoomWalls();
  const ScoredMap map = MapOf(walls);
  for (const Pose2& truth : {Pose2{1.4, -0.8, 0.7}, {-1.6, -1.2, -0.9}, {0.3, 0.2, 0.1}}) {
    const FoundOnMap found = SearchMap(map, SeenFrom(walls, truth, 10.0), {{}, 2.0, 1.2});
    CHECK(found.score > 0.5);
    CheckPose(found.T_map_laser, truth, 0.05);
  }
}

TEST_CASE("where all is alike along the way another place scores as much, and where too little fits nothing is found") {
  const auto walls = CorridorWalls();
  const FoundOnMap found = SearchMap(MapOf(walls), SeenFrom(walls, {1.0, 0.0, 0.1}, 8.0), {{}, 2.0, 0.5});
  CHECK(found.runner_up > 0.8 * found.score);
  const auto room = RoomWalls();
  const auto Score = [](const ScoredMap& map, const Eigen::Matrix2Xd& hits_m) {
    return SearchMap(map, hits_m, {{}, 2.0, 1.2}).score;
  };
  CHECK(Score(MapOf(walls), SeenFrom(room, {}, 10.0)) < 0.05);
  CHECK(Score(MapOf(room), Eigen::Matrix2Xd(2, 0)) == 0.0);
  CHECK(Score(ScoredMap(0.05), SeenFrom(room, {}, 10.0)) == 0.0);
}

TEST_CASE("a scan taken anywhere in a room that is like no other is found within half a cell") {
  const TestMap map = Niche();
  Random random(3);
  for (int i = 0; i < 30; ++i) {
    const Pose2 truth{random.Uniform(-2.7, 1.7), random.Uniform(-1.7, 2.7), random.Uniform(-kPi, kPi)};
    CAPTURE(truth.x_m, truth.y_m, truth.yaw_rad);
    const FoundOnMap match = map.Search(ScanNiche(truth));
    CHECK(match.IsConvincing());
    CHECK(match.T_map_laser.x_m == Approx(truth.x_m).margin(0.025));
    CHECK(match.T_map_laser.y_m == Approx(truth.y_m).margin(0.025));
    CHECK(std::abs(WrapAngle(match.T_map_laser.yaw_rad - truth.yaw_rad)) < 0.01);  // 0.025 m at the walls
  }
}

TEST_CASE("half the beams of a scan suffice, where they see enough") {
  LaserScan scan = ScanNiche({0.5, 0.5, 1.0});
  for (std::size_t i = 0; i < scan.ranges_m.size() / 2; ++i) scan.ranges_m[i] = 0.0f;
  const FoundOnMap match = Niche().Search(scan);
  CHECK(match.T_map_laser.x_m == Approx(0.5).margin(0.025));
  CHECK(match.T_map_laser.y_m == Approx(0.5).margin(0.025));
}

TEST_CASE("a room that is alike from both ends convinces nobody, and the runner-up is the other end") {
  const FoundOnMap match = Room().Search(ScanRoom({-2.0, 1.0, 0.3}));
  CHECK_FALSE(match.IsConvincing());
  CHECK(match.score > 0.7);
  CHECK(match.runner_up == Approx(match.score).epsilon(0.05));
}

TEST_CASE("a scan of another building convinces nobody") {
  CHECK_FALSE(Room().Search(ScanNiche({0.5, 0.5, 1.0})).IsConvincing());
  LaserScan circle = ScanNiche({});
  circle.ranges_m.assign(circle.ranges_m.size(), 1.3f);
  CHECK_FALSE(Niche().Search(circle).IsConvincing());
}

TEST_CASE("without rays, or without a free place, nothing is found, and one ray has no place of its own") {
  CHECK(Niche().Search({1, -1.0f, 0.5f, {0.0f, 0.0f}}).score == 0.0);
  CHECK(TestMap(-1, 0, [](Cell) { return kOccupiedByte; }).Search(ScanNiche({})).score == 0.0);
  CHECK(TestMap(0, -1, NicheByte).Search(ScanNiche({})).score == 0.0);  // no tile
  LaserScan scan = ScanNiche({});
  for (std::size_t i = 1; i < scan.ranges_m.size(); ++i) scan.ranges_m[i] = 0.0f;
  CHECK_FALSE(Niche().Search(scan).IsConvincing());
}

TEST_CASE("the search takes a bounded number of evaluations on the largest places") {
  const TestMap field(
      -4, 3, [](Cell cell) { return cell.x % 50 == 0 ? kOccupiedByte : kFreeByte; }, 0.2);
  const FoundOnMap match = field.Search(ScanNiche({}));  // in 512 x 512 cells
  CHECK(match.evaluations < 8'100'000);
  CHECK_FALSE(match.IsConvincing());
}

TEST_CASE("cells from half a centimetre to a metre are searched") {
  for (const double cell_size_m : {0.005, 1.0}) {  // 7 m as 0.7 m, and as 140 m
    const TestMap map(-1, 1, NicheByte, cell_size_m);
    const double scale = cell_size_m / 0.05;
    LaserScan scan = ScanNiche({0.5, -0.5, 1.0});
    for (float& range_m : scan.ranges_m) range_m *= static_cast<float>(scale);
    ScanParameters all;
    all.range_max_m = 1000.0;
    const Eigen::Matrix2Xd hits_m = ComputeHits(FindValidRays(scan, all));
    const FoundOnMap match = SearchWholeMap(map.map, hits_m);
    CHECK(match.score >= 0.0);
    CHECK(match.score <= 1.0);
  }
}

TEST_CASE("a map that lies elsewhere by whole tiles is searched in the same way") {
  // Cells have negative coordinates in one, positive ones in the other: larger cells must hold the same of them.
  const auto Elsewhere = [](int tiles) {
    return TestMap(tiles - 1, tiles + 1, [=](Cell cell) {
      return NicheByte({cell.x - 64 * tiles, cell.y - 64 * tiles});
    });
  };
  const LaserScan scan = ScanNiche({-1.3, 0.7, 0.9});
  const FoundOnMap here = Elsewhere(0).Search(scan);
  for (const int tiles : {-10, 10}) {
    const FoundOnMap there = Elsewhere(tiles).Search(scan);
    CHECK(there.evaluations == Approx(here.evaluations).epsilon(1e-4));  // poses are rounded elsewhere
    CHECK(there.T_map_laser.x_m == Approx(here.T_map_laser.x_m + 3.2 * tiles).margin(1e-9));
    CHECK(there.T_map_laser.y_m == Approx(here.T_map_laser.y_m + 3.2 * tiles).margin(1e-9));
    CHECK(there.T_map_laser.yaw_rad == here.T_map_laser.yaw_rad);
    CHECK(there.score == here.score);
    CHECK(there.runner_up == here.runner_up);
  }
}

TEST_CASE("a place convinces if it fits at all, and the next best one fits clearly less") {
  const auto Convinces = [](double score, double runner_up) {
    return FoundOnMap{{}, score, runner_up, 1}.IsConvincing();
  };
  CHECK(Convinces(0.46, 0.0));
  CHECK_FALSE(Convinces(0.44, 0.0));
  for (const double score : {0.5, 0.7, 1.0}) {
    CHECK(Convinces(score, 0.74 * score));
    CHECK_FALSE(Convinces(score, 0.76 * score));
  }
}

}  // namespace crsm
