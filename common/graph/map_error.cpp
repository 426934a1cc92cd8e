#include "common/graph/map_error.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "common/math/alignment.hpp"
#include "common/math/median.hpp"
#include "common/math/symmetric.hpp"

namespace crsm {
namespace {

using Constants = GraphConstants::MapError;

/// What tells a motion. The errors of one kind are about alike.
enum Kind : std::uint8_t { kWalls, kHabit, kProximity, kLoop, kWheels, kNumKinds };

/// By how much the errors of each kind are larger than was taken for granted.
using Scales = std::array<double, kNumKinds>;

double Seconds(std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); }

/// What is known of the motions of some trajectories.
class ErrorGraph {
 public:
  ErrorGraph(const KeyframeGraph& graph, const std::vector<bool>& is_shown, const WallSigmas& walls,
             const Constants& constants)
      : graph_(graph), walls_(walls), constants_(constants) {
    for (int trajectory = 0; trajectory < graph.num_trajectories(); ++trajectory) {
      const bool shown = is_shown[static_cast<std::size_t>(trajectory)];
      first_of_.push_back(shown ? static_cast<int>(ids_.size()) : kNotShown);
      for (int number = 0; shown && number < graph.size(trajectory); ++number) ids_.push_back({trajectory, number});
    }
    usual_m_s_ = FindUsualPace();
    scales_.fill(1.0);
  }

  /// Takes the errors for what the residuals say, as far as these are redundant.
  void Calibrate() {
    const PoseGraph poses = Make();
    const auto variances = poses.Sample(constants_.samples, kSeed, [](const std::vector<Pose2>&) {});
    if (variances.empty()) return;
    Scales squares{}, redundancies{};
    for (std::size_t i = 0; i < variances.size(); ++i) {
      const std::array<double, 3> errors = poses.SquaredErrors(poses.edges()[i]);
      for (std::size_t row = 0; row < 3; ++row) {
        squares[kinds_[i][row]] += errors[row];
        redundancies[kinds_[i][row]] += std::max(0.0, 1.0 - variances[i][row]);
      }
    }
    const double prior = constants_.prior_weight;
    for (std::size_t kind = 0; kind < kNumKinds; ++kind) {
      scales_[kind] = std::sqrt((prior + squares[kind]) / (prior + redundancies[kind]));
    }
  }

  /// Poses of ids() and edges between them.
  PoseGraph Make() {
    PoseGraph poses;
    kinds_.clear();
    for (const KeyframeId id : ids_) poses.AddPose(graph_.pose(id));
    for (const KeyframeId id : ids_) AddEdgesOf(id, poses);
    for (const Loop& loop : graph_.loops()) {
      if (IndexOf(loop.older) == kNotShown || IndexOf(loop.newer) == kNotShown) continue;
      Add(loop.older, loop.newer, loop.T_older_newer, constants_.loop, {kLoop, kLoop, kLoop}, {1.0, 0.0}, poses);
    }
    return poses;
  }

  static constexpr std::uint64_t kSeed = 1;

 private:
  static constexpr int kNotShown = -1;

  int IndexOf(KeyframeId id) const {
    const int first = first_of_[static_cast<std::size_t>(id.trajectory)];
    return first == kNotShown ? kNotShown : first + id.number;
  }

  double SecondsBefore(KeyframeId id) const {
    return std::max(0.0, Seconds(graph_.keyframe(*graph_.Before(id)).utime, graph_.keyframe(id).utime));
  }

  /// The pace of the robot where walls told how far it went; of all motions, if they never did [m/s].
  double FindUsualPace() const {
    std::vector<double> told_m_s, all_m_s;
    for (const KeyframeId id : ids_) {
      if (id.number == 0 || SecondsBefore(id) == 0.0) continue;
      const Keyframe& at = graph_.keyframe(id);
      all_m_s.push_back(Length(at.T_previous_this) / SecondsBefore(id));
      if (!at.degenerate_axis) told_m_s.push_back(all_m_s.back());
    }
    if (!told_m_s.empty()) all_m_s = std::move(told_m_s);
    return all_m_s.empty() ? 0.0 : FindMedian(std::move(all_m_s));
  }

  void Add(KeyframeId from, KeyframeId to, const Pose2& T_from_to, const MotionSigma& sigma,
           const std::array<Kind, 3>& kinds, const std::array<double, 2>& x_axis, PoseGraph& poses) {
    const MotionSigma scaled{scales_[kinds[0]] * sigma.x_m, scales_[kinds[1]] * sigma.y_m,
                             scales_[kinds[2]] * sigma.yaw_rad};
    GraphEdge edge = GraphEdge::Make(IndexOf(from), IndexOf(to), T_from_to, scaled, x_axis);
    edge.may_be_wrong = kinds[0] == kLoop || kinds[0] == kWheels;
    poses.AddEdge(edge);
    kinds_.push_back(kinds);
  }

  void AddEdgesOf(KeyframeId id, PoseGraph& poses) {
    const Keyframe& at = graph_.keyframe(id);
    const auto before = graph_.Before(id);
    if (!before || IndexOf(*before) == kNotShown) return;
    const bool begins = id.number == 0;
    if (!begins) AddMatched(*before, id, at.T_previous_this, constants_.step, kWalls, poses);
    const bool wheels_tell = begins ? graph_.IsBridged(id.trajectory) : at.DoWheelsTell();
    if (wheels_tell) {
      const auto& [T_from_to, sigma_m, sigma_rad] = *at.by_wheels;
      Add(*before, id, T_from_to, {sigma_m, sigma_m, sigma_rad}, {kWheels, kWheels, kWheels}, {1.0, 0.0}, poses);
    }
    if (!at.constraint || at.constraint_wrong || IndexOf(at.constraint->keyframe) == kNotShown) return;
    AddMatched(at.constraint->keyframe, id, at.constraint->T_keyframe_this, constants_.proximity, kProximity, poses);
  }

