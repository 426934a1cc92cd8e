#include "common/match/global_search.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "common/scan/hits.hpp"
#include "common/scan/ray_selection.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// A map in which scans are looked for.
struct TestMap {
  template <class Paint>
  TestMap(int low, int high, Paint&& paint, double cell_size_m = 0.05) : map(PaintMap(low, high, paint, cell_size_m)) {}

  GlobalMatch Search(const LaserScan& scan) const {
    const ValidRays rays = FindValidRays(scan, TestParameters().scan);
    const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
    return SearchWholeMap(map, hits_m, hits_m(Eigen::all, SelectRays(rays, 90)));
  }

  ScoredMap map;
};

TestMap Niche() { return TestMap(-1, 1, NicheByte); }
TestMap Room() { return TestMap(-1, 1, RoomByte); }

Eigen::Matrix2Xd Hits(const LaserScan& scan) { return ComputeHits(FindValidRays(scan, TestParameters().scan)); }

}  // namespace

TEST_CASE("a scan taken anywhere in a room that is like no other is found within half a cell") {
  const TestMap map = Niche();
  Random random(3);
  for (int i = 0; i < 30; ++i) {
    const Pose2 truth{random.Uniform(-2.7, 1.7), random.Uniform(-1.7, 2.7), random.Uniform(-kPi, kPi)};
    CAPTURE(truth.x_m, truth.y_m, truth.yaw_rad);
    const GlobalMatch match = map.Search(ScanNiche(truth));
    CHECK(match.IsConvincing());
    CHECK(match.T_map_laser.x_m == Approx(truth.x_m).margin(0.025));
    CHECK(match.T_map_laser.y_m == Approx(truth.y_m).margin(0.025));
    CHECK(std::abs(WrapAngle(match.T_map_laser.yaw_rad - truth.yaw_rad)) < 0.01);  // 0.025 m at the walls
  }
}

TEST_CASE("half the beams of a scan suffice, where they see enough") {
  LaserScan scan = ScanNiche({0.5, 0.5, 1.0});
  for (std::size_t i = 0; i < scan.ranges_m.size() / 2; ++i) scan.ranges_m[i] = 0.0f;
  const GlobalMatch match = Niche().Search(scan);
  CHECK(match.T_map_laser.x_m == Approx(0.5).margin(0.025));
  CHECK(match.T_map_laser.y_m == Approx(0.5).margin(0.025));
}

TEST_CASE("a room that is alike from both ends convinces nobody, and the runner-up is the other end") {
  const GlobalMatch match = Room().Search(ScanRoom({-2.0, 1.0, 0.3}));
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
  const GlobalMatch match = field.Search(ScanNiche({}));  // in 512 x 512 cells
  CHECK(match.evaluations > 1000000);
  CHECK(match.evaluations < 10000 * 120 + 5000 * 1000);
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
    const GlobalMatch match = SearchWholeMap(map.map, hits_m, hits_m);
    CHECK(match.score >= 0.0);
    CHECK(match.score <= 1.0);
  }
}

TEST_CASE("agreement is the share of rays that reach the wall that they measured, and no other") {
  const TestMap map = Niche();
  const Pose2 pose{-1.0, 0.5, 0.4};
  const LaserScan scan = ScanNiche(pose);
  const auto Agreement = [&](const TestMap& on, const LaserScan& of) {
    return ComputeAgreement(on.map.cells(), Hits(of), pose);
  };
  CHECK(Agreement(map, scan) > 0.98);
  CHECK(ComputeAgreement(map.map.cells(), Eigen::Matrix2Xd(2, 0), pose) == 0.0);
  LaserScan short_of = scan;  // every other ray ends in the free
  for (std::size_t i = 0; i < scan.ranges_m.size(); i += 2) short_of.ranges_m[i] *= 0.5f;
  CHECK(Agreement(map, short_of) == Approx(0.5).margin(0.02));
  LaserScan beyond = scan;  // every ray goes on behind the wall
  for (float& range_m : beyond.ranges_m) range_m += 0.5f;
  CHECK(Agreement(map, beyond) < 0.02);
  // A scan of the whole room goes through the block where there is one: where rays end, it is unexplored.
  CHECK(Agreement(Room(), ScanRoom(pose)) > 0.98);
  CHECK(Agreement(map, ScanRoom(pose)) < 0.95);
}

