#include "common/graph/pose_graph.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/math/random.hpp"

namespace crsm {
namespace {

/// How much an edge that may be wrong adds to the cost, and its weight in the next step: Geman and McClure's loss,
/// which for an error far beyond `doubt` [standard deviations, squared] grows no more.
struct Loss {
  double doubt;

  double operator()(double squared_error, bool may_be_wrong) const {
    return may_be_wrong ? doubt * squared_error / (doubt + squared_error) : squared_error;
  }
  double Weight(double squared_error, bool may_be_wrong) const {
    const double share = doubt / (doubt + squared_error);
    return may_be_wrong ? share * share : 1.0;
  }
};

/// The error of an edge, in standard deviations, and its derivatives by the two poses.
struct Linearised {
  Eigen::Vector3d error;
  Eigen::Matrix3d by_from;
  Eigen::Matrix3d by_to;

  Linearised(const GraphEdge& edge, const Pose2& from, const Pose2& to) {
    const auto [sin, cos] = ComputeSinCos(from.yaw_rad);
    const double dx_m = to.x_m - from.x_m;
    const double dy_m = to.y_m - from.y_m;
    const double x_m = cos * dx_m + sin * dy_m;  // `to` seen from `from`
    const double y_m = cos * dy_m - sin * dx_m;
    const Eigen::Vector3d difference(x_m - edge.T_from_to.x_m, y_m - edge.T_from_to.y_m,
                                     WrapAngle(to.yaw_rad - from.yaw_rad - edge.T_from_to.yaw_rad));
    Eigen::Matrix3d from_derivative, to_derivative;
    from_derivative << -cos, -sin, y_m, sin, -cos, -x_m, 0.0, 0.0, -1.0;
    to_derivative << cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0;
    using ByRows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Eigen::Matrix3d w = Eigen::Map<const ByRows>(edge.sqrt_information.data());
    error = w * difference;
    by_from = w * from_derivative;
    by_to = w * to_derivative;
  }
};

double ComputeSquaredError(const GraphEdge& edge, const std::vector<Pose2>& poses) {
  return Linearised(edge, poses[static_cast<std::size_t>(edge.from)], poses[static_cast<std::size_t>(edge.to)])
      .error.squaredNorm();
}

/// The normal equations of one step after the other: H step = -b. The first pose has no part in them.
class NormalEquations {
 public:
  explicit NormalEquations(std::size_t num_poses) : b_(3 * (static_cast<int>(num_poses) - 1)) {}

  /// Nothing is known yet.
  void Clear() {
    constexpr double kHold = 1e-9;  // what keeps a pose without edges where it is
    entries_.clear();
    for (int i = 0; i < static_cast<int>(b_.size()); ++i) entries_.emplace_back(i, i, kHold);
    b_.setZero();
  }

  /// The same edges in every step.
  void Add(const GraphEdge& edge, const Linearised& at, double weight) {
    AddBlock(edge.from, edge.from, weight * at.by_from.transpose() * at.by_from);
    AddBlock(edge.to, edge.to, weight * at.by_to.transpose() * at.by_to);
    AddBlock(edge.to, edge.from, weight * at.by_to.transpose() * at.by_from);
    AddBlock(edge.from, edge.to, weight * at.by_from.transpose() * at.by_to);
    AddErrors(edge, at, weight * at.error);
  }

  /// damping: added to the diagonal, as a share of it (Marquardt 1963). False where the equations have no solution.
  bool Factorise(double damping) {
    Eigen::SparseMatrix<double> h(b_.size(), b_.size());
    h.setFromTriplets(entries_.begin(), entries_.end());
    h.diagonal() *= 1.0 + damping;
    if (!std::exchange(analysed_, true)) cholesky_.analyzePattern(h);  // half of the work, and the same in every step
    cholesky_.factorize(h);
    return cholesky_.info() == Eigen::Success;
  }

  /// After Factorise.
  Eigen::VectorXd Solve() const { return cholesky_.solve(-b_); }

  /// Other errors of the same edges, for another Solve.
  void ClearErrors() { b_.setZero(); }
  void AddErrors(const GraphEdge& edge, const Linearised& at, const Eigen::Vector3d& weighted_error) {
    if (edge.from > 0) b_.segment<3>(3 * (edge.from - 1)) += at.by_from.transpose() * weighted_error;
    if (edge.to > 0) b_.segment<3>(3 * (edge.to - 1)) += at.by_to.transpose() * weighted_error;
  }

 private:
  void AddBlock(int row_pose, int column_pose, const Eigen::Matrix3d& block) {
    if (row_pose == 0 || column_pose == 0) return;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) entries_.emplace_back(3 * (row_pose - 1) + i, 3 * (column_pose - 1) + k, block(i, k));
    }
  }

  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::VectorXd b_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky_;
  bool analysed_ = false;
};

bool IsFinite(const Pose2& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad);
}

std::vector<Pose2> Moved(std::vector<Pose2> poses, const Eigen::VectorXd& step) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const auto at = 3 * (static_cast<Eigen::Index>(i) - 1);
    poses[i] = {poses[i].x_m + step[at], poses[i].y_m + step[at + 1], WrapAngle(poses[i].yaw_rad + step[at + 2])};
  }
  return poses;
}

}  // namespace

