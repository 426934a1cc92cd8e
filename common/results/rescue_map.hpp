#pragma once

#include <string>
#include <vector>

#include "common/map/dense_grid.hpp"
#include "common/marks/mark.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// The path of a robot, thinned out, in stretches: where it jumps, one ends.
class RescuePath {
 public:
  void Add(const Pose2& T_map_laser);
  const std::vector<std::vector<Pose2>>& stretches() const { return stretches_; }

 private:
  std::vector<std::vector<Pose2>> stretches_;
};

/// What a team of the RoboCup Rescue League hands in.
struct RescueMap {
  const DenseGrid& grid;  ///< at least one cell
  RescuePath path = {};
  std::vector<PlacedMark> marks =
      {};                  ///< victims and hazards are numbered in their order; those that float are left out
  std::string title = {};  ///< team and run
};

/// The bytes of a GeoTIFF in the frame of the map, in metres, in the colours of the league's rules (as ROS's
/// hector_geotiff has them). One pixel is 2 cm, or more where the picture would have more than 5000 on a side.
/// Throws std::runtime_error if it cannot be made.
std::string EncodeRescueMap(const RescueMap& map);

}  // namespace crsm
