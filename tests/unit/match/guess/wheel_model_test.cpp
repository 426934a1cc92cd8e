#include "common/match/guess/wheel_model.hpp"

#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/math/random.hpp"
#include "common/slam.hpp"
#include "common/worlds/simulator.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kPeriod_us = 200'000;

/// What a robot's wheels tell.
struct Wheels {
  double scale = 1.0;  ///< told way per true way
  double turn_scale = 1.0;
  Pose2 T_robot_laser = {};
  double noise = 0.0;  ///< of the way, per root metre, and of the turn, per root radian
};

/// A winding drive of 0.1 m a scan: the twist at a time.
Pose2 TwistAt(double time_s) { return {0.5, 0.0, 0.6 * std::sin(0.9 * time_s)}; }

/// Matches of `num` scans of such a robot.
TrackingState Drive(int num, const Wheels& wheels, MatchState state = MatchState::kOk) {
  constexpr int kSubsteps = 20;
  constexpr double kStep_s = 1e-6 * kPeriod_us / kSubsteps;
  Random random(1);
  TrackingState tracking;
  Pose2 robot;
  Pose2 told;
  double time_s = 10.0;
  for (int k = 0; k < num; ++k) {
    const Pose2 first = Inverse(wheels.T_robot_laser);
    ScanMatch match = MatchedAt(k * kPeriod_us, first * robot * wheels.T_robot_laser);
    match.state = k == 0 ? MatchState::kFirst : state;
    match.T_odom_robot = Pose2{100.0, -50.0, 2.0} * told;
    tracking.Add(match);
    for (int i = 0; i < kSubsteps; ++i, time_s += kStep_s) {
      const Pose2 twist = TwistAt(time_s);
      const Pose2 motion{kStep_s * twist.x_m, 0.0, kStep_s * twist.yaw_rad};
      robot = robot * motion;
      const double root = wheels.noise * std::sqrt(std::abs(motion.x_m));
      const double root_rad = wheels.noise * std::sqrt(std::abs(motion.yaw_rad));
      told = told * Pose2{wheels.scale * motion.x_m + root * random.Gaussian(), 0.0,
                          wheels.turn_scale * motion.yaw_rad + root_rad * random.Gaussian()};
    }
  }
  return tracking;
}

std::int64_t NextTime(const TrackingState& tracking) { return tracking.recent().back().utime + kPeriod_us; }

/// After a last motion of the wheels.
std::optional<WheelMotion> PredictAfter(const TrackingState& tracking, const Pose2& motion) {
  return tracking.wheels().Predict(tracking.recent(), NextTime(tracking),
                                   *tracking.recent().back().T_odom_robot * motion);
}

}  // namespace

TEST_CASE("before anything is learned the wheels are taken as they are, with caution") {
  const TrackingState tracking = Drive(2, {});
  const auto motion = PredictAfter(tracking, {0.1, 0.0, 0.1});
  REQUIRE(motion);
  CheckPose(motion->T_from_to, {0.1, 0.0, 0.1}, 1e-9);
  CHECK(motion->sigma_m > 0.03);
  CHECK(motion->sigma_rad > 0.02);
  CHECK_FALSE(tracking.wheels().IsReliable());
}

TEST_CASE("scale and mounting are learned to a percent and two centimetres, where the walls tell how far") {
  const TrackingState tracking = Drive(1500, {1.0 / 1.08, 1.0 / 0.95, {0.2, -0.1, 0.3}, 0.01});
  const WheelModel::Values& values = tracking.wheels().values();
  CHECK(values.steps > 200);
  CHECK(values.slips == 0);
  CHECK(values.scale == Approx(1.08).margin(0.01));
  CHECK(values.turn_scale == Approx(0.95).margin(0.01));
  CHECK(values.laser_x_m == Approx(0.2).margin(0.02));
  CHECK(values.laser_y_m == Approx(-0.1).margin(0.02));
  CHECK(values.laser_yaw_rad == Approx(0.3).margin(0.01));
  CHECK(tracking.wheels().IsReliable());
  CHECK(Drive(300, {.scale = 0.5}, MatchState::kDegenerate).wheels().values().scale == Approx(1.0).epsilon(1e-12));
}

TEST_CASE("the noise of the wheels is learned to a factor of one and a half") {
  for (const double noise : {0.02, 0.05, 0.15}) {
    const WheelModel::Values values = Drive(3000, {1.0, 1.0, {}, noise}).wheels().values();
    CHECK(values.turn_per_rad < 1.5 * noise + 0.02);
    CHECK(values.turn_per_rad > noise / 1.5 - 0.01);
    CHECK(values.way_per_m < 1.5 * noise + 0.02);
    CHECK(values.way_per_m > noise / 2.0 - 0.01);  // of two axes it is on one
  }
}

