#include "common/scan/deskew.hpp"

#include <cmath>
#include <functional>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

constexpr double kSweep_s = 0.15;

/// Where the laser stood `time_s` after the utime, seen from where it stood then.
Pose2 PoseAt(const Twist& twist, double time_s) {
  return {twist.x_m_s * time_s, twist.y_m_s * time_s, twist.yaw_rad_s * time_s};
}

/// What a laser in a room of 6 m x 4 m measures in one turn while it moves, its last beam at the utime.
ValidRays Sweep(const Twist& twist, int num_beams, double first_angle_rad) {
  ValidRays rays;
  for (int i = 0; i < num_beams; ++i) {
    const double share = static_cast<double>(i) / (num_beams - 1);
    const double time_s = kSweep_s * (share - 1.0);
    const double angle_rad = first_angle_rad + 2.0 * kPi * share;
    const Pose2 at = PoseAt(twist, time_s);
    const auto [sin, cos] = ComputeSinCos(at.yaw_rad + angle_rad);
    const auto Reach = [](double from_m, double direction, double low_m, double high_m) {
      return direction > 0.0 ? (high_m - from_m) / direction : (low_m - from_m) / direction;
    };
    const double range_m = std::min(std::abs(cos) > 1e-9 ? Reach(at.x_m, cos, -2.5, 3.5) : 1e9,
                                    std::abs(sin) > 1e-9 ? Reach(at.y_m, sin, -1.5, 2.5) : 1e9);
    rays.angle_rad.push_back(static_cast<float>(angle_rad));
    rays.range_m.push_back(static_cast<float>(range_m));
    rays.time_s.push_back(static_cast<float>(time_s));
  }
  return rays;
}

/// How far the farthest hit is from the walls of the room [m].
double FarthestFromWalls(const ValidRays& rays) {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  double farthest_m = 0.0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const double x_m = hits_m(0, i);
    const double y_m = hits_m(1, i);
    farthest_m = std::max(
        farthest_m, std::min({std::abs(x_m + 2.5), std::abs(x_m - 3.5), std::abs(y_m + 1.5), std::abs(y_m - 2.5)}));
  }
  return farthest_m;
}

}  // namespace

TEST_CASE("a sweep of a laser that moves becomes what it would have seen at once") {
  for (const Twist& twist :
       {Twist{0.0, 0.0, 3.0}, Twist{0.0, 0.0, -3.0}, Twist{1.0, -0.5, 0.0}, Twist{0.8, 0.2, 2.0}}) {
    for (const double first_angle_rad : {-kPi, 0.0, 2.0}) {
      const ValidRays sweep = Sweep(twist, 300, first_angle_rad);
      CHECK(FarthestFromWalls(sweep) > 0.05);
      const ValidRays rays = Deskew(sweep, twist);
      REQUIRE(rays.size() == sweep.size());
      CHECK(FarthestFromWalls(rays) < 1e-5);
      CHECK(rays.time_s.empty());
      CHECK(std::is_sorted(rays.angle_rad.begin(), rays.angle_rad.end()));
    }
  }
}

TEST_CASE("critical rays stay the same rays when a turn overlaps itself") {
  const Twist twist{0.0, 0.0, -3.0};  // the laser turns against its beams: its last ones look where the first ones did
  const ValidRays sweep = Sweep(twist, 100, -kPi);
  const CriticalRays scan{7, sweep, {0, 1, 50, 98, 99}};
  const CriticalRays deskewed = Deskew(scan, twist);
  CHECK(deskewed.utime == 7);
  CHECK(std::is_sorted(deskewed.critical.begin(), deskewed.critical.end()));
  std::vector<float> ranges_m;
  std::vector<float> expected_m;
  for (const int index : deskewed.critical) {
    ranges_m.push_back(deskewed.rays.range_m[static_cast<std::size_t>(index)]);
  }
  for (const int index : scan.critical) expected_m.push_back(sweep.range_m[static_cast<std::size_t>(index)]);
  std::sort(ranges_m.begin(), ranges_m.end());
  std::sort(expected_m.begin(), expected_m.end());  // turned only: no range changes
  REQUIRE(ranges_m.size() == expected_m.size());
  for (std::size_t i = 0; i < ranges_m.size(); ++i) CHECK(ranges_m[i] == Approx(expected_m[i]).epsilon(1e-5));
}

TEST_CASE("what was measured at once stays as it is") {
  const CriticalRays scan{1, {{-1.0f, 0.0f, 1.0f}, {1.0f, 2.0f, 3.0f}}, {0, 2}};
  CHECK(Deskew(scan, {1.0, 2.0, 3.0}) == scan);
  CHECK(Deskew(scan.rays, {1.0, 2.0, 3.0}) == scan.rays);
}

TEST_CASE("no twist and no times make rays that no message may have") {
  const ValidRays sweep{{-12.5f, 0.0f, 0.5f, 12.5f}, {999.0f, 0.5f, 1e-30f, 999.0f}, {-2.0f, -0.025f, 0.0f, 2.0f}};
  for (const Twist& twist :
       {Twist{kFastest, 0.0, 0.0}, Twist{0.0, kFastest, kFastest}, Twist{kFastest, 0.0, -kFastest}}) {
    const ValidRays rays = Deskew(sweep, twist);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      CHECK(rays.range_m[i] > 0.0f);
      CHECK(rays.range_m[i] <= 1000.0f);
      CHECK(std::abs(rays.angle_rad[i]) <= 4.0 * kPi + 1e-5);
    }
    CHECK(std::is_sorted(rays.angle_rad.begin(), rays.angle_rad.end()));
  }
}

}  // namespace crsm
