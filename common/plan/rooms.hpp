#pragma once

#include <vector>

#include "common/plan/walls.hpp"

namespace crsm {

/// The rooms that walls and doorways close, the largest first. names: of rooms.
std::vector<PlanRoom> FindRooms(const std::vector<WallLine>& lines, const Walls& walls, const SeenSpace& space,
                                const std::vector<NamedPlace>& names, double main_direction_rad,
                                const PlanConstants& constants);

}  // namespace crsm
