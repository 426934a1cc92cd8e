#include "common/scan/contour.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

/// Rays that end on a wall 1 m to the left of the laser, which goes along x.
ValidRays WallSeenAt(const std::vector<double>& xs_m) {
  ValidRays rays;
  for (const double x_m : xs_m) {
    rays.angle_rad.push_back(static_cast<float>(std::atan2(1.0, x_m)));
    rays.range_m.push_back(static_cast<float>(std::hypot(x_m, 1.0)));
  }
  return rays;
}

Contour Trace(const ValidRays& rays, double cap_m) {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  return TraceContour(rays, hits_m, Gaps(hits_m), cap_m);
}

}  // namespace

TEST_CASE("a hit weighs by half the way to its neighbours, up to the cap") {
  // Steps of 0.3 m and 0.1 m, in twentieths of the cap.
  const Contour contour = Trace(WallSeenAt({0.4, 0.1, 0.0}), 0.31);
  REQUIRE(contour.weights.size() == 3);
  CHECK(contour.weights[0] == 1 + 10);  // 10 * 0.3 / 0.31 = 9.7
  CHECK(contour.weights[1] == 1 + 13);  // ... + 10 * 0.1 / 0.31 = 3.2
  CHECK(contour.weights[2] == 1 + 3);
  CHECK((Trace(WallSeenAt({0.4, 0.1, 0.0}), 0.0).weights == 1).all());
  CHECK(Trace(WallSeenAt({5.0, 3.0, 2.0}), 0.0).weights.size() == 3);
  CHECK(Trace({}, 0.2).weights.size() == 0);
}

TEST_CASE("a wall is there between hits that are far apart, and weighs no more for that") {
  const Contour contour = Trace(WallSeenAt({10.0, 6.0, 3.5, 2.5}), 0.5);
  // Pieces of the gaps: 4 m / 0.5 m, of which no more than 7; 2.5 m / 0.5 m + 1; 1 m / 0.5 m + 1.
  REQUIRE(contour.points_m.cols() == 4 + 6 + 5 + 2);
  REQUIRE(contour.weights.size() == contour.points_m.cols());
  CHECK(contour.points_m(0, 0) == Approx(10.0));
  CHECK(contour.points_m(0, 1) == Approx(10.0 - 4.0 / 7.0));
  CHECK(contour.points_m(0, 7) == Approx(6.0));
  for (Eigen::Index i = 0; i < contour.points_m.cols(); ++i) CHECK(contour.points_m(1, i) == Approx(1.0).margin(1e-5));
  CHECK(contour.weights[1] == 3);                                // 20 / 7
  CHECK(contour.weights.sum() == Approx(4 + 3 * 20).margin(6));  // rounded
}

TEST_CASE("there is nothing between a near edge and what lies behind it") {
  ValidRays rays;  // a pillar 1 m ahead, and beside it a wall 5 m ahead
  for (int i = -8; i <= 8; ++i) {
    rays.angle_rad.push_back(static_cast<float>(0.02 * i));
    rays.range_m.push_back(i < 0 ? 5.0f : 1.0f);
  }
  const Contour contour = Trace(rays, 0.3);
  CHECK(contour.points_m.cols() == 17);
  CHECK(contour.weights[7] == 1 + 10 + 3);  // the whole cap on one side all the same
}

}  // namespace crsm
