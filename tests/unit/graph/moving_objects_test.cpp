#include "common/graph/moving_objects.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "catch.hpp"
#include "common/scan/hits.hpp"
#include "common/worlds/world.hpp"

namespace crsm {
namespace {

constexpr int kBeams = 360;

/// A corridor of 2 m along x, from -10 m to 10 m.
std::vector<Wall> Corridor() {
  return {{{-10, -1}, {10, -1}}, {{10, -1}, {10, 1}}, {{10, 1}, {-10, 1}}, {{-10, 1}, {-10, -1}}};
}

/// A ray each degree, without noise. discs: people.
ValidRays See(const std::vector<Wall>& walls, const std::vector<Point>& discs, const Pose2& T_map_laser) {
  ValidRays rays;
  const Point origin{T_map_laser.x_m, T_map_laser.y_m};
  for (int i = 0; i < kBeams; ++i) {
    const double angle_rad = -kPi + 2.0 * kPi * (i + 0.5) / kBeams;
    const SinCos direction = ComputeSinCos(T_map_laser.yaw_rad + angle_rad);
    double range_m = CastRay(walls, origin, direction);
    for (const Point& disc : discs)
      range_m = std::min(range_m, CastRayAtDisc(disc, kPersonRadius_m, origin, direction));
    rays.angle_rad.push_back(static_cast<float>(angle_rad));
    rays.range_m.push_back(static_cast<float>(range_m));
  }
  return rays;
}

/// How many rays end on a disc, or half a cell beside it.
int CountOn(const Point& disc, const ValidRays& rays, const Pose2& T_map_laser) {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  int num = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const Pose2 hit = T_map_laser * Pose2{hits_m(0, i), hits_m(1, i), 0.0};
    num += std::hypot(hit.x_m - disc.x_m, hit.y_m - disc.y_m) < kPersonRadius_m + 0.025;
  }
  return num;
}

Pose2 At(double x_m) { return {x_m, 0.0, 0.0}; }

/// A scan as it may be drawn, which is drawn.
ValidRays Draw(MovingObjectFilter& filter, const ValidRays& rays, const Pose2& T_map_laser) {
  ValidRays kept = filter.Filter(rays, T_map_laser);
  filter.Add(rays, T_map_laser);
  return kept;
}

/// Drives along the corridor from 0 m to 3 m, a scan every 0.3 m.
void Drive(MovingObjectFilter& filter, const std::vector<Point>& discs = {}) {
  for (int i = 0; i <= 10; ++i) Draw(filter, See(Corridor(), discs, At(0.3 * i)), At(0.3 * i));
}

/// How many of the rays that end on a disc may be drawn.
int CountDrawn(const MovingObjectFilter& filter, const Point& disc, const Pose2& T_map_laser) {
  const ValidRays rays = See(Corridor(), {disc}, T_map_laser);
  REQUIRE(CountOn(disc, rays, T_map_laser) > 5);
  return CountOn(disc, filter.Filter(rays, T_map_laser), T_map_laser);
}

}  // namespace

TEST_CASE("who walks with the robot is never drawn, and the walls are as a whole") {
  const auto [ahead_m, left_m] =
      GENERATE(Point{-1.5, 0.0}, Point{-0.7, 0.1}, Point{1.0, 0.0}, Point{1.5, 0.2}, Point{0.0, 0.6}, Point{0.1, -0.7});
  CAPTURE(ahead_m, left_m);
  MovingObjectFilter filter;
  for (int i = 0; i <= 20; ++i) {
    CAPTURE(i);
    const Pose2 T_map_laser = At(0.3 * i);
    const Point person{T_map_laser.x_m + ahead_m, left_m};
    const ValidRays rays = See(Corridor(), {person}, T_map_laser);
    const int num_on_person = CountOn(person, rays, T_map_laser);
    REQUIRE(num_on_person > 10);
    const ValidRays kept = Draw(filter, rays, T_map_laser);
    CHECK(CountOn(person, kept, T_map_laser) == 0);
    CHECK(static_cast<int>(kept.size()) == kBeams - num_on_person);
  }
}

