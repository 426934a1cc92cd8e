#include "common/graph/map_error.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "common/graph/keyframe_edges.hpp"
#include "common/math/alignment.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

constexpr std::uint64_t kSeed = 1;

/// The poses, and how well each motion between them is known.
PoseGraph MakePoseGraph(const KnownMotions& motions) {
  PoseGraph graph;
  for (const Pose2& pose : motions.poses) graph.AddPose(pose);
  for (const auto& [from, to, edge] : motions.edges) graph.AddEdge(ToGraphEdge(edge, from, to));
  return graph;
}

/// What the mapped ways told.
struct Driven {
  double driven_m = 0.0;
  double m2 = 0.0;    ///< variance over them ...
  double rad2 = 0.0;  ///< ... and of the turns

  explicit Driven(const KnownMotions& motions) {
    for (const auto& [from, to, edge] : motions.edges) {
      if (edge.told_by != ToldBy::kMatch) continue;
      driven_m += Length(edge.T_older_newer);
      m2 += edge.sigma.x_m * edge.sigma.x_m;
      rad2 += edge.sigma.yaw_rad * edge.sigma.yaw_rad;
    }
  }

  /// What a drive over a way tells, if the laser sees there what it has seen on these, and the places at both ends are
  /// found again.
  MotionSigma FindSigmaOfDrive(double way_m, const MotionSigma& loop) const {
    const double share = driven_m > 0.0 ? way_m / driven_m : 0.0;
    const double rad = std::sqrt(share * rad2);
    const double m = std::hypot(std::sqrt(share * m2), 0.5 * way_m * rad);  // a turn half-way moves the end so far
    return {std::hypot(m, loop.x_m), std::hypot(m, loop.y_m), std::hypot(rad, loop.yaw_rad)};
  }
};

/// Distances of poses from others, when they lie on these as well as they can [m].
std::vector<double> FindDistances(const std::vector<Pose2>& poses, const std::vector<Pose2>& others) {
  const Alignment alignment = FindAlignment(poses, others);
  const double norm = std::hypot(alignment.sin, alignment.cos);
  const double sin = norm > 0.0 ? alignment.sin / norm : 0.0;
  const double cos = norm > 0.0 ? alignment.cos / norm : 1.0;
  std::vector<double> distances_m;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double x_m = poses[i].x_m - alignment.mean.x_m;
    const double y_m = poses[i].y_m - alignment.mean.y_m;
    distances_m.push_back(std::hypot(cos * x_m - sin * y_m - (others[i].x_m - alignment.others_mean.x_m),
                                     sin * x_m + cos * y_m - (others[i].y_m - alignment.others_mean.y_m)));
  }
  return distances_m;
}

/// So far off is what is furthest off in most samples.
double FindBound(std::vector<double> largest_m, const GraphConstants& constants) {
  std::ranges::sort(largest_m);
  const auto rank = static_cast<std::size_t>(constants.map_error.quantile * static_cast<double>(largest_m.size() - 1));
  return constants.map_error.least_m + largest_m[rank];
}

/// What samples say of a pose graph.
struct Spread {
  std::vector<double> largest_m;  ///< by sample
  std::vector<double> sums_m2;    ///< of squared distances, by pose
};

Spread FindSpread(const PoseGraph& graph, const GraphConstants& constants) {
  Spread spread;
  spread.sums_m2.resize(graph.poses().size());
  graph.Sample(constants.map_error.samples, kSeed, [&](const std::vector<Pose2>& sample) {
    const std::vector<double> distances_m = FindDistances(sample, graph.poses());
    for (std::size_t i = 0; i < distances_m.size(); ++i) spread.sums_m2[i] += distances_m[i] * distances_m[i];
    spread.largest_m.push_back(*std::ranges::max_element(distances_m));
  });
  return spread;
}

