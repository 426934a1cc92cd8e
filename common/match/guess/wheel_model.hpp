#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "common/match/match_constants.hpp"
#include "common/scan/scan_match.hpp"
#include "common/scan/wheel_motion.hpp"

namespace crsm {

/// From the last scan that was matched, over those that were lost since: step is that from the newest one on. Nothing
/// where the wheels are not believed in between.
std::optional<WheelMotion> FindWayByWheels(std::span<const ScanMatch> recent, const std::optional<WheelMotion>& step);

/// What the wheels of a robot are worth, learned on the way from matched motions: their scale, where the laser sits on
/// the robot, and their noise.
///
/// A motion of the robot by its wheels, d [m] and t [rad], is one of the laser by
///   turn: turn_scale * t,   way: scale * R(-mounting_rad) * d - (1 - R(turn)) * lever.
/// Scale and mounting are one linear unknown, the lever is another: least squares over steps of half a metre or half a
/// radian, with weights that follow the residual (Huber 1964), and older steps count less. The noise is two variances
/// each of way and turn, per metre and per radian, from the squares of the residuals. Motions that are no match of the
/// model are learned from as well, but each no more than four standard deviations: wheels that lie lose their say.
class WheelModel {
 public:
  /// What is known by now. A model begins with the cautious noise of its constants.
  struct Values {
    double scale = 1.0;       ///< true way per way of the wheels
    double turn_scale = 1.0;  ///< true turn per turn of the wheels
    /// The pose of the laser on the robot.
    double laser_x_m = 0.0;
    double laser_y_m = 0.0;
    double laser_yaw_rad = 0.0;
    double way_per_m = 0.0;    ///< standard deviation of a way of a metre [m]; it grows with the root of the way
    double way_per_rad = 0.0;  ///< ... of a turn of a radian
    double turn_per_m = 0.0;   ///< standard deviation of the heading after a metre [rad]
    double turn_per_rad = 0.0;
    std::int64_t steps = 0;  ///< learned from
    std::int64_t slips = 0;  ///< of them: further from the model than five standard deviations
    bool have_moved = true;  ///< else steps are those of the laser alone, and nothing was learned from them

    /// Whether they and the laser tell ways so different that they are no help.
    bool AreTooNoisy(const MatchConstants::WheelModel& constants = {}) const;
    /// The same where enough was learned to say so: one of the two is wrong.
    bool ContradictLaser(const MatchConstants::WheelModel& constants = {}) const;
  };

  /// recent: the scans before, as of TrackingState. Learns where both were matched and have odometry.
  void Add(std::span<const ScanMatch> recent, const ScanMatch& match);

  /// Where the map has moved, what was at T_old is at T_new_old * T_old.
  void Move(const Pose2& T_new_old);

  /// The motion since the last scan. Nothing without odometry at either, where the wheels jump further than a robot
  /// drives in that time, after a slip, and where they are too noisy; until a few steps were learned from, where they
  /// have told the last motions worse than PredictPose did. Nor before the wheels move for the first time: a pose that
  /// never changes may be that of a robot without wheels.
  std::optional<WheelMotion> Predict(std::span<const ScanMatch> recent, std::int64_t utime,
                                     const std::optional<Pose2>& T_odom_robot) const;

  /// Whether enough steps agree with the model: what contradicts the wheels is then likelier to be wrong than they are.
  bool IsReliable() const;

  const Values& values() const { return values_; }
  /// The same; nothing while there was nothing to learn from.
  std::optional<Values> Learned() const { return values_.steps > 0 ? std::optional(values_) : std::nullopt; }

  /// Its parts, as they travel: all that it has learned.
  struct State {
    /// Of scale cos, scale sin, lever x, lever y: the upper triangle, by rows.
    std::array<double, 10> way_information{};
    std::array<double, 4> way_vector{};
    std::array<double, 2> turn{};  ///< sums of squares, and of products
    /// Sums: metres^2, metres radians, radians^2; variance metres, variance radians.
    std::array<double, 5> way_noise{};
    std::array<double, 5> turn_noise{};
    double wheels_error_m = 0.0;    ///< how far they were off in the last motions, mean
    double velocity_error_m = 0.0;  ///< ... the velocity model
    std::int64_t steps = 0;
    std::int64_t slips = 0;
    std::int64_t steps_since_slip = 0;
    bool have_moved = false;  ///< the wheels, ever
    bool has_start = false;   ///< of the step that goes on
    Pose2 T_map_start;
    Pose2 T_odom_start;
    friend bool operator==(const State&, const State&) = default;
  };
  const State& state() const { return state_; }
  /// constants: by which it learns. They do not travel.
  WheelModel() : WheelModel(MatchConstants{}) {}
  explicit WheelModel(const MatchConstants& constants);
  explicit WheelModel(const State& state, const MatchConstants& constants = {});

  friend bool operator==(const WheelModel& a, const WheelModel& b) { return a.state_ == b.state_; }

 private:
  bool AreBelieved() const;
  Pose2 ToLaser(const Pose2& wheels) const;
  WheelMotion WithNoise(const Pose2& T_from_to) const;
  void LearnErrors(std::span<const ScanMatch> recent, const ScanMatch& match, const Pose2& wheels);
  void LearnStep(const Pose2& wheels, const Pose2& matched);
  void Solve();

  MatchConstants::WheelModel constants_;
  MatchConstants::Prediction prediction_;  ///< of the velocity model
  double match_m_;                         ///< what a match may be off
  State state_;
  Values values_;
  std::array<double, 4> way_{1.0, 0.0, 0.0, 0.0};  ///< what way_information is of
};

}  // namespace crsm
