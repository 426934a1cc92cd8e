#include <algorithm>
#include <cmath>
#include <limits>

#include "common/worlds/world.hpp"

namespace crsm {

double CastRay(const std::vector<Wall>& walls, const Point& origin, const SinCos& direction) {
  // Walls are a hair longer than they are, so that no ray slips through where two of them meet.
  constexpr double kHair = 1e-9;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls) {
    const double wall_x_m = wall.to.x_m - wall.from.x_m;
    const double wall_y_m = wall.to.y_m - wall.from.y_m;
    const double denominator = direction.cos * wall_y_m - direction.sin * wall_x_m;
    if (denominator == 0.0) continue;  // the ray runs along the wall
    const double to_x_m = wall.from.x_m - origin.x_m;
    const double to_y_m = wall.from.y_m - origin.y_m;
    const double along_wall = (to_x_m * direction.sin - to_y_m * direction.cos) / denominator;
    const double distance_m = (to_x_m * wall_y_m - to_y_m * wall_x_m) / denominator;
    if (along_wall < -kHair || along_wall > 1.0 + kHair || distance_m < 0.0) continue;
    if (distance_m < nearest_m) nearest_m = distance_m;
  }
  return nearest_m;
}

double CastRayAtDisc(const Point& centre, double radius_m, const Point& origin, const SinCos& direction) {
  const double to_x_m = centre.x_m - origin.x_m;
  const double to_y_m = centre.y_m - origin.y_m;
  const double along_m = direction.cos * to_x_m + direction.sin * to_y_m;
  const double beside_m = direction.cos * to_y_m - direction.sin * to_x_m;
  const double half_chord_m = std::sqrt(std::max(0.0, radius_m * radius_m - beside_m * beside_m));
  const bool hit = half_chord_m > 0.0 && along_m > half_chord_m;
  return hit ? along_m - half_chord_m : std::numeric_limits<double>::infinity();
}

}  // namespace crsm