/// Of each square the largest, in so few squares that they can be looked at.
std::vector<Doubt> ThinOut(const std::vector<Pose2>& poses, const Spread& spread, const GraphConstants& constants) {
  // Of a distance in two directions that err alike, at the quantile, as a multiple of the root mean square.
  const double quantile = std::sqrt(-std::log(1.0 - constants.map_error.quantile));
  std::map<std::pair<std::int64_t, std::int64_t>, Doubt> doubts;
  for (double side_m = 1.0; doubts.empty() || doubts.size() > MapError::kMostDoubts; side_m *= 2.0) {
    doubts.clear();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double mean_m2 = spread.sums_m2[i] / static_cast<double>(spread.largest_m.size());
      const double off_m = constants.map_error.least_m + quantile * std::sqrt(mean_m2);
      const auto Round = [&](double x_m) { return static_cast<std::int64_t>(std::floor(x_m / side_m)); };
      Doubt& doubt = doubts[{Round(poses[i].x_m), Round(poses[i].y_m)}];
      if (off_m > doubt.off_m) doubt = {{poses[i].x_m, poses[i].y_m}, off_m};
    }
  }
  std::vector<Doubt> thinned;
  for (const auto& [square, doubt] : doubts) thinned.push_back(doubt);
  return thinned;
}

/// Tries drives between places of the path, one after the other.
class WayBackSearch {
 public:
  WayBackSearch(const KnownMotions& motions, const PoseGraph& poses, const GraphConstants& constants)
      : poses_(poses), constants_(constants), driven_(motions) {
    const auto num = poses.poses().size();
    const std::size_t every = std::max<std::size_t>(1, num / kMostPlaces);
    double way_m = 0.0;
    for (std::size_t i = 0; i < num; ++i) {
      if (i > 0) way_m += Distance(poses.poses()[i - 1], poses.poses()[i]);
      if (i % every != 0) continue;
      places_.push_back(i);
      ways_m_.push_back(way_m);
    }
    poses.Sample(constants.map_error.samples, kSeed, [&](const std::vector<Pose2>& sample) {
      samples_.emplace_back();
      for (const std::size_t i : places_) samples_.back().push_back(sample[i]);
    });
    for (const std::size_t i : places_) at_.push_back(poses.poses()[i]);
  }

  /// Nothing if none would take a third off a bound.
  std::optional<WayBack> Find(double most_m) {
    std::pair<std::size_t, std::size_t> best;
    double least_m = kHelps * most_m;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      for (std::size_t k = i + 1; k < places_.size(); ++k) {
        if (ways_m_[k] - ways_m_[i] < kDetour * Distance(at_[i], at_[k])) continue;  // there is no other way
        const double then_m = BoundAfter(i, k);
        if (then_m >= least_m) continue;
        least_m = then_m;
        best = {i, k};
      }
    }
    if (best.second == 0) return std::nullopt;
    const auto& [from, to] = std::pair(at_[best.first], at_[best.second]);
    PoseGraph with = poses_;
    with.AddEdge(GraphEdge::Make(static_cast<int>(places_[best.first]), static_cast<int>(places_[best.second]),
                                 Inverse(from) * to, FindSigmaOfDrive(Distance(from, to))));
    const Spread spread = FindSpread(with, constants_);
    const double then_m = spread.largest_m.empty() ? most_m : FindBound(spread.largest_m, constants_);
    if (then_m >= kHelps * most_m) return std::nullopt;
    return WayBack{{to.x_m, to.y_m}, {from.x_m, from.y_m}, then_m};
  }

 private:
  static constexpr std::size_t kMostPlaces = 40;
  static constexpr double kDetour = 2.0;
  static constexpr double kHelps = 2.0 / 3.0;

  MotionSigma FindSigmaOfDrive(double way_m) const { return driven_.FindSigmaOfDrive(way_m, constants_.edges.loop); }

  /// A measurement of where one place is, seen from another: the samples move by what they have in common with it
  /// (ensemble Kalman filter: Evensen 1994).
  double BoundAfter(std::size_t from, std::size_t to) const {
    const Pose2 expected = Inverse(at_[from]) * at_[to];
    const MotionSigma sigma = FindSigmaOfDrive(Length(expected));
    const auto num = static_cast<Eigen::Index>(samples_.size());
    Eigen::Matrix3Xd seen(3, num);
    Eigen::MatrixXd moved(2 * std::ssize(at_), num);
    for (Eigen::Index s = 0; s < num; ++s) {
      const std::vector<Pose2>& sample = samples_[static_cast<std::size_t>(s)];
      const Pose2 there = Inverse(sample[from]) * sample[to];
      seen.col(s) << there.x_m - expected.x_m, there.y_m - expected.y_m, WrapAngle(there.yaw_rad - expected.yaw_rad);
      for (std::size_t i = 0; i < at_.size(); ++i) {
        moved.col(s).segment<2>(2 * static_cast<Eigen::Index>(i)) << sample[i].x_m - at_[i].x_m,
            sample[i].y_m - at_[i].y_m;
      }
    }
    Eigen::Matrix3d covariance = seen * seen.transpose() / static_cast<double>(num);
    covariance.diagonal() += Eigen::Vector3d(sigma.x_m, sigma.y_m, sigma.yaw_rad).cwiseAbs2();
    const Eigen::MatrixX3d gain = moved * seen.transpose() / static_cast<double>(num) * covariance.inverse();
    Random random(kSeed);
    std::vector<double> largest_m;
    std::vector<Pose2> after = at_;
    for (Eigen::Index s = 0; s < num; ++s) {
      const Eigen::Vector3d noise(sigma.x_m * random.Gaussian(), sigma.y_m * random.Gaussian(),
                                  sigma.yaw_rad * random.Gaussian());
      const Eigen::VectorXd left = moved.col(s) - gain * (seen.col(s) + noise);
      for (std::size_t i = 0; i < at_.size(); ++i) {
        after[i].x_m = at_[i].x_m + left[2 * static_cast<Eigen::Index>(i)];
        after[i].y_m = at_[i].y_m + left[2 * static_cast<Eigen::Index>(i) + 1];
      }
      const std::vector<double> distances_m = FindDistances(after, at_);
      largest_m.push_back(*std::ranges::max_element(distances_m));
    }
    return FindBound(std::move(largest_m), constants_);
  }

  const PoseGraph& poses_;
  const GraphConstants& constants_;
  Driven driven_;
  std::vector<std::size_t> places_;          ///< indices of poses, along the path
  std::vector<double> ways_m_;               ///< how far along it
  std::vector<Pose2> at_;                    ///< where they are
  std::vector<std::vector<Pose2>> samples_;  ///< where they may be
};

}  // namespace

