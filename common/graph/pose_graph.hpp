#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/math/pose2.hpp"

namespace crsm {

/// How well a motion is known: standard deviations in the frame of the pose from which it leads.
struct MotionSigma {
  double x_m;
  double y_m;
  double yaw_rad;
  friend bool operator==(const MotionSigma&, const MotionSigma&) = default;
};

/// An axis of a pose's frame in another one, in which that pose has this yaw.
inline std::array<double, 2> TurnAxis(const std::array<double, 2>& axis, double yaw_rad) {
  const auto [sin, cos] = ComputeSinCos(yaw_rad);
  return {cos * axis[0] - sin * axis[1], sin * axis[0] + cos * axis[1]};
}

/// How poses are found that agree best with all edges.
struct OptimisationConstants {
  double doubt = 9.0;         ///< standard deviations, squared: three, of right loops hardly one has more
  double first_doubt = 2.0;   ///< times the largest squared error of an edge that may be wrong ...
  double release = 4.0;       ///< ... by which it is divided from then on, after ...
  int steps_per_doubt = 2;    ///< ... so many steps, at most
  int steps_max = 30;         ///< with the last doubt
  double small_step = 1e-4;   ///< [m] and [rad]: one that moves no pose by more is the last
  double damping_min = 1e-9;  ///< of the diagonal, as a share
  double damping_max = 1e6;   ///< where no step leads down
  double damping_raised_min = 1e-6;
  double damping_change = 10.0;  ///< divided by it after a step that leads down, else multiplied
};

/// What a match says about two poses of a graph.
struct GraphEdge {
  int from;
  int to;
  Pose2 T_from_to;
  /// W, row by row: an error e = [x_m, y_m, yaw_rad] in the frame of `from` costs |W e|^2.
  std::array<double, 9> sqrt_information;
  bool may_be_wrong = false;  ///< a loop: the more it contradicts the others, the less it counts

  /// With errors along a frame's axes that are independent of each other. x_axis: that of `sigma`, a unit vector in the
  /// frame of `from`, for a corridor that leaves its own direction open.
  static GraphEdge Make(int from, int to, const Pose2& T_from_to, const MotionSigma& sigma,
                        const std::array<double, 2>& x_axis = {1.0, 0.0});
};

/// What an optimisation did.
struct GraphOptimisation {
  int iterations = 0;
  double cost_before = 0.0;
  double cost_after = 0.0;
};

/// Poses and what is known of the motions between them; the first pose stays where it is. Source: Grisetti, Kuemmerle,
/// Stachniss and Burgard, "A Tutorial on Graph-Based SLAM", IEEE ITS Magazine 2010.
///
/// The same calls give the same poses, to the last bit, on every x86-64 machine: one thread, sums in one order, sines
/// of our own, no logarithm.
class PoseGraph {
 public:
  PoseGraph() = default;
  explicit PoseGraph(const OptimisationConstants& constants) : constants_(constants) {}

  /// The index of the new pose.
  int AddPose(const Pose2& T_map_pose);

  /// Throws std::invalid_argument if one of its poses is not in the graph, both are the same, or a number is not
  /// finite.
  void AddEdge(const GraphEdge& edge);

  const std::vector<Pose2>& poses() const { return poses_; }
  const std::vector<GraphEdge>& edges() const { return edges_; }

  /// How much an edge contradicts the poses: the squared error in standard deviations.
  double SquaredError(const GraphEdge& edge) const;

  /// Moves the poses to where they agree best with all edges: the sum of squared errors, of which an edge that may be
  /// wrong adds no more than a bound (Geman and McClure's loss). Costs a sparse factorisation a step.
  GraphOptimisation Optimise();

  using Visit = std::function<void(const std::vector<Pose2>&)>;

  /// Poses as they may be as well: `num` samples of what the edges leave open around where the poses are, which is to
  /// be where Optimise leaves them. One factorisation, and a solution for each sample: with whitened derivatives A,
  /// H = A^T A and z of variance 1, the step of H step = A^T z has the covariance H^-1. Whether the equations have a
  /// solution.
  bool Sample(int num, std::uint64_t seed, const Visit& visit) const;

 private:
  double ComputeCost(const std::vector<Pose2>& poses, double doubt) const;
  int Descend(double doubt, int most_iterations);

  OptimisationConstants constants_ = {};
  std::vector<Pose2> poses_;
  std::vector<GraphEdge> edges_;
};

}  // namespace crsm
