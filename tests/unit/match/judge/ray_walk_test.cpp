#include "common/match/judge/ray_walk.hpp"

#include <cmath>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr double kCell_m = 0.05;

/// From the lower left of cell (-40, -40), at -2 m, to the upper right of cell (39, 39), at 2 m, free but for a wall of
/// some cells.
ByteMap MakeMap(int first_x, int last_x) {
  ByteMap map(kCell_m);
  for (int x = -40; x < 40; ++x) {
    for (int y = -40; y < 40; ++y) map.Set({x, y}, x >= first_x && x <= last_x ? std::uint8_t{0} : kFreeByte);
  }
  return map;
}

bool IsBlocked(const ByteMap& map, const Pose2& laser, double direction_rad, double first_m, double last_m) {
  const Eigen::Vector2d direction(std::cos(direction_rad), std::sin(direction_rad));
  return IsInTheWay(map, laser, direction, first_m, last_m, IsOccupied);
}

}  // namespace

TEST_CASE("two cells of a ray stand in its way, one does not, on either side of the map's origin") {
  const Pose2 laser{0.025, 0.025, 0.0};
  CHECK(IsBlocked(MakeMap(20, 21), laser, 0.0, 0.1, 1.9));
  CHECK_FALSE(IsBlocked(MakeMap(20, 20), laser, 0.0, 0.1, 1.9));
  CHECK(IsBlocked(MakeMap(-22, -21), laser, M_PI, 0.1, 1.9));
  CHECK_FALSE(IsBlocked(MakeMap(-22, -22), laser, M_PI, 0.1, 1.9));
  CHECK(IsBlocked(MakeMap(-22, -21), {-1.975, -1.975, 0.0}, 0.6, 0.1, 1.9));
  CHECK_FALSE(IsBlocked(MakeMap(-22, -21), {-1.975, -1.975, 0.0}, 0.5 * M_PI, 0.1, 1.9));
}

TEST_CASE("only what lies between both ends of a ray stands in its way") {
  const ByteMap map = MakeMap(20, 21);  // from 1 m to 1.1 m
  const Pose2 laser{0.025, 0.025, 0.0};
  CHECK_FALSE(IsBlocked(map, laser, 0.0, 0.1, 0.9));
  CHECK_FALSE(IsBlocked(map, laser, 0.0, 1.15, 1.9));
  CHECK_FALSE(IsBlocked(map, laser, 0.0, 1.9, 0.1));
  CHECK_FALSE(IsBlocked(map, laser, M_PI, 0.1, 1.9));
  CHECK(IsBlocked(MakeMap(-22, -21), laser, M_PI, 0.1, 1.13));
  CHECK_FALSE(IsBlocked(MakeMap(-22, -21), laser, M_PI, 0.1, 1.08));
}

TEST_CASE("a ray that leaves the map's limits, or is no number, meets nothing") {
  const ByteMap map = MakeMap(20, 21);
  CHECK_FALSE(IsBlocked(map, {1e9, 0.0, 0.0}, 0.0, 0.1, 1.9));
  CHECK_FALSE(IsBlocked(map, {0.025, 0.025, 0.0}, 0.0, 0.1, 1e9));
  CHECK_FALSE(IsBlocked(map, {std::nan(""), 0.0, 0.0}, 0.0, 0.1, 1.9));
  CHECK_FALSE(IsBlocked(map, {0.025, 0.025, 0.0}, std::nan(""), 0.1, 1.9));
}

}  // namespace crsm
