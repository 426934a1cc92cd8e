#pragma once

#include <span>

#include "common/math/point.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// How some places lie on others as well as they can, turned and moved: least squares (Arun, Huang and Blostein 1987).
struct Alignment {
  Point mean;         ///< of the places ...
  Point others_mean;  ///< ... which comes here
  double sin = 0.0;   ///< of the turn about it, times a factor >= 0 ...
  double cos = 0.0;   ///< ... that is the same: 0 where nothing tells the turn
};

/// As many poses as others, at least one. Their yaws have no say.
inline Alignment FindAlignment(std::span<const Pose2> poses, std::span<const Pose2> others) {
  const auto num = static_cast<double>(poses.size());
  Alignment alignment;
  auto& [mean, others_mean, sin, cos] = alignment;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    mean.x_m += poses[i].x_m / num;
    mean.y_m += poses[i].y_m / num;
    others_mean.x_m += others[i].x_m / num;
    others_mean.y_m += others[i].y_m / num;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Point from{poses[i].x_m - mean.x_m, poses[i].y_m - mean.y_m};
    const Point to{others[i].x_m - others_mean.x_m, others[i].y_m - others_mean.y_m};
    sin += from.x_m * to.y_m - from.y_m * to.x_m;
    cos += from.x_m * to.x_m + from.y_m * to.y_m;
  }
  return alignment;
}

}  // namespace crsm
