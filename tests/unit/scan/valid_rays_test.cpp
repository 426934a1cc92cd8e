#include "common/scan/valid_rays.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

constexpr ScanParameters kLaser{.range_min_m = 0.1, .range_max_m = 10.0};

LaserScan Scan(std::vector<float> ranges_m) { return {1, -0.5f, 0.25f, std::move(ranges_m)}; }

}  // namespace

TEST_CASE("a scan without beams has no rays, hits or sparseness") {
  const ValidRays rays = FindValidRays(Scan({}), kLaser);
  CHECK(rays.size() == 0);
  CHECK(ComputeHits(rays).cols() == 0);
  CHECK(ComputeDisplacements(rays).empty());
  CHECK(ComputeMeanSparseness(rays) == 0.0);
}

TEST_CASE("one beam is one ray without sparseness") {
  const ValidRays rays = FindValidRays(Scan({2.0f}), kLaser);
  REQUIRE(rays.size() == 1);
  CHECK(rays.angle_rad[0] == -0.5f);
  CHECK(rays.range_m[0] == 2.0f);
  CHECK(ComputeMeanSparseness(rays) == 0.0);
}

TEST_CASE("readings that measured nothing are left out, and the others keep their angles") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const auto rays =
      FindValidRays(Scan({1.0f, nan, infinity, -infinity, 0.0f, -1.0f, 0.09f, 9.51f, 1e30f, 2.0f}), kLaser);
  CHECK(rays.range_m == std::vector<float>{1.0f, 2.0f});
  CHECK(rays.angle_rad == std::vector<float>{-0.5f, 1.75f});
}

TEST_CASE("a ray counts from the shortest range to 95 percent of the longest, both included") {
  const ScanParameters laser{.range_min_m = 0.125, .range_max_m = 20.0};  // 0.95 * 20 = 19
  const auto rays = FindValidRays(Scan({0.125f, 0.1249f, 19.0f, 19.001f}), laser);
  CHECK(rays.range_m == std::vector<float>{0.125f, 19.0f});
}

TEST_CASE("a range of zero is no ray even where no shortest range is set") {
  CHECK(FindValidRays(Scan({0.0f}), {.range_min_m = 0.0, .range_max_m = 10.0}).size() == 0);
}

TEST_CASE("a scan of 4096 beams has as many rays") {
  const LaserScan scan = ScanRoom({}, 1, 4096);
  CHECK(FindValidRays(scan, kLaser).size() == 4096);
}

TEST_CASE("the beams of a sweep are measured one after the other, the last one at the utime, whichever are valid") {
  ScanParameters laser = kLaser;
  laser.sweep_s = 0.4;
  LaserScan scan{1, -0.5f, 0.25f, {1.0f, 0.0f, 2.0f, 3.0f, 4.0f}};
  const ValidRays rays = FindValidRays(scan, laser);
  CHECK(rays.time_s == std::vector<float>{-0.4f, -0.2f, -0.1f, -0.0f});
  scan.angle_step_rad = -0.25f;  // clockwise: rays rise, times fall
  CHECK(FindValidRays(scan, laser).time_s == std::vector<float>{-0.0f, -0.1f, -0.2f, -0.4f});
  CHECK(FindValidRays(scan, kLaser).time_s.empty());
  laser.sweep_s = -0.4;  // the first beam last
  CHECK(FindValidRays(scan, laser).time_s == std::vector<float>{-0.4f, -0.3f, -0.2f, -0.0f});
}

TEST_CASE("what a scan says of its beams' times goes before what is known of the laser") {
  ScanParameters laser = kLaser;
  laser.sweep_s = 0.4;
  LaserScan scan{1, -0.5f, 0.25f, {1.0f, 0.0f, 2.0f, 3.0f}, {-0.3f, -0.25f, -0.125f, 0.0625f}};
  CHECK(FindValidRays(scan, laser).time_s == std::vector<float>{-0.3f, -0.125f, 0.0625f});
  CHECK(FindValidRays(scan, kLaser).time_s == std::vector<float>{-0.3f, -0.125f, 0.0625f});
  scan.angle_step_rad = -0.25f;
  CHECK(FindValidRays(scan, kLaser).time_s == std::vector<float>{0.0625f, -0.125f, -0.3f});
  laser.beam_times = false;
  CHECK(FindValidRays(scan, laser).time_s.back() == -0.4f);
}