TEST_CASE("what is learned in the flat is the truth about its wheels") {
  constexpr double kTrueWayScale = 1.0 / 1.05;
  constexpr double kTrueTurnScale = 1.0 / 0.97;
  std::string text = LoadWorldText("demo");
  text.replace(text.find("speed 0.3 0.5"), 13, "speed 0.3 0.6");
  const World world = ParseWorld(text + "\nwheels 1.05 0.97 0.02 0.03 x_m 0.12 y_m -0.05 yaw_deg 10\n", "flat");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    Parameters parameters;
    parameters.match.seed = seed;
    Slam slam(parameters);
    Simulator simulator(world, seed);
    while (const auto scan = simulator.Next()) slam.Process(*scan, simulator.Odometry());
    const WheelModel::Values& values = slam.tracking().wheels().values();
    CHECK(values.steps > 150);
    CHECK(values.slips <= 2);
    // Over 8 seeds scales scatter by 0.2 % and 0.4 %. The turns' is also 0.8 % too small in the mean: the noise of the
    // wheels shrinks it. Of that the margin holds but a part: other seeds than these may be beyond it.
    CHECK(values.scale == Approx(kTrueWayScale).margin(0.009));
    CHECK(values.turn_scale == Approx(kTrueTurnScale).margin(0.012));
    CHECK(values.laser_x_m == Approx(0.12).margin(0.005));
    CHECK(values.laser_y_m == Approx(-0.05).margin(0.005));
    CHECK(values.laser_yaw_rad == Approx(10.0 * kPi / 180.0).margin(0.005));
    // Of the noise the caution of the first steps stays: never less than it is, up to twice as much.
    CHECK(values.way_per_m >= 0.015);
    CHECK(values.way_per_m <= 0.04);
    CHECK(values.turn_per_rad >= 0.025);
    CHECK(values.turn_per_rad <= 0.06);
  }
}

TEST_CASE("odometry that is missing or jumps predicts nothing") {
  const TrackingState tracking = Drive(100, {});
  CHECK(PredictAfter(tracking, {0.1, 0.0, 0.0}));
  CHECK_FALSE(tracking.wheels().Predict(tracking.recent(), NextTime(tracking), std::nullopt));
  CHECK_FALSE(PredictAfter(tracking, {5.0, 0.0, 0.0}));
  CHECK_FALSE(PredictAfter(tracking, {0.0, 0.0, 3.0}));
  CHECK_FALSE(tracking.wheels().Predict(tracking.recent(), NextTime(tracking), Pose2{}));  // it was reset
  TrackingState without = tracking;
  without.Add(MatchedAt(NextTime(tracking), {}));
  CHECK_FALSE(without.wheels().Predict(without.recent(), NextTime(without), tracking.recent().back().T_odom_robot));
}

