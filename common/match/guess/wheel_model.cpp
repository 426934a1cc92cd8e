#include "common/match/guess/wheel_model.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "common/match/guess/motion_prediction.hpp"

namespace crsm {
namespace {

using Constants = MatchConstants::WheelModel;

double Square(double value) { return value * value; }

/// Sums of squares forget, so that they never overflow, and what was long ago counts less.
template <std::size_t N>
void Forget(std::array<double, N>& sums, double share) {
  for (double& sum : sums) sum *= share;
}

double Seconds(std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); }

/// How far two motions are apart [m]; turns count at 1 m from the laser.
double ComputeDistance(const Pose2& a, const Pose2& b) {
  return std::abs(a.x_m - b.x_m) + std::abs(a.y_m - b.y_m) + std::abs(WrapAngle(a.yaw_rad - b.yaw_rad));
}

/// Whether a robot can move so far in that time: odometry that was reset, or not sent for a while, jumps.
bool IsMotion(const Pose2& motion, double elapsed_s, const Constants& constants) {
  return Length(motion) <= std::max(constants.jump_m, constants.fastest * elapsed_s) &&
         std::abs(motion.yaw_rad) <= std::max(constants.jump_rad, constants.fastest * elapsed_s);
}

/// The motion of the wheels since the newest of these scans; nothing where one has none, or they jump.
std::optional<Pose2> FindWheels(std::span<const ScanMatch> recent, std::int64_t utime,
                                const std::optional<Pose2>& T_odom_robot, const Constants& constants) {
  if (recent.empty() || !recent.back().T_odom_robot || !T_odom_robot) return std::nullopt;
  const Pose2 motion = Inverse(*recent.back().T_odom_robot) * *T_odom_robot;
  const bool is_motion = IsMotion(motion, Seconds(recent.back().utime, utime), constants);
  return is_motion ? std::optional(motion) : std::nullopt;
}

/// Whether odometry tells another pose than at the newest of these scans.
bool Moves(std::span<const ScanMatch> recent, const std::optional<Pose2>& T_odom_robot) {
  return !recent.empty() && recent.back().T_odom_robot && T_odom_robot && *recent.back().T_odom_robot != *T_odom_robot;
}

/// Two variances, per metre and per radian, of which a sum makes that of a step: least squares, none negative.
struct Noise {
  double per_m;
  double per_rad;
};

Noise SolveNoise(const std::array<double, 5>& sums, double prior_per_m, double prior_per_rad,
                 const Constants& constants) {
  const double steps = constants.prior_steps;
  const double mm = sums[0] + steps;
  const double mr = sums[1];
  const double rr = sums[2] + steps;
  const double vm = sums[3] + steps * prior_per_m * prior_per_m;
  const double vr = sums[4] + steps * prior_per_rad * prior_per_rad;
  const double determinant = mm * rr - mr * mr;  // > 0 by the prior
  Noise noise{(rr * vm - mr * vr) / determinant, (mm * vr - mr * vm) / determinant};
  if (noise.per_m < 0.0) noise = {0.0, vr / rr};
  if (noise.per_rad < 0.0) noise = {vm / mm, 0.0};
  return noise;
}

/// A step with that squared residual, of one axis.
void AddNoise(std::array<double, 5>& sums, double way_m, double turn_rad, double squared) {
  const double weight = 1.0 / ((way_m + turn_rad) * (way_m + turn_rad));
  sums[0] += weight * way_m * way_m;
  sums[1] += weight * way_m * turn_rad;
  sums[2] += weight * turn_rad * turn_rad;
  sums[3] += weight * way_m * squared;
  sums[4] += weight * turn_rad * squared;
}

/// Of a residual.
double Weigh(double off, double sigma, const Constants& constants) {
  return std::min(1.0, constants.huber * sigma / std::max(off, 1e-9)) / Square(sigma);
}

/// By what is believed before anything was learned.
WheelModel::Values MakePriorValues(const Constants& constants) {
  WheelModel::Values values;
  values.way_per_m = values.turn_per_rad = constants.prior_noise;
  values.way_per_rad = values.turn_per_m = constants.prior_cross_noise;
  return values;
}

}  // namespace

std::optional<WheelMotion> FindWayByWheels(std::span<const ScanMatch> recent, const std::optional<WheelMotion>& step) {
  std::optional<WheelMotion> way = step;
  for (auto last = recent.rbegin(); way && last != recent.rend() && last->state == MatchState::kLost; ++last) {
    way = last->by_wheels ? std::optional(*last->by_wheels * *way) : std::nullopt;
  }
  return way;
}

WheelModel::WheelModel(const MatchConstants& constants) : WheelModel(State{}, constants) {}

WheelModel::WheelModel(const State& state, const MatchConstants& constants)
    : constants_(constants.wheel_model),
      prediction_(constants.prediction),
      match_m_(constants.tracking.match_m),
      state_(state) {
  Solve();
}

