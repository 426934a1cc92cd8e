#include "services/mbot_publisher/mbot_map.hpp"

#include "catch.hpp"

namespace crsm {

TEST_CASE("what an mbot hears is known to it: the fingerprints are its own") {
  CHECK(mbot_lcm_msgs::pose2D_t::getHash() == 0x1f317af1246276ac);  // of SLAM_POSE in a log of 2015
  // lcm-gen's, of occupancy_grid_t.lcm in mbot_lcm_base of 2024.
  CHECK(static_cast<std::uint64_t>(mbot_lcm_msgs::occupancy_grid_t::getHash()) == 0xd5447e494a66cc92);
}

TEST_CASE("an mbot's map has the occupied above 0, the free below, and the unexplored at it, in the same places") {
  const DenseGrid grid{3, 2, -4, 6, 0.05, {255, 254, 128, 127, 126, 0}};
  const auto map = ToMbotMap(99, grid);
  CHECK(map.utime == 99);
  CHECK(map.origin_x == Approx(-0.2));
  CHECK(map.origin_y == Approx(0.3));
  CHECK(map.meters_per_cell == Approx(0.05));
  CHECK(map.width == 3);
  CHECK(map.height == 2);
  CHECK(map.num_cells == 6);
  CHECK(map.cells == std::vector<std::int8_t>{-127, -127, -1, 0, 1, 127});
}

TEST_CASE("an mbot's pose is that of the laser") {
  ScanMatch match;
  match.utime = 7;
  match.T_map_laser = {1.5, -2.25, 3.0};
  const auto pose = ToMbotPose(match);
  CHECK(pose.utime == 7);
  CHECK(pose.x == 1.5f);
  CHECK(pose.y == -2.25f);
  CHECK(pose.theta == 3.0f);
}

}  // namespace crsm
