#include "common/match/judge/census.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/scan/hits.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// Free from x = 0 to 4 m, a wall at x = 4 m, of so many cells; unexplored beyond.
ByteMap MakeMap(int wall_cells) {
  ByteMap map(0.05);
  for (int x = 0; x < 80 + wall_cells; ++x) {
    for (int y = -40; y <= 40; ++y) map.Set({x, y}, x >= 80 ? 0 : 255);
  }
  return map;
}

RayFate FateOf(double x_m, double y_m, int wall_cells = 1) {
  const ByteMap map = MakeMap(wall_cells);
  return RayReader(map).FindFate({1.0, 0.0, 0.0}, {x_m, y_m});
}

Eigen::Matrix2Xd Hits(const LaserScan& scan) { return ComputeHits(FindValidRays(scan, TestParameters().scan)); }

ByteMap NicheMap() { return PaintMap(-1, 1, NicheByte); }
ByteMap RoomMap() { return PaintMap(-1, 1, RoomByte); }

}  // namespace

TEST_CASE("a ray fits, passes through a wall, contradicts the map, or ends in what is unexplored") {
  CHECK(FateOf(3.0, 0.0) == RayFate::kFits);
  CHECK(FateOf(2.9, 0.0) == RayFate::kFits);         // nearly
  CHECK(FateOf(3.1, 0.0) == RayFate::kFits);         // just behind the wall
  CHECK(FateOf(2.0, 0.0) == RayFate::kContradicts);  // before it
  CHECK(FateOf(-3.0, 0.0) == RayFate::kUnknown);
  CHECK(FateOf(5.0, 0.1, 2) == RayFate::kPasses);
  CHECK(FateOf(5.0, 0.1, 1) == RayFate::kUnknown);  // a single cell may be an error of drawing
  CHECK(FateOf(3.4, 0.0, 2) == RayFate::kUnknown);  // just before its end it may touch a wall
  CHECK(FateOf(1e7, 0.0, 2) == RayFate::kUnknown);  // beyond the limits of any map
  const ByteMap empty(0.05);
  CHECK(RayReader(empty).FindFate({}, {1.0, 0.0}) == RayFate::kUnknown);
}

TEST_CASE("the shares of rays are counted in the frame of the map") {
  Eigen::Matrix2Xd hits_m(2, 4);
  hits_m << 0.0, 0.0, 0.5, 1.0, -3.0, -2.0, -1.0, 4.0;
  const Census census = CountRays(MakeMap(1), hits_m, {1.0, 0.0, kPi / 2.0});
  CHECK(census.fits == Approx(0.25));
  CHECK(census.contradicts == Approx(0.5));
  CHECK(census.unknown == Approx(0.25));
  CHECK(census.passes == 0.0);
  CHECK(FindUnexploredShare(MakeMap(1), hits_m, {1.0, 0.0, kPi / 2.0}) == Approx(0.25));
  const Census none = CountRays(MakeMap(1), Eigen::Matrix2Xd(2, 0), {});
  CHECK(none.fits + none.contradicts + none.unknown + none.passes == 0.0);
  CHECK(FindUnexploredShare(MakeMap(1), Eigen::Matrix2Xd(2, 0), {}) == 0.0);
}

TEST_CASE("a scan agrees with the map in which it was taken, and not with another") {
  const ByteMap map = NicheMap();
  const Pose2 pose{-1.0, 0.5, 0.4};
  const LaserScan scan = ScanNiche(pose);
  const auto Agreement = [&](const ByteMap& on, const LaserScan& of) { return CountRays(on, Hits(of), pose).fits; };
  CHECK(Agreement(map, scan) > 0.98);
  LaserScan short_of = scan;  // every other ray ends in the free
  for (std::size_t i = 0; i < scan.ranges_m.size(); i += 2) short_of.ranges_m[i] *= 0.5f;
  CHECK(Agreement(map, short_of) == Approx(0.5).margin(0.02));
  LaserScan beyond = scan;  // every ray goes on behind the wall
  for (float& range_m : beyond.ranges_m) range_m += 0.5f;
  CHECK(Agreement(map, beyond) < 0.02);
  // A scan of the whole room goes through the block where there is one: where rays end, it is unexplored.
  CHECK(Agreement(RoomMap(), ScanRoom(pose)) > 0.98);
  CHECK(Agreement(map, ScanRoom(pose)) < 0.95);
}

TEST_CASE("a wall that is nearer than the tolerance is agreed with") {
  const Pose2 near{kRoomLeftM + 0.12, 0.5, 0.0};
  // Half of the rays end at the near wall. Some of those along it end between two steps of the way.
  CHECK(CountRays(RoomMap(), Hits(ScanRoom(near)), near).fits > 0.95);
}

}  // namespace crsm