/// The motion of the laser by what is known.
Pose2 WheelModel::ToLaser(const Pose2& wheels) const {
  const double turn_rad = values_.turn_scale * wheels.yaw_rad;
  const auto [sin, cos] = ComputeSinCos(turn_rad);
  return {way_[0] * wheels.x_m - way_[1] * wheels.y_m - (1.0 - cos) * way_[2] - sin * way_[3],
          way_[1] * wheels.x_m + way_[0] * wheels.y_m + sin * way_[2] - (1.0 - cos) * way_[3], WrapAngle(turn_rad)};
}

WheelMotion WheelModel::WithNoise(const Pose2& T_from_to) const {
  const double way_m = Length(T_from_to);
  const double turn_rad = std::abs(T_from_to.yaw_rad);
  const Values& v = values_;
  return {T_from_to,
          std::sqrt(Square(constants_.least_sigma) + Square(v.way_per_m) * way_m + Square(v.way_per_rad) * turn_rad),
          std::sqrt(Square(constants_.least_sigma) + Square(v.turn_per_m) * way_m + Square(v.turn_per_rad) * turn_rad)};
}

bool WheelModel::Values::AreTooNoisy(const Constants& constants) const {
  return way_per_m > constants.most_noise_m || turn_per_rad > constants.most_noise_rad;
}

bool WheelModel::Values::ContradictLaser(const Constants& constants) const {
  return steps >= constants.few_steps && AreTooNoisy(constants);
}

std::optional<WheelMotion> WheelModel::Predict(std::span<const ScanMatch> recent, std::int64_t utime,
                                               const std::optional<Pose2>& T_odom_robot) const {
  const auto wheels = FindWheels(recent, utime, T_odom_robot, constants_);
  if (!wheels || !AreBelieved()) return std::nullopt;
  if (!state_.have_moved && !Moves(recent, T_odom_robot)) return std::nullopt;
  return WithNoise(ToLaser(*wheels));
}

/// Whether their last step was none that they slipped on, and they are not so noisy that they are frozen, or slip as
/// they like. Before enough is learned, whether they told the last motions no worse than the velocity model.
bool WheelModel::AreBelieved() const {
  if (!state_.have_moved || state_.steps < constants_.few_steps) {
    return state_.wheels_error_m <= state_.velocity_error_m + match_m_;
  }
  return state_.steps_since_slip > 0 && !values_.AreTooNoisy(constants_);
}

bool WheelModel::IsReliable() const {
  return state_.steps >= constants_.many_steps && state_.steps_since_slip >= constants_.few_steps;
}

void WheelModel::Add(std::span<const ScanMatch> recent, const ScanMatch& match) {
  const bool is_matched = !recent.empty() && IsMotionMatched(recent.back(), match);
  const auto wheels = is_matched ? FindWheels(recent, match.utime, match.T_odom_robot, constants_) : std::nullopt;
  const auto Begin = [&] {
    state_.has_start = match.state != MatchState::kLost && match.T_odom_robot;
    state_.T_map_start = state_.has_start ? match.T_map_laser : Pose2{};
    state_.T_odom_start = state_.has_start ? *match.T_odom_robot : Pose2{};
  };
  if (!state_.have_moved && Moves(recent, match.T_odom_robot)) {  // what went before says nothing
    state_.have_moved = true;
    state_.steps = 0;
    Solve();
  }
  if (!wheels) return Begin();
  if (match.state == MatchState::kOk && state_.have_moved) LearnErrors(recent, match, *wheels);
  if (!state_.has_start) return Begin();
  const Pose2 matched = Inverse(state_.T_map_start) * match.T_map_laser;
  const Pose2 told = Inverse(state_.T_odom_start) * *match.T_odom_robot;
  const auto IsStep = [this](const Pose2& motion) {
    return std::max(Length(motion), std::abs(motion.yaw_rad)) >= constants_.step_m;
  };
  if (match.state == MatchState::kDegenerate) return Begin();  // the way is not measured
  if (!IsStep(matched) && !IsStep(told)) return;
  if (state_.have_moved) {
    LearnStep(told, matched);
  } else {
    ++state_.steps;
    Solve();
  }
  Begin();
}

void WheelModel::Move(const Pose2& T_new_old) {
  if (state_.has_start) state_.T_map_start = T_new_old * state_.T_map_start;
}

/// Which of the two tells motions better.
void WheelModel::LearnErrors(std::span<const ScanMatch> recent, const ScanMatch& match, const Pose2& wheels) {
  const ScanMatch& last = recent.back();
  const Pose2 matched = Inverse(last.T_map_laser) * match.T_map_laser;
  const Pose2 by_velocity = Inverse(last.T_map_laser) * PredictPose(recent, prediction_);
  const auto Follow = [this](double& mean, double error) { mean += constants_.follow * (error - mean); };
  Follow(state_.wheels_error_m, ComputeDistance(ToLaser(wheels), matched));
  Follow(state_.velocity_error_m, ComputeDistance(by_velocity, matched));
}