TEST_CASE("who follows a robot that turns on the spot is not drawn while it stands") {
  MovingObjectFilter filter;
  for (int i = 0; i <= 5; ++i) Draw(filter, See(Corridor(), {{0.3 * i - 1.0, 0.0}}, At(0.3 * i)), At(0.3 * i));
  for (int i = 1; i < 20; ++i) {
    const Pose2 turned{1.5, 0.0, 0.3 * i};
    CHECK(CountDrawn(filter, {0.5, 0.0}, turned) == 0);
    filter.Add(See(Corridor(), {{0.5, 0.0}}, turned), turned);
  }
}

TEST_CASE("a part of the robot is not drawn") {
  MovingObjectFilter filter;
  for (int i = 0; i <= 10; ++i) {
    ValidRays rays = See(Corridor(), {}, At(0.3 * i));
    for (std::size_t beam = 100; beam < 105; ++beam) rays.range_m[beam] = 0.2f;
    CHECK(Draw(filter, rays, At(0.3 * i)).size() == kBeams - 5);
  }
}

TEST_CASE("what stands is drawn: from afar at once, and when it comes, once the robot has driven on for a metre") {
  const Point comes{4.5, 0.5};
  MovingObjectFilter filter;
  CHECK(CountDrawn(filter, {3.5, 0.5}, At(0.0)) > 0);
  Drive(filter);
  CHECK(CountDrawn(filter, comes, At(3.0)) == 0);
  std::vector<bool> is_drawn;
  for (int i = 1; i <= 4; ++i) {
    const Pose2 T_map_laser = At(3.0 + 0.3 * i);
    is_drawn.push_back(CountDrawn(filter, comes, T_map_laser) > 0);
    filter.Add(See(Corridor(), {comes}, T_map_laser), T_map_laser);
  }
  CHECK(is_drawn == std::vector<bool>{false, false, false, true});
}

TEST_CASE("a door that closes behind the robot is drawn at once") {
  MovingObjectFilter filter;
  Drive(filter);
  std::vector<Wall> closed = Corridor();
  closed.push_back({{2.5, -1}, {2.5, 1}});
  CHECK(filter.Filter(See(closed, {}, At(3.3)), At(3.3)).size() == kBeams);
}

TEST_CASE("where the map was moved, what was seen is too, and there is nothing where the robot is somewhere else") {
  const Pose2 T_new_old{0.3, -0.3, 0.0};
  const Point stands{2.0, 0.5};
  MovingObjectFilter filter;
  Drive(filter, {stands});
  filter.Move(T_new_old);
  const ValidRays rays = See(Corridor(), {stands}, At(3.3));
  CHECK(filter.Filter(rays, T_new_old * At(3.3)).size() == kBeams);
  CHECK(filter.Filter(rays, At(3.3)).size() < kBeams);
  filter.Clear();
  CHECK(filter.Filter(rays, T_new_old * At(3.3)).size() < kBeams);
}

TEST_CASE("a scan that sees nothing but what is near is drawn as a whole") {
  MovingObjectFilter filter;
  ValidRays near;
  for (int i = 0; i < 30; ++i) {
    near.angle_rad.push_back(static_cast<float>(2.0 * kPi * i / kBeams));
    near.range_m.push_back(0.4f);
  }
  CHECK(Draw(filter, near, {}) == near);
}

TEST_CASE("a scan without rays stays one") {
  MovingObjectFilter filter;
  CHECK(Draw(filter, {}, {}).size() == 0);
  CHECK(filter.Filter({}, At(1.0)).size() == 0);
  CHECK(filter.Filter(See(Corridor(), {}, At(1.0)), At(1.0)).size() == kBeams);
}

}  // namespace crsm
