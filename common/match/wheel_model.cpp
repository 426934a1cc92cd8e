#include "common/match/wheel_model.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "common/match/motion_prediction.hpp"
#include "common/math/median.hpp"

namespace crsm {
namespace {

// What is believed before anything was learned, and how strongly: as if so many steps had said so.
constexpr double kPriorScale = 0.2;    // standard deviations: of the scale, and of the mounting [rad] ...
constexpr double kPriorLever_m = 0.3;  // ... of the laser's place ...
constexpr double kPriorTurn = 0.1;     // ... of the turn's scale ...
constexpr double kPriorDelay_s = 0.05;
constexpr double kPriorSteps = 5.0;  // of the noise

/// A step ends that far from where it began.
constexpr double kStep_m = 0.5;
constexpr double kStep_rad = 0.5;

constexpr double kForget = 0.995;      // with each step: a hundred metres count
constexpr double kHuber = 2.0;         // standard deviations, from which on a residual counts less
constexpr double kMostResidual = 4.0;  // ... as which a larger one counts
constexpr double kSlip = 5.0;          // ... from which on it is a slip
constexpr double kMatch_m = 0.01;      // of the matches at both ends of a step
constexpr double kMatch_rad = 0.003;
constexpr double kMatchedHeading_rad = 0.003;  // of one scan: for the delay
constexpr double kLongestPeriod_s = 0.5;       // between scans: over more, a delay of the stamps is nothing
constexpr double kFollow = 0.05;               // share of the newest motion in the mean errors
constexpr double kTolerance_m = 0.02;          // what a good match may be off

double Square(double value) { return value * value; }

/// Sums of squares forget, so that they never overflow, and what was long ago counts less.
template <std::size_t N>
void Forget(std::array<double, N>& sums) {
  for (double& sum : sums) sum *= kForget;
}

double Seconds(std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); }

/// How far two motions are apart [m]; turns count at 1 m from the laser.
double ComputeDistance(const Pose2& a, const Pose2& b) {
  return std::abs(a.x_m - b.x_m) + std::abs(a.y_m - b.y_m) + std::abs(WrapAngle(a.yaw_rad - b.yaw_rad));
}

/// How fast the wheels go: the median of their steps between the scans that are remembered, in the mean time between
/// those. Some loggers stamp several scans at once.
struct Pace {
  double m_per_s = 0.0;
  double rad_per_s = 0.0;
};

Pace FindPace(std::span<const ScanMatch> recent) {
  std::vector<double> ways_m;
  std::vector<double> turns_rad;
  for (std::size_t i = 1; i < recent.size(); ++i) {
    const auto& [from, to] = std::tie(recent[i - 1], recent[i]);
    if (!from.T_odom_robot || !to.T_odom_robot) continue;
    const Pose2 motion = Inverse(*from.T_odom_robot) * *to.T_odom_robot;
    ways_m.push_back(Length(motion));
    turns_rad.push_back(std::abs(motion.yaw_rad));
  }
  if (recent.size() < 2) return {};
  const double period_s = Seconds(recent.front().utime, recent.back().utime) / static_cast<double>(recent.size() - 1);
  if (period_s <= 0.0) return {};
  return {FindMedian(ways_m) / period_s, FindMedian(turns_rad) / period_s};
}

/// Whether a robot can move so far in that time: odometry that was reset, or not sent for a while, jumps.
bool IsMotion(const Pose2& motion, double elapsed_s, const Pace& pace) {
  constexpr double kTimesPace = 2.0;
  constexpr double kFaster_m_s = 1.0;
  constexpr double kFaster_rad_s = 1.0;
  const double farthest_m = std::max(1.0, (kTimesPace * pace.m_per_s + kFaster_m_s) * elapsed_s);
  const double widest_rad = std::max(1.5, (kTimesPace * pace.rad_per_s + kFaster_rad_s) * elapsed_s);
  return Length(motion) <= farthest_m && std::abs(motion.yaw_rad) <= widest_rad;  // stamps are not exact
}

/// The motion of the wheels since the newest of these scans; nothing where one has none, or they jump.
std::optional<Pose2> FindWheels(std::span<const ScanMatch> recent, std::int64_t utime,
                                const std::optional<Pose2>& T_odom_robot) {
  if (recent.empty() || !recent.back().T_odom_robot || !T_odom_robot) return std::nullopt;
  const Pose2 motion = Inverse(*recent.back().T_odom_robot) * *T_odom_robot;
  const bool is_motion = IsMotion(motion, Seconds(recent.back().utime, utime), FindPace(recent));
  return is_motion ? std::optional(motion) : std::nullopt;
}

/// The same in a second; 0 where that is not known, or the scans are far apart.
Pose2 FindRate(const std::optional<Pose2>& wheels, double elapsed_s) {
  if (!wheels || elapsed_s <= 0.0 || elapsed_s > kLongestPeriod_s) return {};
  return {wheels->x_m / elapsed_s, wheels->y_m / elapsed_s, wheels->yaw_rad / elapsed_s};
}

/// That of the wheels before the newest of these scans.
Pose2 FindRateBefore(std::span<const ScanMatch> recent) {
  if (recent.size() < 2) return {};
  const auto before = recent.first(recent.size() - 1);
  const ScanMatch& to = recent.back();
  return FindRate(FindWheels(before, to.utime, to.T_odom_robot), Seconds(before.back().utime, to.utime));
}

/// Two variances, per metre and per radian, of which a sum makes that of a step: least squares, none negative.
struct Noise {
  double per_m;
  double per_rad;
};

Noise SolveNoise(const std::array<double, 5>& sums, double prior_per_m, double prior_per_rad) {
  constexpr double kLeast = 0.005;  // no wheels are better
  const double mm = sums[0] + kPriorSteps;
  const double mr = sums[1];
  const double rr = sums[2] + kPriorSteps;
  const double vm = sums[3] + kPriorSteps * prior_per_m * prior_per_m;
  const double vr = sums[4] + kPriorSteps * prior_per_rad * prior_per_rad;
  const double determinant = mm * rr - mr * mr;  // > 0 by the prior
  Noise noise{(rr * vm - mr * vr) / determinant, (mm * vr - mr * vm) / determinant};
  if (noise.per_m < 0.0) noise = {0.0, vr / rr};
  if (noise.per_rad < 0.0) noise = {vm / mm, 0.0};
  return {std::max(noise.per_m, Square(kLeast)), std::max(noise.per_rad, Square(kLeast))};
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

double ComputeDelay(const std::array<double, 2>& sums) { return sums[1] / (sums[0] + 1.0 / Square(kPriorDelay_s)); }

/// Of a residual.
double Weigh(double off, double sigma) { return std::min(1.0, kHuber * sigma / std::max(off, 1e-9)) / Square(sigma); }

}  // namespace

std::optional<WheelMotion> FindWayByWheels(std::span<const ScanMatch> recent, const std::optional<WheelMotion>& step) {
  std::optional<WheelMotion> way = step;
  for (auto last = recent.rbegin(); way && last != recent.rend() && last->state == MatchState::kLost; ++last) {
    way = last->by_wheels ? std::optional(*last->by_wheels * *way) : std::nullopt;
  }
  return way;
}

WheelModel::WheelModel(const State& state) : state_(state) { Solve(); }

/// The motion of the laser by what is known.
Pose2 WheelModel::ToLaser(const Pose2& wheels, const Pose2& rate_before, const Pose2& rate_after) const {
  const double delay_s = values_.delay_s;
  const double x_m = wheels.x_m + delay_s * (rate_after.x_m - rate_before.x_m);
  const double y_m = wheels.y_m + delay_s * (rate_after.y_m - rate_before.y_m);
  const double turn_rad = values_.turn_scale * (wheels.yaw_rad + delay_s * (rate_after.yaw_rad - rate_before.yaw_rad));
  const auto [sin, cos] = ComputeSinCos(turn_rad);
  return {way_[0] * x_m - way_[1] * y_m - (1.0 - cos) * way_[2] - sin * way_[3],
          way_[1] * x_m + way_[0] * y_m + sin * way_[2] - (1.0 - cos) * way_[3], WrapAngle(turn_rad)};
}

WheelMotion WheelModel::WithNoise(const Pose2& T_from_to) const {
  constexpr double kLeast_m = 0.003;
  constexpr double kLeast_rad = 0.001;
  const double way_m = Length(T_from_to);
  const double turn_rad = std::abs(T_from_to.yaw_rad);
  const Values& v = values_;
  const double jitter_m = 0.5 * state_.wheels_error_m;  // stamps are not exact: it is no noise of the way
  return {T_from_to,
          std::sqrt(Square(kLeast_m + jitter_m) + Square(v.way_per_m) * way_m + Square(v.way_per_rad) * turn_rad),
          std::sqrt(Square(kLeast_rad) + Square(v.turn_per_m) * way_m + Square(v.turn_per_rad) * turn_rad)};
}

bool WheelModel::Values::AreTooNoisy() const {
  constexpr double kMost_m = 0.12;   // after a metre ...
  constexpr double kMost_rad = 0.2;  // ... and after a radian
  return way_per_m > kMost_m || turn_per_rad > kMost_rad;
}

bool WheelModel::Values::ContradictLaser() const { return steps >= kFewSteps && AreTooNoisy(); }

std::optional<WheelMotion> WheelModel::Predict(std::span<const ScanMatch> recent, std::int64_t utime,
                                               const std::optional<Pose2>& T_odom_robot) const {
  const auto wheels = FindWheels(recent, utime, T_odom_robot);
  if (!wheels || !AreBelieved()) return std::nullopt;
  const double elapsed_s = Seconds(recent.back().utime, utime);
  return WithNoise(ToLaser(*wheels, FindRateBefore(recent), FindRate(wheels, elapsed_s)));
}

/// Whether their last step was none that they slipped on, and they are not so noisy that they are frozen, or slip as
/// they like. Before enough is learned, whether they told the last motions no worse than the velocity model.
bool WheelModel::AreBelieved() const {
  if (state_.steps < kFewSteps) return state_.wheels_error_m <= state_.velocity_error_m + kTolerance_m;
  return state_.steps_since_slip > 0 && !values_.AreTooNoisy();
}

bool WheelModel::IsReliable() const {
  constexpr std::int64_t kSlipsByChance = 2;
  constexpr std::int64_t kStepsPerSlip = 32;  // of right wheels at least: 45 in fr079, 69 in killian
  const bool slip_often = state_.slips > kSlipsByChance + state_.steps / kStepsPerSlip;
  return state_.steps >= kManySteps && state_.steps_since_slip >= (slip_often ? 2 * kManySteps : kFewSteps);
}

bool WheelModel::TellsBest() const {
  constexpr double kClearly = 0.7;
  return state_.steps >= kFewSteps && state_.wheels_error_m < kClearly * state_.velocity_error_m;
}

void WheelModel::Add(std::span<const ScanMatch> recent, const ScanMatch& match) {
  const bool is_matched = !recent.empty() && IsMotionMatched(recent.back(), match);
  const double elapsed_s = recent.empty() ? 0.0 : Seconds(recent.back().utime, match.utime);
  const auto wheels = is_matched ? FindWheels(recent, match.utime, match.T_odom_robot) : std::nullopt;
  const auto Begin = [&](const Pose2& rate) {
    state_.has_start = match.state != MatchState::kLost && match.T_odom_robot;
    state_.T_map_start = state_.has_start ? match.T_map_laser : Pose2{};
    state_.T_odom_start = state_.has_start ? *match.T_odom_robot : Pose2{};
    state_.rate_at_start = state_.has_start ? rate : Pose2{};
  };
  if (!wheels) return Begin({});
  const Pose2 rate = FindRate(wheels, elapsed_s);
  if (match.state == MatchState::kOk) {
    LearnErrors(recent, match, *wheels, rate);
    LearnDelay(recent, match);
  }
  if (!state_.has_start) return Begin(rate);
  const Pose2 matched = Inverse(state_.T_map_start) * match.T_map_laser;
  const Pose2 told = Inverse(state_.T_odom_start) * *match.T_odom_robot;
  const auto IsStep = [](const Pose2& motion) {
    return Length(motion) >= kStep_m || std::abs(motion.yaw_rad) >= kStep_rad;
  };
  if (match.state == MatchState::kDegenerate) return Begin(rate);  // the way is not measured
  if (!IsStep(matched) && !IsStep(told)) return;
  LearnStep(told, matched, rate);
  Begin(rate);
}

void WheelModel::Move(const Pose2& T_new_old) {
  if (state_.has_start) state_.T_map_start = T_new_old * state_.T_map_start;
}

/// Which of the two tells motions better.
void WheelModel::LearnErrors(std::span<const ScanMatch> recent, const ScanMatch& match, const Pose2& wheels,
                             const Pose2& rate) {
  const ScanMatch& last = recent.back();
  const Pose2 by_wheels = ToLaser(wheels, FindRateBefore(recent), rate);
  const Pose2 matched = Inverse(last.T_map_laser) * match.T_map_laser;
  const Pose2 by_velocity = Inverse(last.T_map_laser) * PredictPose(recent);
  const auto Follow = [](double& mean, double error) { mean += kFollow * (error - mean); };
  Follow(state_.wheels_error_m, ComputeDistance(by_wheels, matched));
  Follow(state_.velocity_error_m, ComputeDistance(by_velocity, matched));
}

/// A late stamp shows where the robot begins or ends to turn. By how much, the laser says: by the wheels their own
/// noise would look like a delay.
void WheelModel::LearnDelay(std::span<const ScanMatch> recent, const ScanMatch& match) {
  if (recent.size() < 2 || !IsMotionMatched(recent[recent.size() - 2], recent.back())) return;
  const ScanMatch& before = recent[recent.size() - 2];
  const ScanMatch& last = recent.back();
  const double before_s = Seconds(before.utime, last.utime);
  const double elapsed_s = Seconds(last.utime, match.utime);
  const auto IsShort = [](double period_s) { return period_s > 0.0 && period_s <= kLongestPeriod_s; };
  if (!IsShort(before_s) || !IsShort(elapsed_s)) return;
  const double turn_rad = WrapAngle(match.T_map_laser.yaw_rad - last.T_map_laser.yaw_rad);
  const double turn_before_rad = WrapAngle(last.T_map_laser.yaw_rad - before.T_map_laser.yaw_rad);
  const double told_rad = values_.turn_scale * WrapAngle(match.T_odom_robot->yaw_rad - last.T_odom_robot->yaw_rad);
  const double change_rad_s = turn_rad / elapsed_s - turn_before_rad / before_s;
  const double late_rad = WrapAngle(turn_rad - told_rad);
  const double sigma_rad = kMatchedHeading_rad + values_.turn_per_rad * std::sqrt(std::abs(told_rad));
  const double off_rad = std::abs(late_rad - values_.delay_s * change_rad_s);
  const double weight = Weigh(off_rad, sigma_rad);
  state_.delay[0] += weight * change_rad_s * change_rad_s;
  state_.delay[1] += weight * change_rad_s * late_rad;
  values_.delay_s = ComputeDelay(state_.delay);  // at once: a model that is made of this state knows it, too
}

void WheelModel::LearnStep(const Pose2& wheels, const Pose2& matched, const Pose2& rate_after) {
  const Pose2 told = ToLaser(wheels, state_.rate_at_start, rate_after);
  const WheelMotion noisy = WithNoise(told);
  const double sigma_m = std::sqrt(Square(noisy.sigma_m) + Square(kMatch_m));
  const double sigma_rad = std::sqrt(Square(noisy.sigma_rad) + Square(kMatch_rad));
  const double off_m = Distance(told, matched) / std::sqrt(2.0);  // of one axis
  const double off_rad = std::abs(WrapAngle(told.yaw_rad - matched.yaw_rad));

  ++state_.steps;
  const bool slips = off_m > kSlip * sigma_m || off_rad > kSlip * sigma_rad;
  state_.slips += slips ? 1 : 0;
  state_.steps_since_slip = slips ? 0 : state_.steps_since_slip + 1;

  Forget(state_.delay);
  Forget(state_.turn);
  const double turn_weight = Weigh(off_rad, sigma_rad);
  const double turned_rad = wheels.yaw_rad + values_.delay_s * (rate_after.yaw_rad - state_.rate_at_start.yaw_rad);
  state_.turn[0] += turn_weight * turned_rad * turned_rad;
  state_.turn[1] += turn_weight * turned_rad * (turned_rad + WrapAngle(matched.yaw_rad - turned_rad));

  Forget(state_.way_information);
  Forget(state_.way_vector);
  const double way_weight = Weigh(off_m, sigma_m);
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

  Forget(state_.way_noise);
  Forget(state_.turn_noise);
  const double way_m = std::max(Length(told), Length(matched));
  const double turn_rad = std::max(std::abs(told.yaw_rad), std::abs(matched.yaw_rad));
  AddNoise(state_.way_noise, way_m, turn_rad, Square(std::min(off_m, kMostResidual * sigma_m)));
  AddNoise(state_.turn_noise, way_m, turn_rad, Square(std::min(off_rad, kMostResidual * sigma_rad)));
  Solve();
}

/// All values by the sums.
void WheelModel::Solve() {
  values_ = Values{};
  const Values prior;
  values_.steps = state_.steps;
  values_.slips = state_.slips;

  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < 4; ++i) {
    for (Eigen::Index k = i; k < 4; ++k) information(i, k) = information(k, i) = state_.way_information[at++];
  }
  Eigen::Vector4d vector = Eigen::Map<const Eigen::Vector4d>(state_.way_vector.data());
  const double of_scale = 1.0 / Square(kPriorScale);
  const double of_lever = 1.0 / Square(kPriorLever_m);
  information.diagonal() += Eigen::Vector4d(of_scale, of_scale, of_lever, of_lever);
  vector[0] += of_scale;
  const Eigen::Vector4d way = information.inverse() * vector;
  for (std::size_t i = 0; i < 4; ++i) way_[i] = way[static_cast<Eigen::Index>(i)];
  values_.scale = std::sqrt(Square(way_[0]) + Square(way_[1]));
  values_.laser_yaw_rad = -std::atan2(way_[1], way_[0]);
  const auto [sin, cos] = ComputeSinCos(values_.laser_yaw_rad);
  values_.laser_x_m = cos * way_[2] - sin * way_[3];
  values_.laser_y_m = sin * way_[2] + cos * way_[3];

  const double of_turn = 1.0 / Square(kPriorTurn);
  values_.turn_scale = (state_.turn[1] + of_turn) / (state_.turn[0] + of_turn);
  values_.delay_s = ComputeDelay(state_.delay);

  const Noise of_way = SolveNoise(state_.way_noise, prior.way_per_m, prior.way_per_rad);
  const Noise of_heading = SolveNoise(state_.turn_noise, prior.turn_per_m, prior.turn_per_rad);
  values_.way_per_m = std::sqrt(of_way.per_m);
  values_.way_per_rad = std::sqrt(of_way.per_rad);
  values_.turn_per_m = std::sqrt(of_heading.per_m);
  values_.turn_per_rad = std::sqrt(of_heading.per_rad);
}

}  // namespace crsm
