#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/match/fit/fitness_derivatives.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/contour.hpp"

namespace crsm {

/// Of each ray of a scan, whether a map tells anything of it.
///
/// A ray that ends in what is unexplored scores as one that does not fit. Along a corridor whose walls are not drawn to
/// their end that favours the pose from which the fewest rays reach beyond: the robot would seem to stand. So where two
/// poses are compared, only rays count that the map knows from both.
using KnownRays = Eigen::Array<bool, Eigen::Dynamic, 1>;

/// Along which poses are compared, and how.
struct DegenerateAxis {
  Eigen::Vector2d direction;    ///< unit vector, map frame
  bool held_by_wheels = false;  ///< then a few cells across it are no wall: the drawn end of a wall looks like one
  MatchConstants::KnownRays constants = {};
  MatchConstants::Census census = {};
};

/// Rays end in explored cells or just behind a wall, from the pose and from so far before and behind it along the axis:
/// a climb meets none that becomes known on the way. Or they fit, or pass through a wall, as of RayFate. points_m:
/// 2 x N, laser frame.
KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const DegenerateAxis& axis, double margin_m = 0.0);

/// These rays alone.
RaysInCells SelectRays(const ScoredMap& map, const Contour& contour, const KnownRays& rays);

/// How much better a scan fits at other poses than at one, by the rays that are known from both: a share of all rays.
class FitGain {
 public:
  /// Map and contour have to outlive it.
  FitGain(const ScoredMap& map, const Contour& contour, const DegenerateAxis& axis, const Pose2& from);

  double At(const Pose2& to);
  /// About the same, for a pose of the same heading: which rays are known from there is asked again only where the one
  /// that was asked last is further away.
  double Near(const Pose2& to, double as_known_within_m);

 private:
  double Compare(const Pose2& to, KnownRays known_from_both);
  double Fit(const Pose2& pose) const { return map_.Differentiate(*rays_, pose).value; }

  const ScoredMap& map_;
  const Contour& contour_;
  DegenerateAxis axis_;
  Pose2 from_;
  double yaw_rad_;           ///< of the last pose ...
  Eigen::Matrix2Xd rays_m_;  ///< ... and the contour, turned so
  KnownRays known_from_;
  std::optional<Pose2> asked_;  ///< from where it was asked last which rays are known
  // Of the last pose; another one along an axis is mostly compared by the same.
  KnownRays compared_;
  std::optional<RaysInCells> rays_;
  double share_ = 0.0;
  double fit_from_ = 0.0;
};

}  // namespace crsm
