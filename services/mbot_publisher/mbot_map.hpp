#pragma once

#include <cstdint>
#include <mbot_lcm_msgs/occupancy_grid_t.hpp>
#include <mbot_lcm_msgs/pose2D_t.hpp>

#include "common/map/dense_grid.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// The map as an mbot's programs take it: -127 free .. 127 occupied, 0 unexplored.
mbot_lcm_msgs::occupancy_grid_t ToMbotMap(std::int64_t utime, const DenseGrid& grid);

/// Where the laser stood, as an mbot's programs take it.
mbot_lcm_msgs::pose2D_t ToMbotPose(const ScanMatch& match);

}  // namespace crsm