std::vector<int> KnownMotions::Add(const KeyframeGraph& graph, const KeyframePoses& poses_of_graph,
                                   const std::vector<bool>& is_taken, const GraphConstants::Edges& constants) {
  const auto IsTaken = [&](KeyframeId id) { return is_taken[static_cast<std::size_t>(id.trajectory)]; };
  std::vector<int> first_of;
  for (std::size_t trajectory = 0; trajectory < poses_of_graph.size(); ++trajectory) {
    first_of.push_back(static_cast<int>(poses.size()));
    if (is_taken[trajectory])
      poses.insert(poses.end(), poses_of_graph[trajectory].begin(), poses_of_graph[trajectory].end());
  }
  const auto Index = [&](KeyframeId id) { return first_of[static_cast<std::size_t>(id.trajectory)] + id.number; };
  for (const KeyframeEdge& edge : FindEdges(graph, constants)) {
    if (IsTaken(edge.older) && IsTaken(edge.newer)) edges.push_back({Index(edge.older), Index(edge.newer), edge});
  }
  return first_of;
}

std::optional<MapError> EstimateMapError(const KnownMotions& motions, const GraphConstants& constants,
                                         bool with_way_back) {
  const PoseGraph poses = MakePoseGraph(motions);
  const Spread spread = FindSpread(poses, constants);
  if (spread.largest_m.empty()) return std::nullopt;
  MapError error;
  error.most_m = FindBound(spread.largest_m, constants);
  constexpr double kFarthest_m = 1e5;  // no map is so large
  if (!(error.most_m < kFarthest_m)) return std::nullopt;
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(spread.sums_m2) - spread.sums_m2.begin());
  error.at = {poses.poses()[worst].x_m, poses.poses()[worst].y_m};
  error.doubts = ThinOut(poses.poses(), spread, constants);
  if (with_way_back && error.most_m > constants.map_error.way_back_m)
    error.way_back = WayBackSearch(motions, poses, constants).Find(error.most_m);
  return error;
}

std::optional<Slip> FindSlip(const KeyframeGraph& graph, const KeyframePoses& poses, const std::vector<bool>& is_shown,
                             double least_m) {
  std::optional<Slip> slip;
  for (const KeyframeId id : graph.ids()) {
    if (id.number == 0 || !is_shown[static_cast<std::size_t>(id.trajectory)]) continue;
    const Pose2& before = At(poses, {id.trajectory, id.number - 1});
    const Pose2& at = At(poses, id);
    const double off_m = Distance(before * graph.keyframe(id).T_previous_this, at);
    if (off_m <= std::max(least_m, slip ? slip->off_m : 0.0)) continue;
    slip = Slip{{at.x_m, at.y_m}, off_m};
  }
  return slip;
}

}  // namespace crsm
