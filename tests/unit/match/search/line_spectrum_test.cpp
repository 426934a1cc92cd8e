#include "common/match/search/line_spectrum.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "common/math/pose2.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

/// Walls of a room that is no square, and clutter, moved to a pose.
Eigen::Matrix2Xd MakeRoom(const Pose2& at) {
  std::vector<Eigen::Vector2d> points;
  for (double along_m = -4.0; along_m < 4.0; along_m += 0.1) {
    points.emplace_back(along_m, -2.0);
    points.emplace_back(along_m, 2.5);
    if (std::abs(along_m) < 2.0) points.emplace_back(4.0, along_m);
  }
  Random random(5);
  for (int i = 0; i < 40; ++i) points.emplace_back(random.Uniform(-4.0, 4.0), random.Uniform(-2.0, 2.5));
  const auto [sin, cos] = ComputeSinCos(at.yaw_rad);
  Eigen::Matrix2Xd moved(2, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    moved.col(static_cast<Eigen::Index>(i)) << at.x_m + cos * points[i].x() - sin * points[i].y(),
        at.y_m + sin * points[i].x() + cos * points[i].y();
  }
  return moved;
}

}  // namespace

TEST_CASE("the lines of a room tell how it is turned, wherever it stands") {
  const LineSpectrum fixed = ComputeLineSpectrum(MakeRoom({}));
  for (int degree = 0; degree < 360; degree += 7) {
    const LineSpectrum turned = ComputeLineSpectrum(MakeRoom({3.0, -1.0, degree * kPi / 180.0}));
    const Turns turns = FindBestTurns(fixed, turned, 3);
    CHECK(turns.test(static_cast<std::size_t>((360 - degree) % 180)));
    CHECK(turns.count() <= 9);
  }
}

TEST_CASE("points that are 0.2 m apart across a direction are on two lines of it, nearer ones may be on one") {
  const auto AlongX = [](double aside_m) {
    return ComputeLineSpectrum((Eigen::Matrix2Xd(2, 3) << 0.0, 1.0, 2.0, 0.0, aside_m, 0.0).finished())[90];
  };
  CHECK(AlongX(0.3) < 0.5f * AlongX(0.1));
}

TEST_CASE("of no points, and of points all around, there are no lines") {
  CHECK(ComputeLineSpectrum(Eigen::Matrix2Xd(2, 0)) == LineSpectrum{});
  CHECK(FindBestTurns(LineSpectrum{}, LineSpectrum{}, 1000).all());
  const LineSpectrum room = ComputeLineSpectrum(MakeRoom({}));
  double square = 0.0;
  double sum = 0.0;
  for (const float value : room) {
    square += value * value;
    sum += value;
  }
  CHECK(square == Approx(1.0).margin(1e-4));
  CHECK(sum == Approx(0.0).margin(1e-4));
}

}  // namespace crsm
