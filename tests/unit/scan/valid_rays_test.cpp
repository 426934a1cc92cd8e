#include "common/scan/valid_rays.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

constexpr ScanParameters kLaser{.range_min_m = 0.1, .range_max_m = 10.0};

LaserScan Scan(std::vector<float> ranges_m) { return {1, -0.5f, 0.25f, std::move(ranges_m)}; }

}  // namespace

TEST_CASE("a scan without beams has no rays, and one beam is one ray without sparseness") {
  const ValidRays none = FindValidRays(Scan({}), kLaser);
  CHECK(none.size() == 0);
  CHECK(ComputeHits(none).cols() == 0);
  CHECK(ComputeDisplacements(none).empty());
  CHECK(ComputeMeanSparseness(none) == 0.0);
  const ValidRays one = FindValidRays(Scan({2.0f}), kLaser);
  CHECK(one == ValidRays{{-0.5f}, {2.0f}, {}});
  CHECK(ComputeMeanSparseness(one) == 0.0);
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
  CHECK(FindValidRays(Scan({0.0f}), {.range_min_m = 0.0, .range_max_m = 10.0}).size() == 0);  // zero is no range
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

TEST_CASE("hits lie along their beams at their ranges, and displacements are the distances between them") {
  const ValidRays rays{{0.0f, static_cast<float>(kPi / 2.0), 3.0f}, {4.0f, 3.0f, 1.5f}, {}};
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  REQUIRE(hits_m.cols() == 3);
  CHECK(hits_m(0, 0) == Approx(4.0));
  CHECK(hits_m(1, 0) == 0.0);
  CHECK(hits_m(0, 1) == Approx(0.0).margin(3e-7));  // the angles are of single precision
  CHECK(hits_m(1, 1) == Approx(3.0));
  CHECK(hits_m(0, 2) == Approx(1.5 * std::cos(3.0)));
  CHECK(hits_m(1, 2) == Approx(1.5 * std::sin(3.0)));
  const auto displacements = ComputeDisplacements(rays);
  REQUIRE(displacements.size() == 2);
  CHECK(displacements[0] == Approx(5.0));  // 3-4-5
  CHECK(displacements[1] == Approx(std::hypot(1.5 * std::cos(3.0), 1.5 * std::sin(3.0) - 3.0)));
  CHECK(ComputeDisplacements({{0.5f, 0.5f}, {3.0f, 3.0f}, {}}) == std::vector<double>{0.0});  // in one place
}

TEST_CASE("the mean sparseness on a circle is the chord between two beams") {
  const LaserScan scan{1, 0.0f, 0.125f, std::vector<float>(16, 2.0f)};
  CHECK(ComputeMeanSparseness(FindValidRays(scan, kLaser)) == Approx(2.0 * 2.0 * std::sin(0.0625)));
}

}  // namespace crsm
