#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/map/byte_map.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// What a map says of a ray.
enum class RayFate : std::int8_t {
  kFits,         ///< it ends where something stands, and nothing stands before that
  kPasses,       ///< it goes through what stands
  kContradicts,  ///< none of these: it ends in what is explored, and nothing stands there
  kUnknown,      ///< none of these: it ends in what is unexplored
};

/// Asks a map for rays. It has to outlive this, and to stay as it is.
class RayReader {
 public:
  explicit RayReader(const ByteMap& map, const MatchConstants::Census& constants = {});

  /// ray_m: from the laser to where it ends, map frame.
  RayFate FindFate(const Pose2& laser, const Eigen::Vector2d& ray_m);

  std::uint8_t At(double x_m, double y_m) { return At(geometry_.CellAt(x_m, y_m)); }

 private:
  /// The tile of the last cell is looked up once: the next one is beside it, as a rule.
  std::uint8_t At(Cell cell) {
    if (const TileIndex index = TileOf(cell); index != index_) {
      index_ = index;
      tile_ = map_.tiles().Find(index);
    }
    return tile_ ? tile_->cells[static_cast<std::size_t>(OffsetInTile(cell))] : kUnexploredByte;
  }

  const ByteMap& map_;
  MapGeometry geometry_;
  MatchConstants::Census constants_;
  double tolerance_m_;
  TileIndex index_;
  const ByteMap::Tile* tile_;
};

/// Shares of the rays of a scan, [0, 1]; together 1, all 0 without rays.
struct Census {
  double fits = 0.0;  ///< the agreement of scan and map
  double passes = 0.0;
  double contradicts = 0.0;
  double unknown = 0.0;
};

/// hits_m: 2 x N, where the rays end, laser frame.
Census CountRays(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                 const MatchConstants::Census& constants = {});

/// The share of the rays that end in what is unexplored, whatever is in their way.
double FindUnexploredShare(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser);

/// How well a scan fits a place, [0, 1]: its fitness there times the share of its rays that fit. Fitness asks only
/// where rays end; this tells a room from another one that has its walls and more.
double ScorePlace(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                  const MatchConstants& constants = {});

}  // namespace crsm
