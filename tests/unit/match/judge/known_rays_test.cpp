#include "common/match/judge/known_rays.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr double kCell_m = 0.05;
const DegenerateAxis kAlong{{1.0, 0.0}, false};
const DegenerateAxis kAlongByWheels{{1.0, 0.0}, true};

/// A corridor of 2 m along x whose walls are drawn from 0 to 8 m, free between them; its end, at 8 m, is not drawn, or
/// is.
ByteMap MakeCorridor(bool with_end) {
  ByteMap map(kCell_m);
  for (int x = 0; x < 160; ++x) {
    for (int y = -20; y <= 20; ++y) {
      const bool is_wall = y == -20 || y == 20 || (with_end && x >= 156);
      map.Set({x, y}, is_wall ? std::uint8_t{0} : kFreeByte);
    }
  }
  return map;
}

Contour Seen(const std::vector<Eigen::Vector2d>& points_m) {
  Contour seen{Eigen::Matrix2Xd(2, static_cast<Eigen::Index>(points_m.size())),
               Eigen::ArrayXi::Ones(static_cast<Eigen::Index>(points_m.size()))};
  for (std::size_t i = 0; i < points_m.size(); ++i) seen.points_m.col(static_cast<Eigen::Index>(i)) = points_m[i];
  return seen;
}

}  // namespace

TEST_CASE("a ray is known where it ends in what is explored, or a wall is in its way") {
  const Eigen::Matrix2Xd points_m =
      Seen({{2.0, 1.0}, {2.0, 0.0}, {6.0, 0.0}, {4.2, 0.0}}).points_m;  // the last just behind the wall
  const Pose2 laser{4.0, 0.0, 0.0};
  const KnownRays open = FindKnownRays(MakeCorridor(false), points_m, laser, kAlong);
  CHECK((open == (KnownRays(4) << true, true, false, false).finished()).all());
  const KnownRays closed = FindKnownRays(MakeCorridor(true), points_m, laser, kAlong);
  CHECK((closed == (KnownRays(4) << true, true, true, false).finished()).all());
}

TEST_CASE("a ray that ends just behind a wall is known, one beyond the drawn end of a wall along the axis is not") {
  const Eigen::Matrix2Xd points_m = Seen({{2.0, 1.1}, {2.0, -1.15}, {2.0, 1.3}, {4.1, 1.0}, {6.0, 1.05}}).points_m;
  const KnownRays open = FindKnownRays(MakeCorridor(false), points_m, {4.0, 0.0, 0.0}, kAlong);
  CHECK((open == (KnownRays(5) << true, true, false, false, false).finished()).all());

  const Eigen::Matrix2Xd at_end_m = Seen({{4.1, 0.0}, {4.1, 0.6}, {4.3, 0.0}}).points_m;
  const KnownRays closed = FindKnownRays(MakeCorridor(true), at_end_m, {4.0, 0.0, 0.0}, kAlong);
  CHECK((closed == (KnownRays(3) << true, true, false).finished()).all());
  CHECK_FALSE(FindKnownRays(MakeCorridor(true), at_end_m, {4.0, 0.0, 0.0}, kAlongByWheels).any());
}

TEST_CASE("where the drawn walls end a robot does not fit better for standing back, nor before a wall in its way") {
  const ScoredMap map(MakeCorridor(false));
  std::vector<Eigen::Vector2d> points_m;
  for (double x_m = -3.0; x_m < 6.0; x_m += 0.1) {
    for (const double y_m : {-0.975, 1.025}) points_m.emplace_back(x_m, y_m);
  }
  const Contour seen = Seen(points_m);
  const RaysInCells all = ToCells(seen.points_m, map.geometry(), seen.weights);
  const Pose2 here{4.0, 0.0, 0.0};
  const Pose2 back{3.0, 0.0, 0.0};
  REQUIRE(map.Fitness(all, back) > map.Fitness(all, here) + 0.05);
  CHECK(std::abs(FitGain(map, seen, kAlong, here).At(back)) < 0.01);
  CHECK(SelectRays(map, seen, FindKnownRays(map.cells(), seen.points_m, here, kAlong)).size() < all.size());

  // The end of the corridor is seen 2 m away, where it is not by the pose that is too far on: there it counts.
  const ScoredMap closed(MakeCorridor(true));
  std::vector<Eigen::Vector2d> end_m;
  for (double y_m = -0.9; y_m < 0.9; y_m += 0.05) end_m.emplace_back(3.9, y_m);
  const Contour seen_end = Seen(end_m);
  const Pose2 too_far{5.0, 0.0, 0.0};
  const KnownRays known = FindKnownRays(closed.cells(), seen_end.points_m, too_far, kAlong);
  CHECK(known.all());
  CHECK(FitGain(closed, seen_end, kAlong, too_far).At(here) > 0.5);
}

}  // namespace crsm
