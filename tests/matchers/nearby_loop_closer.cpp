#include "tests/matchers/nearby_loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/scan/hits.hpp"

namespace crsm {
namespace {

constexpr double kSearchEvery_m = 5.0;
constexpr double kNear_m = 4.0;      // as far as poses may have drifted
constexpr double kLongAgo_m = 40.0;  // along the path
constexpr int kAround = 10;          // keyframes to each side of the older one whose hits are matched to
constexpr double kGoodFit = 0.8;     // share of the hits ...
constexpr double kOnWall_m = 0.1;    // ... that lie so near to another one

Eigen::Matrix2Xd Move(const Pose2& pose, const Eigen::Matrix2Xd& points_m) {
  const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
  const Eigen::Matrix2d rotation = (Eigen::Matrix2d() << cos, -sin, sin, cos).finished();
  return (rotation * points_m).colwise() + Eigen::Vector2d(pose.x_m, pose.y_m);
}

/// Points and the nearest one to each of them, where there is one in reach.
struct Pairs {
  Eigen::Matrix2Xd points_m;
  Eigen::Matrix2Xd nearest_m;
};

Pairs PairUp(const Eigen::Matrix2Xd& points_m, const Eigen::Matrix2Xd& map_m, double reach_m) {
  Pairs pairs{Eigen::Matrix2Xd(2, points_m.cols()), Eigen::Matrix2Xd(2, points_m.cols())};
  Eigen::Index num = 0;
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    Eigen::Index nearest = 0;
    if ((map_m.colwise() - points_m.col(i)).colwise().squaredNorm().minCoeff(&nearest) > reach_m * reach_m) continue;
    pairs.points_m.col(num) = points_m.col(i);
    pairs.nearest_m.col(num++) = map_m.col(nearest);
  }
  pairs.points_m.conservativeResize(2, num);
  pairs.nearest_m.conservativeResize(2, num);
  return pairs;
}

/// The motion that brings points nearest to their partners: at least two pairs.
Pose2 Align(const Pairs& pairs) {
  const Eigen::Vector2d from = pairs.points_m.rowwise().mean();
  const Eigen::Vector2d to = pairs.nearest_m.rowwise().mean();
  const Eigen::Matrix2d moment = (pairs.points_m.colwise() - from) * (pairs.nearest_m.colwise() - to).transpose();
  const double yaw_rad = std::atan2(moment(0, 1) - moment(1, 0), moment(0, 0) + moment(1, 1));
  return Pose2{to.x(), to.y(), yaw_rad} * Pose2{-from.x(), -from.y(), 0.0};
}

/// Iterative closest point: Besl and McKay, "A method for registration of 3-D shapes", PAMI 1992.
std::optional<Pose2> MatchPoints(const Eigen::Matrix2Xd& points_m, const Eigen::Matrix2Xd& map_m, Pose2 pose) {
  constexpr int kIterations = 40;
  for (int i = 0; i < kIterations; ++i) {
    const double reach_m = std::max(0.2, kNear_m * (1.0 - 2.0 * i / kIterations));
    const Pairs pairs = PairUp(Move(pose, points_m), map_m, reach_m);
    if (pairs.points_m.cols() < 2) return std::nullopt;
    pose = Align(pairs) * pose;
  }
  const auto num_fit = PairUp(Move(pose, points_m), map_m, kOnWall_m).points_m.cols();
  if (static_cast<double>(num_fit) < kGoodFit * static_cast<double>(points_m.cols())) return std::nullopt;
  return pose;
}

}  // namespace

std::optional<GraphUpdate> NearbyLoopCloser::Add(Keyframe keyframe, const std::optional<EarlierSearch>& /*earlier*/) {
  GraphUpdate update;
  update.keyframe = graph_.Add(std::move(keyframe));
  if (update.keyframe.number == 0) next_search_m_ = 0.0;
  const auto loop = FindLoop();
  if (!loop) return std::nullopt;
  next_search_m_ = graph_.path_m(update.keyframe) + kSearchEvery_m;
  update.previous = std::exchange(last_update_, update.keyframe);
  update.closed = {*loop};
  graph_.Join(*loop);
  graph_.AddLoop(*loop);
  update.rejected = graph_.Optimise();
  for (int i = 0; i < graph_.num_trajectories(); ++i) {
    update.moved.push_back({{i, 0}, graph_.poses()[static_cast<std::size_t>(i)]});
  }
  return update;
}

std::optional<Loop> NearbyLoopCloser::FindLoop() const {
  const KeyframeId newest = *graph_.newest();
  if (graph_.path_m(newest) < next_search_m_) return std::nullopt;
  const auto nearest = FindNearest();
  if (!nearest) return std::nullopt;
  const Pose2 expected = Inverse(graph_.pose(*nearest)) * graph_.pose(newest);
  const auto T_older_newer =
      MatchPoints(ComputeHits(graph_.keyframe(newest).rays.Unpack()), HitsAround(*nearest), expected);
  if (!T_older_newer) return std::nullopt;
  return Loop{*nearest, newest, *T_older_newer};
}

/// The nearest keyframe of long ago, of the newest one's component.
std::optional<KeyframeId> NearbyLoopCloser::FindNearest() const {
  const KeyframeId newest = *graph_.newest();
  double nearest_m = kNear_m;
  std::optional<KeyframeId> nearest;
  for (const KeyframeId id : graph_.ids()) {
    const double away_m = Length(Inverse(graph_.pose(id)) * graph_.pose(newest));
    const bool long_ago = id.trajectory != newest.trajectory || graph_.path_m(newest) - graph_.path_m(id) > kLongAgo_m;
    if (!long_ago || away_m >= nearest_m || !graph_.HangTogether(id, newest)) continue;
    nearest_m = away_m;
    nearest = id;
  }
  return nearest;
}

/// In the frame of the keyframe in the middle.
Eigen::Matrix2Xd NearbyLoopCloser::HitsAround(KeyframeId middle) const {
  const int last = std::min(graph_.LastOf(middle.trajectory).number, middle.number + kAround);
  Eigen::Matrix2Xd hits_m(2, 0);
  for (KeyframeId at{middle.trajectory, std::max(0, middle.number - kAround)}; at.number <= last; ++at.number) {
    const Eigen::Matrix2Xd more_m =
        Move(Inverse(graph_.pose(middle)) * graph_.pose(at), ComputeHits(graph_.keyframe(at).rays.Unpack()));
    hits_m.conservativeResize(2, hits_m.cols() + more_m.cols());
    hits_m.rightCols(more_m.cols()) = more_m;
  }
  return hits_m;
}

}  // namespace crsm