TEST_CASE("each direction of a place is tried once, wherever the circle begins") {
  // One free place, and a wall 4 m west, south or east of it, which one ray sees: one direction to climb from.
  const auto Evaluations = [](int x, int y) {
    const auto Paint = [=](Cell cell) {
      const auto IsAt = [&](int there_x, int there_y) { return cell.x >> 2 == there_x && cell.y >> 2 == there_y; };
      return IsAt(x, y) ? kOccupiedByte : IsAt(0, 0) ? kFreeByte : kUnexploredByte;
    };
    const Eigen::Matrix2Xd hits_m = Eigen::Vector2d(4.0, 0.0);
    const GlobalMatch match = SearchWholeMap(TestMap(-2, 1, Paint).map, hits_m, hits_m);
    CHECK(std::abs(WrapAngle(match.T_map_laser.yaw_rad - std::atan2(y, x))) < 0.05);
    return match.evaluations;
  };
  const int east = Evaluations(20, 0);
  CHECK(east > 120);
  CHECK(std::abs(Evaluations(-20, 0) - east) < 10);
  CHECK(std::abs(Evaluations(0, -20) - east) < 10);
}

TEST_CASE("a map that lies elsewhere by whole tiles is searched in the same way") {
  // Cells have negative coordinates in one, positive ones in the other: larger cells must hold the same of them.
  const auto Elsewhere = [](int tiles) {
    return TestMap(tiles - 1, tiles + 1, [=](Cell cell) {
      return NicheByte({cell.x - 64 * tiles, cell.y - 64 * tiles});
    });
  };
  const LaserScan scan = ScanNiche({-1.3, 0.7, 0.9});
  const GlobalMatch here = Elsewhere(0).Search(scan);
  for (const int tiles : {-10, 10}) {
    const GlobalMatch there = Elsewhere(tiles).Search(scan);
    CHECK(there.evaluations == Approx(here.evaluations).epsilon(1e-4));  // poses are rounded elsewhere
    CHECK(there.T_map_laser.x_m == Approx(here.T_map_laser.x_m + 3.2 * tiles).margin(1e-9));
    CHECK(there.T_map_laser.y_m == Approx(here.T_map_laser.y_m + 3.2 * tiles).margin(1e-9));
    CHECK(there.T_map_laser.yaw_rad == here.T_map_laser.yaw_rad);
    CHECK(there.score == here.score);
    CHECK(there.runner_up == here.runner_up);
  }
}

TEST_CASE(
    "what was within 0.3 m of the laser when the map was made does not hide the walls behind it; a wall so near is "
    "agreed with") {
  const Pose2 pose{-1.0, 0.5, 0.0};
  const Eigen::Matrix2Xd hits_m = Hits(ScanNiche(pose));
  const auto AgreementBehind = [&](double range_m) {  // of something all round the laser
    const auto Paint = [&](Cell cell) {
      const double away_m = std::hypot((cell.x + 0.5) * 0.05 - pose.x_m, (cell.y + 0.5) * 0.05 - pose.y_m);
      return std::abs(away_m - range_m) < 0.05 ? kOccupiedByte : NicheByte(cell);
    };
    return ComputeAgreement(PaintMap(-1, 1, Paint), hits_m, pose);
  };
  CHECK(AgreementBehind(0.2) > 0.98);   // the hand of who carried it
  CHECK(AgreementBehind(0.42) < 0.02);  // a wall
  const Pose2 near{kRoomLeftM + 0.12, 0.5, 0.0};
  // Half of the rays end at the near wall. Some of those along it end between two steps of the way.
  CHECK(ComputeAgreement(Room().map.cells(), Hits(ScanRoom(near)), near) > 0.95);
}

TEST_CASE("a place convinces if it fits at all, and the next best one fits clearly less") {
  const auto Convinces = [](double score, double runner_up) {
    return GlobalMatch{{}, score, runner_up, 1}.IsConvincing();
  };
  CHECK(Convinces(0.46, 0.0));
  CHECK_FALSE(Convinces(0.44, 0.0));
  for (const double score : {0.5, 0.7, 1.0}) {
    CHECK(Convinces(score, 0.79 * score));
    CHECK_FALSE(Convinces(score, 0.81 * score));
  }
}

}  // namespace crsm
