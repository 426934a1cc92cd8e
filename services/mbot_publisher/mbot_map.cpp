#include "services/mbot_publisher/mbot_map.hpp"

#include <algorithm>

namespace crsm {

mbot_lcm_msgs::occupancy_grid_t ToMbotMap(std::int64_t utime, const DenseGrid& grid) {
  mbot_lcm_msgs::occupancy_grid_t map{};
  map.utime = utime;
  map.origin_x = static_cast<float>(grid.origin_x_cells * grid.cell_size_m);
  map.origin_y = static_cast<float>(grid.origin_y_cells * grid.cell_size_m);
  map.meters_per_cell = static_cast<float>(grid.cell_size_m);
  map.width = grid.width_cells;
  map.height = grid.height_cells;
  map.num_cells = static_cast<std::int32_t>(grid.cells.size());
  map.cells.reserve(grid.cells.size());
  for (const std::uint8_t byte : grid.cells) {
    constexpr int kLeast = -127;  // in their maps, too
    map.cells.push_back(static_cast<std::int8_t>(std::max(kLeast, kUnexploredByte - byte)));
  }
  return map;
}

mbot_lcm_msgs::pose2D_t ToMbotPose(const ScanMatch& match) {
  const Pose2& pose = match.T_map_laser;
  return {match.utime, static_cast<float>(pose.x_m), static_cast<float>(pose.y_m), static_cast<float>(pose.yaw_rad)};
}

}  // namespace crsm