  /// What a match tells of where a keyframe is, seen from an older one.
  void AddMatched(KeyframeId older, KeyframeId id, const Pose2& T_older_this, MotionSigma sigma, Kind kind,
                  PoseGraph& poses) {
    const Keyframe& at = graph_.keyframe(id);
    const WallSigma& walls = walls_[static_cast<std::size_t>(id.trajectory)][static_cast<std::size_t>(id.number)];
    const double share = constants_.walls;
    sigma = {std::hypot(sigma.x_m, share * walls.sigma.x_m), std::hypot(sigma.y_m, share * walls.sigma.y_m),
             std::hypot(sigma.yaw_rad, share * walls.sigma.yaw_rad)};
    std::array<double, 2> axis = walls.axis;
    if (at.degenerate_axis) {
      axis = *at.degenerate_axis;
      sigma.x_m = std::max(sigma.y_m, FindAlongSigma(id, walls));
    }
    if (at.after_lost) {
      const double times = constants_.across_lost;
      sigma = {times * sigma.x_m, times * sigma.y_m, times * sigma.yaw_rad};
    }
    Add(older, id, T_older_this, sigma, {at.degenerate_axis ? kHabit : kind, kind, kind},
        TurnAxis(axis, T_older_this.yaw_rad), poses);
  }

  /// Along a degenerate direction: how the robot drives, and the little that its walls told. It starts from rest.
  double FindAlongSigma(KeyframeId id, const WallSigma& walls) const {
    const double way_m = Length(graph_.keyframe(id).T_previous_this);
    const double differs_m = id.number > 1 ? std::abs(usual_m_s_ * SecondsBefore(id) - way_m) : 0.0;
    const double by_habit_m = std::max(constants_.uneven * way_m, differs_m);
    return 1.0 / std::hypot(1.0 / std::max(by_habit_m, 1e-9), 1.0 / walls.along_m);
  }

  const KeyframeGraph& graph_;
  const WallSigmas& walls_;
  const Constants& constants_;
  std::vector<KeyframeId> ids_;  ///< in the order of the poses
  std::vector<int> first_of_;    ///< by trajectory
  double usual_m_s_ = 0.0;
  Scales scales_{};
  std::vector<std::array<Kind, 3>> kinds_;  ///< of the errors of each edge
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

}  // namespace

WallSigma FindWallSigma(const ScanMatch& match, const MatchConstants::Uncertainty& constants, double cell_size_m) {
  const std::array<double, 6>& c = match.covariance;
  const double map_m = constants.sigma_cells * cell_size_m;
  Eigen::Matrix2d covariance;
  covariance << c[0] - map_m * map_m, c[1], c[1], c[3] - map_m * map_m;
  const auto [least, axis] = FindWeakest(-covariance);
  const double along_m2 = std::max(-least, 1e-9);
  const double across_m2 = std::max(covariance.trace() + least, 1e-9);
  WallSigma walls;
  walls.axis = TurnAxis({axis.x(), axis.y()}, -match.T_map_laser.yaw_rad);
  walls.sigma = {std::sqrt(along_m2), std::sqrt(across_m2),
                 std::sqrt(std::max(c[5] - constants.map_rad * constants.map_rad, 0.0))};
  const double unknown = 1.0 / (constants.unknown_m * constants.unknown_m);
  const double told = 1.0 / along_m2 - unknown - constants.noise_share * (1.0 / across_m2 - unknown);
  walls.along_m = told > 0.0 ? 1.0 / std::sqrt(told) : HUGE_VAL;
  return walls;
}

std::optional<MapError> EstimateMapError(const KeyframeGraph& graph, const std::vector<bool>& is_shown,
                                         const WallSigmas& walls, const Constants& constants) {
  ErrorGraph error_graph(graph, is_shown, walls, constants);
  error_graph.Calibrate();
  const PoseGraph poses = error_graph.Make();
  std::vector<double> largest_m;
  std::vector<double> sums_m2(poses.poses().size(), 0.0);
  const auto variances = poses.Sample(constants.samples, ErrorGraph::kSeed, [&](const std::vector<Pose2>& sample) {
    const std::vector<double> distances_m = FindDistances(sample, poses.poses());
    for (std::size_t i = 0; i < distances_m.size(); ++i) sums_m2[i] += distances_m[i] * distances_m[i];
    largest_m.push_back(*std::ranges::max_element(distances_m));
  });
  if (variances.empty()) return std::nullopt;
  std::ranges::sort(largest_m);
  const auto rank = static_cast<std::size_t>(constants.quantile * static_cast<double>(largest_m.size() - 1));
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(sums_m2) - sums_m2.begin());
  const Pose2& at = poses.poses()[worst];
  const double most_m = constants.least_m + constants.factor * largest_m[rank];
  constexpr double kFarthest_m = 1e5;  // no map is so large
  return most_m < kFarthest_m ? std::optional(MapError{most_m, {at.x_m, at.y_m}}) : std::nullopt;
}

}  // namespace crsm
