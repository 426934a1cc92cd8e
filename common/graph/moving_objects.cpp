#include "common/graph/moving_objects.hpp"

#include <Eigen/Core>
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
  const std::vector<bool> joined =
      Gaps(hits_m, constants.surface).FindSurfaces(constants.moving.apart_m, constants.join_max_m);
  std::vector<Object> objects;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    if (i > 0 && joined[static_cast<std::size_t>(i) - 1]) {
      ++objects.back().size;
    } else {
      objects.push_back({i, 1});
    }
  }
  return objects;
}

/// Whether each of some points has one of the others within a distance.
bool AreNear(const Eigen::Ref<const Points>& points_m, const Points& others_m, double within_m) {
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    if ((others_m.colwise() - points_m.col(i)).colwise().norm().minCoeff() > within_m) return false;
  }
  return true;
}

}  // namespace

ValidRays MovingObjectFilter::Filter(const ValidRays& rays, const Pose2& T_map_laser) const {
  const Points hits_m = ComputeHits(rays);
  Points path_m = Points::Zero(2, std::ssize(driven_) + 1);  // laser frame, where the laser is, too
  for (Eigen::Index i = 0; i < std::ssize(driven_); ++i) {
    const Pose2 T_laser_then = Inverse(T_map_laser) * driven_[static_cast<std::size_t>(i)].T_map_laser;
    path_m.col(i) << T_laser_then.x_m, T_laser_then.y_m;
  }
  ValidRays kept;
  for (const auto& [first, size] : FindObjects(hits_m, constants_)) {
    if (AreNear(hits_m.middleCols(first, size), path_m, constants_.moving.beside_path_m)) continue;
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(first + size); ++i) {
      kept.angle_rad.push_back(rays.angle_rad[i]);
      kept.range_m.push_back(rays.range_m[i]);
    }
  }
  return 2 * kept.size() < rays.size() ? rays : kept;
}

void MovingObjectFilter::Add(const Pose2& T_map_laser) {
  if (!driven_.empty()) path_m_ += Distance(T_map_last_, T_map_laser);
  T_map_last_ = T_map_laser;
  if (!driven_.empty() && path_m_ - driven_.back().path_m < constants_.moving.every_m) return;
  driven_.push_back({path_m_, T_map_laser});
  while (path_m_ - driven_.front().path_m > constants_.moving.reach_m) driven_.pop_front();
}

void MovingObjectFilter::Move(const Pose2& T_new_old) {
  T_map_last_ = T_new_old * T_map_last_;
  for (Place& place : driven_) place.T_map_laser = T_new_old * place.T_map_laser;
}

}  // namespace crsm