TEST_CASE("the longer the time between two scans, the further the wheels may have gone, at 5 m/s and 5 rad/s at most") {
  const TrackingState tracking = Drive(100, {});
  const std::int64_t last = tracking.recent().back().utime;
  const auto Predict = [&](std::int64_t later_us, const Pose2& motion) {
    return tracking.wheels().Predict(tracking.recent(), last + later_us,
                                     *tracking.recent().back().T_odom_robot * motion);
  };
  const Pose2 far{2.5, 0.0, 2.0};
  CHECK_FALSE(Predict(490'000, far));
  const auto motion = Predict(510'000, far);
  REQUIRE(motion);
  CHECK(motion->T_from_to.x_m == Approx(2.5).margin(0.05));
  CHECK(motion->sigma_m > PredictAfter(tracking, {0.1, 0.0, 0.0})->sigma_m);
  CHECK_FALSE(Predict(390'000, {0.0, 0.0, 2.0}));
  CHECK(Predict(410'000, {0.0, 0.0, 2.0}));
  CHECK(Predict(1'000, {0.9, 0.0, 1.4}));  // stamps are not exact
}

TEST_CASE("wheels that have never moved say nothing, and when they first do, what went before counts for nothing") {
  TrackingState tracking;
  Pose2 pose;
  Pose2 told{3.0, 4.0, 0.5};
  const auto Go = [&](int num, double way_m, double told_m) {
    for (int k = 0; k < num; ++k) {
      pose = pose * Pose2{way_m, 0.0, 0.0};
      told = told * Pose2{told_m, 0.0, 0.0};
      ScanMatch match = MatchedAt(NextTime(tracking), pose);
      match.T_odom_robot = told;
      tracking.Add(match);
    }
  };
  tracking.Add([&] {
    ScanMatch first = MatchedAt(0, pose);
    first.T_odom_robot = told;
    return first;
  }());
  CHECK_FALSE(PredictAfter(tracking, {}));
  CHECK_FALSE(tracking.wheels().Learned());  // the laser has not moved either
  Go(100, 0.01, 0.0);                        // too slowly for a mean error that would show it
  CHECK_FALSE(PredictAfter(tracking, {}));
  CHECK(PredictAfter(tracking, {0.01, 0.0, 0.0}));
  REQUIRE(tracking.wheels().Learned());
  CHECK_FALSE(tracking.wheels().Learned()->have_moved);
  CHECK_FALSE(tracking.wheels().Learned()->ContradictLaser());
  Go(100, 0.1, 0.1);
  CHECK(tracking.wheels().Learned()->have_moved);
  CHECK(tracking.wheels().Learned()->slips == 0);
  CHECK(tracking.wheels().values().scale == Approx(1.0).margin(0.01));
  CHECK(PredictAfter(tracking, {}));  // from now on they may stand
}

TEST_CASE("wheels that are frozen lose their say, and get it back") {
  TrackingState tracking = Drive(300, {});
  REQUIRE(tracking.wheels().IsReliable());
  Pose2 pose = tracking.recent().back().T_map_laser;
  Pose2 told = *tracking.recent().back().T_odom_robot;
  const auto Go = [&](int num, bool frozen) {
    for (int k = 0; k < num; ++k) {
      pose = pose * Pose2{0.1, 0.0, 0.05};
      if (!frozen) told = told * Pose2{0.1, 0.0, 0.05};
      ScanMatch match = MatchedAt(NextTime(tracking), pose);
      match.T_odom_robot = told;
      tracking.Add(match);
    }
  };
  Go(12, true);
  CHECK(tracking.wheels().values().slips > 0);
  CHECK_FALSE(tracking.wheels().IsReliable());
  Go(200, true);
  CHECK_FALSE(PredictAfter(tracking, {}));
  Go(2000, false);
  CHECK(tracking.wheels().IsReliable());
  CHECK(PredictAfter(tracking, {0.1, 0.0, 0.0}));
}

TEST_CASE("that the map moves is no slip, and what was learned can be taken over") {
  TrackingState tracking = Drive(100, {});
  const WheelModel::Values before = tracking.wheels().values();
  for (int k = 0; k < 11; ++k) {
    ScanMatch next = tracking.recent().back();
    next.utime = NextTime(tracking);
    next.T_map_laser = next.T_map_laser * Pose2{0.1, 0.0, 0.0};
    next.T_odom_robot = *next.T_odom_robot * Pose2{0.1, 0.0, 0.0};
    tracking.Add(next, {k == 0 ? std::optional(Pose2{3.0, -2.0, 1.0}) : std::nullopt, 0, false});
  }
  CHECK(tracking.wheels().values().steps > before.steps);
  CHECK(tracking.wheels().values().slips == before.slips);

  const WheelModel copy(tracking.wheels().state());
  CHECK(copy == tracking.wheels());
  const auto T_odom_robot = tracking.recent().back().T_odom_robot;
  CHECK(copy.Predict(tracking.recent(), NextTime(tracking), T_odom_robot) == PredictAfter(tracking, {}));
}

TEST_CASE("the way by the wheels goes back to the last scan that was matched") {
  const WheelMotion step{{1.0, 0.0, 0.0}, 0.3, 0.1};
  std::vector<ScanMatch> recent{MatchedAt(1, {})};
  CHECK(FindWayByWheels(recent, step) == step);
  CHECK_FALSE(FindWayByWheels(recent, std::nullopt));
  ScanMatch lost = MatchedAt(2, {});
  lost.state = MatchState::kLost;
  lost.by_wheels = step;
  recent.push_back(lost);
  const auto way = FindWayByWheels(recent, step);
  REQUIRE(way);
  CheckPose(way->T_from_to, {2.0, 0.0, 0.0}, 1e-9);
  CHECK(way->sigma_m == Approx(std::sqrt(0.3 * 0.3 + 0.3 * 0.3 + 0.1 * 0.1)));
  CHECK(way->sigma_rad == Approx(std::sqrt(0.02)));
  recent.back().by_wheels.reset();
  CHECK_FALSE(FindWayByWheels(recent, step));
}

TEST_CASE("a model that has learned nothing is the same to the last bit after its state has travelled") {
  const WheelModel fresh{MatchConstants{}};
  const WheelModel restored(fresh.state(), MatchConstants{});
  const std::vector<ScanMatch> recent{MatchedAt(0, {}), MatchedAt(100'000, {0.1, 0.0, 0.0})};
  std::vector<ScanMatch> with_odometry = recent;
  for (ScanMatch& match : with_odometry) match.T_odom_robot = match.T_map_laser;
  const Pose2 robot{0.161204, 0.002916, -0.009665};
  const auto by_fresh = fresh.Predict(with_odometry, 200'000, robot);
  const auto by_restored = restored.Predict(with_odometry, 200'000, robot);
  REQUIRE((by_fresh && by_restored));
  CHECK(by_fresh->T_from_to == by_restored->T_from_to);
}

}  // namespace crsm
