#include "common/graph/moving_objects.hpp"

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "common/scan/hits.hpp"
#include "common/scan/surface.hpp"

namespace crsm {
namespace {

using Points = Eigen::Matrix2Xd;

/// A run of hits that are close to each other.
struct Object {
  Eigen::Index first;
  Eigen::Index size;
};

std::vector<Object> FindObjects(const Points& hits_m, const DrawingConstants& constants) {
  const double apart_m = constants.moving.apart_m;
  const std::vector<bool> joined = Gaps(hits_m, constants.surface).FindSurfaces(apart_m, constants.join_max_m);
  const auto IsJump = [&](Eigen::Index i) {
    return (hits_m.col(i) - hits_m.col(i - 1)).norm() > apart_m &&
           IsAlongBeam(hits_m.col(i - 1), hits_m.col(i), constants.surface);
  };
  std::vector<Object> objects;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    if (i > 0 && joined[static_cast<std::size_t>(i) - 1] && !IsJump(i)) {
      ++objects.back().size;
    } else {
      objects.push_back({i, 1});
    }
  }
  return objects;
}

/// Whether it is near, no broader than people, and in front of what is beside it.
bool MayWalk(const Object& object, const Points& hits_m, const DrawingConstants::Moving& constants) {
  const auto hits = hits_m.middleCols(object.first, object.size);
  if (hits.colwise().norm().minCoeff() > constants.reach_m) return false;
  if ((hits.rowwise().maxCoeff() - hits.rowwise().minCoeff()).norm() > constants.broadest_m) return false;
  const Eigen::Index last = object.first + object.size - 1;
  const auto IsBehind = [&](Eigen::Index i, Eigen::Index other) {
    return other >= 0 && other < hits_m.cols() && hits_m.col(other).norm() < hits_m.col(i).norm();
  };
  return !IsBehind(object.first, object.first - 1) && !IsBehind(last, last + 1);
}

Points MovePoints(const Pose2& T_to_from, const Points& points_m) {
  const auto [sin, cos] = ComputeSinCos(T_to_from.yaw_rad);
  const Eigen::Matrix2d turn{{cos, -sin}, {sin, cos}};
  return (turn * points_m).colwise() + Eigen::Vector2d(T_to_from.x_m, T_to_from.y_m);
}

/// Whether most of some points have one of the hits of a scan within a distance, or are where it does not look.
/// scan_hits_m: of it.
bool WereSeen(const Points& points_m, const ValidRays& scan, const Points& scan_hits_m, double within_m) {
  if (scan.size() == 0) return true;
  const double half_view_rad = 0.5 * (scan.angle_rad.back() - scan.angle_rad.front());
  const double middle_rad = scan.angle_rad.front() + half_view_rad;
  Eigen::Index num_seen = 0;
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    const double beside_rad = WrapAngle(std::atan2(points_m(1, i), points_m(0, i)) - middle_rad);
    num_seen += std::abs(beside_rad) > half_view_rad ||
                (scan_hits_m.colwise() - points_m.col(i)).colwise().norm().minCoeff() <= within_m;
  }
  return 2 * num_seen > points_m.cols();
}

}  // namespace

ValidRays MovingObjectFilter::Filter(const ValidRays& rays, const Pose2& T_map_laser) const {
  const double step_m = seen_.empty() ? 0.0 : Distance(T_map_last_, T_map_laser);
  if (step_m > constants_.moving.way_m) return rays;  // too much is new
  const double path_m = path_m_ + step_m;
  const Points hits_m = ComputeHits(rays);
  const Seen* before = nullptr;
  for (const Seen& seen : seen_) {
    if (path_m - seen.path_m >= constants_.moving.way_m) before = &seen;
  }
  const Points before_hits_m = before ? Points(ComputeHits(before->rays)) : Points();
  const auto Stands = [&](const Object& object) {
    if (!before) return false;
    const Pose2 T_before_laser = Inverse(before->T_map_laser) * T_map_laser;
    const Points object_m = MovePoints(T_before_laser, hits_m.middleCols(object.first, object.size));
    return WereSeen(object_m, before->rays, before_hits_m, constants_.moving.near_m);
  };
  ValidRays kept;
  for (const Object& object : FindObjects(hits_m, constants_)) {
    if (MayWalk(object, hits_m, constants_.moving) && !Stands(object)) continue;
    for (auto i = static_cast<std::size_t>(object.first); i < static_cast<std::size_t>(object.first + object.size);
         ++i) {
      kept.angle_rad.push_back(rays.angle_rad[i]);
      kept.range_m.push_back(rays.range_m[i]);
    }
  }
  return 4 * kept.size() < rays.size() ? rays : kept;
}

void MovingObjectFilter::Add(const ValidRays& rays, const Pose2& T_map_laser) {
  if (!seen_.empty()) path_m_ += Distance(T_map_last_, T_map_laser);
  T_map_last_ = T_map_laser;
  if (!seen_.empty() && path_m_ - seen_.back().path_m < constants_.moving.every_m) return;
  seen_.push_back({path_m_, T_map_laser, rays});
  while (seen_.size() > 1 && path_m_ - seen_[1].path_m >= constants_.moving.way_m) seen_.pop_front();
}

void MovingObjectFilter::Move(const Pose2& T_new_old) {
  T_map_last_ = T_new_old * T_map_last_;
  for (Seen& seen : seen_) seen.T_map_laser = T_new_old * seen.T_map_laser;
}

}  // namespace crsm
