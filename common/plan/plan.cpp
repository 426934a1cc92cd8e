#include "common/plan/plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/plan/rooms.hpp"

namespace crsm {
namespace {

Point ToPoint(const Eigen::Vector2d& at_m) { return {at_m.x(), at_m.y()}; }

/// A door in a thick wall is seen on both of its faces.
std::vector<PlanDoor> ListDoors(const std::vector<WallLine>& lines, const std::vector<Doorway>& doorways,
                                double apart_m) {
  std::vector<PlanDoor> doors;
  for (const Doorway& doorway : doorways) {
    const WallLine& line = lines[static_cast<std::size_t>(doorway.line)];
    const PlanDoor door{ToPoint(line.At(doorway.from_m)), ToPoint(line.At(doorway.to_m))};
    const double x_m = door.from.x_m + door.to.x_m;
    const double y_m = door.from.y_m + door.to.y_m;
    const bool is_known = std::ranges::any_of(doors, [&](const PlanDoor& other) {
      return std::hypot(other.from.x_m + other.to.x_m - x_m, other.from.y_m + other.to.y_m - y_m) < 2.0 * apart_m;
    });
    if (!is_known) doors.push_back(door);
  }
  return doors;
}

}  // namespace

double Plan::extent_m() const {
  Eigen::AlignedBox2d box;
  for (const PlanWall& wall : walls) {
    box.extend(Eigen::Vector2d(wall.from.x_m, wall.from.y_m));
    box.extend(Eigen::Vector2d(wall.to.x_m, wall.to.y_m));
  }
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

double BoundLengthError(const Plan& plan, const PlanWall& wall) {
  constexpr double kSigmas = 1.96;
  const double extent_m = plan.extent_m();
  const double share = extent_m > 0.0 ? wall.length_m / extent_m : 0.0;
  return std::hypot(kSigmas * wall.sigma_length_m, share * plan.map_off_m);
}

Plan MakePlan(const std::vector<PlacedScan>& scans, const std::vector<NamedPlace>& names,
              const PlanConstants& constants) {
  std::vector<WallStretch> stretches;
  int number = 0;
  for (const PlacedScan& scan : scans) {
    const Pose2& pose = scan.T_map_laser;
    if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !std::isfinite(pose.yaw_rad)) {
      throw std::invalid_argument("the pose of a scan is not finite");
    }
    const auto found = FindStretches(scan, number++, constants.stretch);
    stretches.insert(stretches.end(), found.begin(), found.end());
  }
  std::vector<WallLine> lines = FitLines(stretches, constants.line);
  Plan plan;
  plan.directions_rad = SnapLines(lines, constants.direction);
  const SeenSpace space(scans, constants.space);
  const Walls walls = FindWalls(lines, stretches, space, constants);
  for (const WallPiece& piece : walls.pieces) {
    const WallLine& line = lines[static_cast<std::size_t>(piece.line)];
    plan.walls.push_back({ToPoint(line.At(piece.from_m)), ToPoint(line.At(piece.to_m)), piece.length_m(),
                          std::hypot(piece.sigma_from_m, piece.sigma_to_m), line.sigma_offset_m, line.snapped});
  }
  plan.doors = ListDoors(lines, walls.doorways, constants.door.least_m);
  const double direction = plan.directions_rad.empty() ? 0.0 : plan.directions_rad.front();
  plan.rooms = FindRooms(lines, walls, space, names, direction, constants);
  return plan;
}

}  // namespace crsm
