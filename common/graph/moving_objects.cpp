#include "common/graph/moving_objects.hpp"

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

/// Whether the hits on an object are small and near enough for somebody who walks with the robot.
bool MayMove(const Eigen::Ref<const Points>& hits_m, const DrawingConstants::Moving& constants) {
  return (hits_m.rightCols(1) - hits_m.leftCols(1)).norm() < constants.width_max_m &&
         hits_m.colwise().norm().maxCoeff() < constants.reach_m;
}

/// Whether what is seen beside an object is further away than its ends: nothing hides a part of it.
bool StandsOut(const ValidRays& rays, const Object& object) {
  const auto first = static_cast<std::size_t>(object.first);
  const auto end = static_cast<std::size_t>(object.first + object.size);
  return (first == 0 || rays.range_m[first - 1] > rays.range_m[first]) &&
         (end == rays.size() || rays.range_m[end] > rays.range_m[end - 1]);
}

/// How many of some points have one of the others within a distance.
Eigen::Index CountNear(const Eigen::Ref<const Points>& points_m, const Points& others_m, double within_m) {
  Eigen::Index num = 0;
  for (Eigen::Index i = 0; i < points_m.cols() && others_m.cols() > 0; ++i) {
    num += (others_m.colwise() - points_m.col(i)).colwise().norm().minCoeff() <= within_m;
  }
  return num;
}

Points MovePoints(const Points& points_m, const Pose2& T_new_old) {
  const auto [sin, cos] = ComputeSinCos(T_new_old.yaw_rad);
  Eigen::Matrix2d rotation;
  rotation << cos, -sin, sin, cos;
  return (rotation * points_m).colwise() + Eigen::Vector2d(T_new_old.x_m, T_new_old.y_m);
}

}  // namespace

ValidRays MovingObjectFilter::Filter(const ValidRays& rays, const Pose2& T_map_laser) const {
  const DrawingConstants::Moving& constants = constants_.moving;
  const Points hits_m = ComputeHits(rays);
  const Drawn* earlier = FindEarlier();
  const Points earlier_m =
      earlier ? MovePoints(ComputeHits(earlier->rays), Inverse(T_map_laser) * earlier->T_map_laser) : Points(2, 0);
  Points path_m = Points::Zero(2, std::ssize(drawn_) + 1);  // where the robot drove in the last metres, and where it is
  for (Eigen::Index i = 0; i < std::ssize(drawn_); ++i) {
    const Pose2 T_laser_then = Inverse(T_map_laser) * drawn_[static_cast<std::size_t>(i)].T_map_laser;
    path_m.col(i) << T_laser_then.x_m, T_laser_then.y_m;
  }
  ValidRays kept;
  for (const Object& object : FindObjects(hits_m, constants_)) {
    const auto& [first, size] = object;
    const auto object_m = hits_m.middleCols(first, size);
    if (CountNear(object_m, path_m, constants.beside_path_m) == size) continue;
    const bool may_move = MayMove(object_m, constants) && StandsOut(rays, object);
    if (may_move && 2 * CountNear(object_m, earlier_m, constants.same_m) <= size) continue;
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(first + size); ++i) {
      kept.angle_rad.push_back(rays.angle_rad[i]);
      kept.range_m.push_back(rays.range_m[i]);
    }
  }
  return 2 * kept.size() < rays.size() ? rays : kept;
}

void MovingObjectFilter::Add(const ValidRays& rays, const Pose2& T_map_laser) {
  if (!drawn_.empty()) path_m_ += Distance(T_map_last_, T_map_laser);
  T_map_last_ = T_map_laser;
  if (!drawn_.empty() && path_m_ - drawn_.back().path_m < constants_.moving.every_m) return;
  drawn_.push_back({path_m_, T_map_laser, rays});
  while (path_m_ - drawn_.front().path_m > constants_.moving.reach_m) drawn_.pop_front();
}

void MovingObjectFilter::Move(const Pose2& T_new_old) {
  T_map_last_ = T_new_old * T_map_last_;
  for (Drawn& drawn : drawn_) drawn.T_map_laser = T_new_old * drawn.T_map_laser;
}

const MovingObjectFilter::Drawn* MovingObjectFilter::FindEarlier() const {
  if (drawn_.empty()) return nullptr;
  auto earlier = drawn_.rbegin();
  while (earlier + 1 != drawn_.rend() && path_m_ - earlier->path_m < constants_.moving.stood_m) ++earlier;
  return &*earlier;
}

}  // namespace crsm