GraphEdge GraphEdge::Make(int from, int to, const Pose2& T_from_to, const MotionSigma& sigma,
                          const std::array<double, 2>& x_axis) {
  const auto& [cos, sin] = x_axis;
  return {from,
          to,
          T_from_to,
          {cos / sigma.x_m, sin / sigma.x_m, 0.0,   //
           -sin / sigma.y_m, cos / sigma.y_m, 0.0,  //
           0.0, 0.0, 1.0 / sigma.yaw_rad}};
}

int PoseGraph::AddPose(const Pose2& T_map_pose) {
  if (!IsFinite(T_map_pose)) throw std::invalid_argument("PoseGraph: a pose that is not finite");
  poses_.push_back(T_map_pose);
  return static_cast<int>(poses_.size()) - 1;
}

void PoseGraph::AddEdge(const GraphEdge& edge) {
  const auto Known = [&](int pose) { return pose >= 0 && pose < static_cast<int>(poses_.size()); };
  if (!Known(edge.from) || !Known(edge.to) || edge.from == edge.to) {
    throw std::invalid_argument("PoseGraph: an edge leads from one pose of the graph to another");
  }
  if (!IsFinite(edge.T_from_to) ||
      !std::ranges::all_of(edge.sqrt_information, [](double w) { return std::isfinite(w); })) {
    throw std::invalid_argument("PoseGraph: an edge that is not finite");
  }
  edges_.push_back(edge);
}

double PoseGraph::SquaredError(const GraphEdge& edge) const { return ComputeSquaredError(edge, poses_); }

GraphOptimisation PoseGraph::Optimise() {
  const double last_doubt = constants_.doubt;
  GraphOptimisation result;
  const auto Cost = [&] { return ComputeCost(poses_, last_doubt); };
  result.cost_before = result.cost_after = Cost();
  if (poses_.size() < 2 || edges_.empty()) return result;
  // A loop that closes metres at once lies where the loss is flat, and would not pull. So the doubt begins beyond the
  // largest error, and comes down step by step: graduated non-convexity (Yang, Antonante, Tzoumas and Carlone 2020).
  double doubt = last_doubt;
  for (const GraphEdge& edge : edges_) {
    if (edge.may_be_wrong) doubt = std::max(doubt, constants_.first_doubt * SquaredError(edge));
  }
  for (; doubt > last_doubt; doubt = std::max(doubt / constants_.release, last_doubt)) {
    result.iterations += Descend(doubt, constants_.steps_per_doubt);
  }
  result.iterations += Descend(last_doubt, constants_.steps_max);
  result.cost_after = Cost();
  return result;
}

bool PoseGraph::Sample(int num, std::uint64_t seed, const Visit& visit) const {
  if (poses_.size() < 2 || num < 1) return false;
  NormalEquations equations(poses_.size());
  equations.Clear();
  std::vector<Linearised> linearised;
  for (const GraphEdge& edge : edges_) {
    Linearised at(edge, poses_[static_cast<std::size_t>(edge.from)], poses_[static_cast<std::size_t>(edge.to)]);
    const double root = std::sqrt(Loss{constants_.doubt}.Weight(at.error.squaredNorm(), edge.may_be_wrong));
    at.by_from *= root;
    at.by_to *= root;
    equations.Add(edge, at, 1.0);
    linearised.push_back(at);
  }
  if (!equations.Factorise(0.0)) return false;
  Random random(seed);
  for (int sample = 0; sample < num; ++sample) {
    equations.ClearErrors();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const Eigen::Vector3d chance(random.Gaussian(), random.Gaussian(), random.Gaussian());
      equations.AddErrors(edges_[i], linearised[i], chance);
    }
    const Eigen::VectorXd step = equations.Solve();
    if (!step.allFinite()) return false;
    visit(Moved(poses_, step));
  }
  return true;
}

double PoseGraph::ComputeCost(const std::vector<Pose2>& poses, double doubt) const {
  double cost = 0.0;
  for (const GraphEdge& edge : edges_) cost += Loss{doubt}(ComputeSquaredError(edge, poses), edge.may_be_wrong);
  return cost;
}

/// Levenberg and Marquardt's steps, until one moves no pose by more than 0.1 mm. Returns how many.
int PoseGraph::Descend(double doubt, int most_iterations) {
  double cost = ComputeCost(poses_, doubt);
  double damping = constants_.damping_min;
  int iterations = 0;
  NormalEquations equations(poses_.size());
  for (bool ended = false; !ended && iterations < most_iterations; ++iterations) {
    equations.Clear();
    for (const GraphEdge& edge : edges_) {
      const Linearised at(edge, poses_[static_cast<std::size_t>(edge.from)], poses_[static_cast<std::size_t>(edge.to)]);
      equations.Add(edge, at, Loss{doubt}.Weight(at.error.squaredNorm(), edge.may_be_wrong));
    }
    for (bool better = false; !better && !ended;) {  // smaller and smaller steps, until one leads down
      const Eigen::VectorXd step = equations.Factorise(damping) ? equations.Solve() : Eigen::VectorXd();
      const bool solved = step.size() > 0 && step.allFinite();
      const std::vector<Pose2> moved = solved ? Moved(poses_, step) : poses_;
      const double moved_cost = ComputeCost(moved, doubt);
      better = moved_cost < cost;
      ended = damping > constants_.damping_max || (solved && step.cwiseAbs().maxCoeff() < constants_.small_step);
      damping = better ? std::max(damping / constants_.damping_change, constants_.damping_min)
                       : std::max(damping, constants_.damping_raised_min) * constants_.damping_change;
      if (better) poses_ = moved, cost = moved_cost;
    }
  }
  return iterations;
}

}  // namespace crsm
