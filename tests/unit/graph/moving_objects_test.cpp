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
  filter.Add(T_map_laser);
  return kept;
}

/// Drives along the corridor from 0 m to 3 m, a scan every 0.3 m.
void Drive(MovingObjectFilter& filter) {
  for (int i = 0; i <= 10; ++i) Draw(filter, See(Corridor(), {}, At(0.3 * i)), At(0.3 * i));
}

}  // namespace

TEST_CASE("who follows the robot is not drawn once it has come so far, and the walls are as a whole") {
  const auto [ahead_m, left_m] = GENERATE(Point{-0.7, 0.0}, Point{-1.0, 0.1}, Point{-1.5, 0.0});
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
    if (0.3 * i + ahead_m < 0.0) continue;  // the robot never was there
    CHECK(CountOn(person, kept, T_map_laser) == 0);
    CHECK(static_cast<int>(kept.size()) == kBeams - num_on_person);
  }
}

TEST_CASE("who follows a robot that turns on the spot is not drawn while it stands") {
  MovingObjectFilter filter;
  for (int i = 0; i <= 5; ++i) Draw(filter, See(Corridor(), {{0.3 * i - 1.0, 0.0}}, At(0.3 * i)), At(0.3 * i));
  for (int i = 1; i < 20; ++i) {
    const Pose2 turned{1.5, 0.0, 0.3 * i};
    const ValidRays rays = See(Corridor(), {{0.5, 0.0}}, turned);
    REQUIRE(CountOn({0.5, 0.0}, rays, turned) > 10);
    CHECK(CountOn({0.5, 0.0}, Draw(filter, rays, turned), turned) == 0);
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

TEST_CASE("a box that is put where the robot drove is drawn when the robot has driven on for three metres") {
  MovingObjectFilter filter;
  Drive(filter);
  std::vector<int> num_drawn;
  for (int i = 1; i <= 10; ++i) {
    const ValidRays rays = See(Corridor(), {{2.5, 0.0}}, At(3.0 + 0.3 * i));
    num_drawn.push_back(CountOn({2.5, 0.0}, Draw(filter, rays, At(3.0 + 0.3 * i)), At(3.0 + 0.3 * i)));
  }
  CHECK(num_drawn[0] == 0);
  CHECK(num_drawn[6] == 0);  // the robot was there a moment ago
  CHECK(num_drawn[9] > 0);
}

TEST_CASE("a door that closes behind the robot is drawn at once") {
  MovingObjectFilter filter;
  Drive(filter);
  std::vector<Wall> closed = Corridor();
  closed.push_back({{2.5, -1}, {2.5, 1}});
  CHECK(filter.Filter(See(closed, {}, At(3.3)), At(3.3)).size() == kBeams);
}

TEST_CASE("where the map was moved, the path was too, and there is none where the robot is somewhere else") {
  const Pose2 T_new_old{3.0, -2.0, 0.5};
  MovingObjectFilter filter;
  Drive(filter);
  filter.Move(T_new_old);
  const ValidRays rays = See(Corridor(), {{2.3, 0.0}}, At(3.3));
  CHECK(filter.Filter(rays, T_new_old * At(3.3)).size() < kBeams);
  CHECK(filter.Filter(rays, At(3.3)).size() == kBeams);
  filter.Clear();
  CHECK(filter.Filter(rays, T_new_old * At(3.3)).size() == kBeams);
}

TEST_CASE("a scan that sees little but what is near is drawn as a whole") {
  MovingObjectFilter filter;
  ValidRays near;
  for (int i = 0; i < kBeams; i += 30) {
    near.angle_rad.push_back(static_cast<float>(-kPi + 2.0 * kPi * i / kBeams));
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