void WheelModel::LearnStep(const Pose2& wheels, const Pose2& matched) {
  const Pose2 told = ToLaser(wheels);
  const WheelMotion noisy = WithNoise(told);
  const double sigma_m = std::sqrt(Square(noisy.sigma_m) + Square(match_m_));
  const double sigma_rad = noisy.sigma_rad;
  const double off_m = Distance(told, matched) / std::sqrt(2.0);  // of one axis
  const double off_rad = std::abs(WrapAngle(told.yaw_rad - matched.yaw_rad));

  ++state_.steps;
  const bool slips = off_m > constants_.slip * sigma_m || off_rad > constants_.slip * sigma_rad;
  state_.slips += slips ? 1 : 0;
  state_.steps_since_slip = slips ? 0 : state_.steps_since_slip + 1;

  Forget(state_.turn, constants_.forget);
  const double turn_weight = Weigh(off_rad, sigma_rad, constants_);
  state_.turn[0] += turn_weight * wheels.yaw_rad * wheels.yaw_rad;
  state_.turn[1] += turn_weight * wheels.yaw_rad * (wheels.yaw_rad + WrapAngle(matched.yaw_rad - wheels.yaw_rad));

  Forget(state_.way_information, constants_.forget);
  Forget(state_.way_vector, constants_.forget);
  const double way_weight = Weigh(off_m, sigma_m, constants_);
  const auto [sin, cos] = ComputeSinCos(matched.yaw_rad);
  const std::array<std::array<double, 4>, 2> rows{
      {{wheels.x_m, -wheels.y_m, cos - 1.0, -sin}, {wheels.y_m, wheels.x_m, sin, cos - 1.0}}};
  const std::array<double, 2> ways_m{matched.x_m, matched.y_m};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::size_t at = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = i; k < 4; ++k) state_.way_information[at++] += way_weight * rows[axis][i] * rows[axis][k];
      state_.way_vector[i] += way_weight * rows[axis][i] * ways_m[axis];
    }
  }

  Forget(state_.way_noise, constants_.forget);
  Forget(state_.turn_noise, constants_.forget);
  const double way_m = std::max(Length(told), Length(matched));
  const double turn_rad = std::max(std::abs(told.yaw_rad), std::abs(matched.yaw_rad));
  AddNoise(state_.way_noise, way_m, turn_rad, Square(std::min(off_m, constants_.most_residual * sigma_m)));
  AddNoise(state_.turn_noise, way_m, turn_rad, Square(std::min(off_rad, constants_.most_residual * sigma_rad)));
  Solve();
}

/// All values by the sums.
void WheelModel::Solve() {
  const Values prior = MakePriorValues(constants_);
  values_ = prior;
  values_.steps = state_.steps;
  values_.slips = state_.slips;
  values_.have_moved = state_.have_moved;

  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < 4; ++i) {
    for (Eigen::Index k = i; k < 4; ++k) information(i, k) = information(k, i) = state_.way_information[at++];
  }
  Eigen::Vector4d vector = Eigen::Map<const Eigen::Vector4d>(state_.way_vector.data());
  const double of_scale = 1.0 / Square(constants_.prior_scale);
  const double of_lever = 1.0 / Square(constants_.prior_lever_m);
  information.diagonal() += Eigen::Vector4d(of_scale, of_scale, of_lever, of_lever);
  vector[0] += of_scale;
  const Eigen::Vector4d way = information.inverse() * vector;
  for (std::size_t i = 0; i < 4; ++i) way_[i] = way[static_cast<Eigen::Index>(i)];
  values_.scale = std::sqrt(Square(way_[0]) + Square(way_[1]));
  values_.laser_yaw_rad = -std::atan2(way_[1], way_[0]);
  const auto [sin, cos] = ComputeSinCos(values_.laser_yaw_rad);
  values_.laser_x_m = cos * way_[2] - sin * way_[3];
  values_.laser_y_m = sin * way_[2] + cos * way_[3];

  const double of_turn = 1.0 / Square(constants_.prior_turn);
  values_.turn_scale = (state_.turn[1] + of_turn) / (state_.turn[0] + of_turn);

  const Noise of_way = SolveNoise(state_.way_noise, prior.way_per_m, prior.way_per_rad, constants_);
  const Noise of_heading = SolveNoise(state_.turn_noise, prior.turn_per_m, prior.turn_per_rad, constants_);
  values_.way_per_m = std::sqrt(of_way.per_m);
  values_.way_per_rad = std::sqrt(of_way.per_rad);
  values_.turn_per_m = std::sqrt(of_heading.per_m);
  values_.turn_per_rad = std::sqrt(of_heading.per_rad);
}

}  // namespace crsm