TEST_CASE("a clockwise scan gives the same rays as its counter-clockwise twin") {
  const LaserScan ascending{1, -0.5f, 0.25f, {1.0f, 2.0f, 0.0f, 3.0f, 4.0f}};
  LaserScan descending{1, 0.5f, -0.25f, ascending.ranges_m};
  std::reverse(descending.ranges_m.begin(), descending.ranges_m.end());
  CHECK(FindValidRays(descending, kLaser) == FindValidRays(ascending, kLaser));
}

TEST_CASE("the angle scale turns beams towards straight ahead, or away from it") {
  for (const double scale : {0.9, 1.0, 1.1}) {
    ScanParameters laser = kLaser;
    laser.angle_scale = scale;
    const ValidRays rays = FindValidRays(Scan({1.0f, 1.0f, 1.0f, 1.0f}), laser);
    REQUIRE(rays.size() == 4);
    for (std::size_t i = 0; i < 4; ++i) {
      CHECK(rays.angle_rad[i] == Approx(scale * (-0.5 + 0.25 * static_cast<double>(i))).margin(1e-6));
    }
  }
}

TEST_CASE("hits lie along their beams at their ranges") {
  const ValidRays rays{{0.0f, static_cast<float>(kPi / 2.0), 3.0f}, {2.0f, 3.0f, 1.5f}};
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  REQUIRE(hits_m.cols() == 3);
  // 1e-7: the angles are of single precision.
  CHECK(hits_m(0, 0) == Approx(2.0));
  CHECK(hits_m(1, 0) == 0.0);
  CHECK(hits_m(0, 1) == Approx(0.0).margin(3e-7));
  CHECK(hits_m(1, 1) == Approx(3.0));
  CHECK(hits_m(0, 2) == Approx(1.5 * std::cos(3.0)));
  CHECK(hits_m(1, 2) == Approx(1.5 * std::sin(3.0)));
}

TEST_CASE("displacements are the distances between hits, also across beams that were left out") {
  LaserScan scan = ScanRoom({0.3, -0.2, 0.1}, 1, 90);
  for (const std::size_t beam : {10, 11, 12, 40, 60, 61}) scan.ranges_m[beam] = 0.0f;
  const ValidRays rays = FindValidRays(scan, kLaser);
  REQUIRE(rays.size() == 84);
  const auto displacements = ComputeDisplacements(rays);
  REQUIRE(displacements.size() == 83);
  for (std::size_t i = 0; i < displacements.size(); ++i) {
    const double dx_m =
        rays.range_m[i + 1] * std::cos(rays.angle_rad[i + 1]) - rays.range_m[i] * std::cos(rays.angle_rad[i]);
    const double dy_m =
        rays.range_m[i + 1] * std::sin(rays.angle_rad[i + 1]) - rays.range_m[i] * std::sin(rays.angle_rad[i]);
    CAPTURE(i);
    CHECK(displacements[i] == Approx(std::hypot(dx_m, dy_m)).epsilon(1e-5));  // cosines of floats against floats' own
  }
}

TEST_CASE("the mean sparseness on a circle is the chord between two beams") {
  const LaserScan scan{1, 0.0f, 0.125f, std::vector<float>(16, 2.0f)};
  CHECK(ComputeMeanSparseness(FindValidRays(scan, kLaser)) == Approx(2.0 * 2.0 * std::sin(0.0625)));
}

TEST_CASE("hits in one place are no distance apart") {
  const ValidRays rays{{0.5f, 0.5f}, {3.0f, 3.0f}};
  CHECK(ComputeDisplacements(rays) == std::vector<double>{0.0});
}

}  // namespace crsm
