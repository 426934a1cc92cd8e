#include "common/worlds/simulator.hpp"

#include <algorithm>
#include <cmath>

namespace crsm {
namespace {

/// Where somebody who walks to and fro is after `time_s`.
Point PlaceOf(const Person& person, double time_s) {
  const double dx_m = person.to.x_m - person.from.x_m;
  const double dy_m = person.to.y_m - person.from.y_m;
  const double length_m = std::sqrt(dx_m * dx_m + dy_m * dy_m);
  if (length_m == 0.0) return person.from;
  const double lengths = person.speed_m_s * time_s / length_m;
  const double on_round_trip = lengths - 2.0 * std::floor(lengths / 2.0);
  const double done = on_round_trip <= 1.0 ? on_round_trip : 2.0 - on_round_trip;
  return {person.from.x_m + done * dx_m, person.from.y_m + done * dy_m};
}

/// Those that come so near, and are there at the time.
std::vector<Wall> WallsWithin(double reach_m, const Point& origin, double time_s, const std::vector<Wall>& walls) {
  std::vector<Wall> near;
  for (const Wall& wall : walls) {
    if (!wall.stay.Includes(time_s)) continue;
    const double x_m = wall.to.x_m - wall.from.x_m;
    const double y_m = wall.to.y_m - wall.from.y_m;
    const double to_x_m = origin.x_m - wall.from.x_m;
    const double to_y_m = origin.y_m - wall.from.y_m;
    const double squared_m2 = x_m * x_m + y_m * y_m;
    const double share = squared_m2 > 0.0 ? std::clamp((to_x_m * x_m + to_y_m * y_m) / squared_m2, 0.0, 1.0) : 0.0;
    const double beside_x_m = to_x_m - share * x_m;
    const double beside_y_m = to_y_m - share * y_m;
    if (beside_x_m * beside_x_m + beside_y_m * beside_y_m <= reach_m * reach_m) near.push_back(wall);
  }
  return near;
}

/// How the wheels tell a motion of the robot.
Pose2 Tell(const Pose2& motion, const World::Wheels& wheels, Random& random) {
  const double way_m = Length(motion);
  const double way_off_m = wheels.way_noise * std::sqrt(way_m) * random.Gaussian();
  const double turn_off_rad = wheels.turn_noise * std::sqrt(std::abs(motion.yaw_rad)) * random.Gaussian();
  const double share = way_m > 0.0 ? wheels.way_scale + way_off_m / way_m : 0.0;
  return {share * motion.x_m, share * motion.y_m, wheels.turn_scale * motion.yaw_rad + turn_off_rad};
}

constexpr std::uint64_t kWheelStream = 1;

}  // namespace

Simulator::Simulator(const World& world, std::uint64_t seed)
    : world_(world), random_(seed), wheel_random_(seed, kWheelStream) {
  for (std::size_t i = 1; i < world_.path.size(); ++i) {
    const Point& from = world_.path[i - 1];
    const Point& to = world_.path[i];
    const double dx_m = to.x_m - from.x_m;
    const double dy_m = to.y_m - from.y_m;
    const double yaw_rad = WrapAngle(HeadingOf(dx_m, dy_m, dx_m >= 0.0 ? 0.0 : kPi));
    const double turn_rad = legs_.empty() ? 0.0 : WrapAngle(yaw_rad - legs_.back().T_world_from.yaw_rad);
    AddLeg({from.x_m, from.y_m, WrapAngle(yaw_rad - turn_rad)}, 0.0, turn_rad);
    AddLeg({from.x_m, from.y_m, yaw_rad}, std::sqrt(dx_m * dx_m + dy_m * dy_m), 0.0);
  }
}

void Simulator::AddLeg(const Pose2& T_world_from, double forward_m, double turn_rad) {
  const double duration_s = forward_m / world_.linear_m_s + std::abs(turn_rad) / world_.angular_rad_s;
  if (duration_s == 0.0) return;
  legs_.push_back({T_world_from, {forward_m, 0.0, turn_rad}, end_s_, duration_s});
  end_s_ += duration_s;
}

std::optional<LaserScan> Simulator::Next() {
  const double time_s = static_cast<double>(num_scans_) / world_.laser.rate_hz;
  if (time_s >= end_s_ + 1.0 / world_.laser.rate_hz) return std::nullopt;
  while (leg_ + 1 < legs_.size() && time_s >= legs_[leg_ + 1].start_s) ++leg_;

  T_start_laser_ = Inverse(legs_.front().T_world_from) * PoseAt(time_s);
  if (num_scans_ > 0) TurnWheels(static_cast<double>(num_scans_ - 1) / world_.laser.rate_hz, time_s);
  ++num_scans_;

  LaserScan scan = Scan(time_s);
  scan.utime = 1'000'000 + std::llround(time_s * 1e6);
  return scan;
}

double Simulator::Progress() const {
  return std::min(static_cast<double>(num_scans_) / world_.laser.rate_hz / end_s_, 1.0);
}

/// That of the next scan, or a little before it.
std::size_t Simulator::LegAt(double time_s) const {
  std::size_t at = leg_;
  while (at > 0 && time_s < legs_[at].start_s) --at;
  return at;
}

/// T_world_laser on the leg of the next scan, or a little before it; before it starts the laser stands.
Pose2 Simulator::PoseAt(double time_s) const {
  const Leg& leg = legs_[LegAt(time_s)];
  const double done = std::clamp((time_s - leg.start_s) / leg.duration_s, 0.0, 1.0);
  return leg.T_world_from * Pose2{done * leg.T_from_to.x_m, 0.0, done * leg.T_from_to.yaw_rad};
}

Point Simulator::PlaceOf(const Companion& companion, double time_s) const {
  const Pose2 T_world_laser = PoseAt(time_s);
  std::size_t at = LegAt(time_s);
  double along_m = (Inverse(legs_[at].T_world_from) * T_world_laser).x_m + companion.ahead_m;
  while (along_m > legs_[at].T_from_to.x_m && at + 1 < legs_.size()) along_m -= legs_[at++].T_from_to.x_m;
  while (along_m < 0.0 && at > 0) along_m += legs_[--at].T_from_to.x_m;
  const Pose2 on_path = legs_[at].T_world_from * Pose2{along_m, 0.0, 0.0};
  const Pose2 beside = Pose2{on_path.x_m, on_path.y_m, T_world_laser.yaw_rad} * Pose2{0.0, companion.left_m, 0.0};
  return {beside.x_m, beside.y_m};
}

/// Where everybody is who is there.
std::vector<Point> Simulator::PeopleAt(double time_s) const {
  std::vector<Point> people;
  for (const Person& person : world_.people) {
    if (person.stay.Includes(time_s)) people.push_back(crsm::PlaceOf(person, time_s));
  }
  for (const Companion& companion : world_.companions) {
    if (companion.stay.Includes(time_s)) people.push_back(PlaceOf(companion, time_s));
  }
  return people;
}

/// T_world_robot, of PoseAt.
Pose2 Simulator::RobotAt(double time_s) const { return PoseAt(time_s) * Inverse(world_.wheels->T_robot_laser); }

/// Adds to the odometry what the wheels tell between two times. In short steps: the robot may turn between rare scans,
/// even by more than half a turn.
void Simulator::TurnWheels(double from_s, double to_s) {
  constexpr double kLongestStep_s = 0.05;
  if (!world_.wheels) return;
  const double delay_s = world_.wheels->delay_s;
  const int num_steps = std::max(1, static_cast<int>(std::ceil((to_s - from_s) / kLongestStep_s)));
  Pose2 T_world_before = RobotAt(from_s - delay_s);
  for (int step = 1; step <= num_steps; ++step) {
    const double done = static_cast<double>(step) / num_steps;
    const Pose2 T_world_robot = RobotAt(from_s + done * (to_s - from_s) - delay_s);
    T_odom_robot_ = T_odom_robot_ * Tell(Inverse(T_world_before) * T_world_robot, *world_.wheels, wheel_random_);
    T_world_before = T_world_robot;
  }
}

std::optional<Pose2> Simulator::Odometry() const { return world_.wheels ? RoundOdometry(T_odom_robot_) : std::nullopt; }

LaserScan Simulator::Scan(double time_s) {
  const World::Laser& laser = world_.laser;
  LaserScan scan;
  scan.angle_min_rad = static_cast<float>(-laser.fov_rad / 2.0);
  scan.angle_step_rad = static_cast<float>(laser.fov_rad / laser.beams);
  const std::vector<Point> people = PeopleAt(time_s);
  Pose2 T_world_laser = PoseAt(time_s);
  Point origin{T_world_laser.x_m, T_world_laser.y_m};
  const double reach_m =
      laser.range_max_m + Random::kMostSigmas * laser.noise_m + laser.quantum_m + laser.sweep_s * world_.linear_m_s;
  const std::vector<Wall> walls = WallsWithin(reach_m, origin, time_s, world_.walls);
  for (int beam = 0; beam < laser.beams; ++beam) {
    if (laser.sweep_s > 0.0) {
      T_world_laser = PoseAt(time_s - laser.sweep_s * (laser.beams - 1 - beam) / (laser.beams - 1));
      origin = {T_world_laser.x_m, T_world_laser.y_m};
    }
    const double angle_rad = scan.angle_min_rad + beam * static_cast<double>(scan.angle_step_rad);
    const SinCos direction = ComputeSinCos(T_world_laser.yaw_rad + laser.angle_scale * angle_rad);
    double range_m = CastRay(walls, origin, direction);
    for (const Point& person : people) {
      range_m = std::min(range_m, CastRayAtDisc(person, kPersonRadius_m, origin, direction));
    }
    range_m += laser.noise_m * random_.Gaussian();
    if (laser.quantum_m > 0.0) range_m = laser.quantum_m * std::floor(range_m / laser.quantum_m + 0.5);
    // No number is drawn where there are no drop-outs: the other ranges of a seed stay what they are.
    const bool dropped = laser.dropout > 0.0 && random_.Uniform(0.0, 1.0) < laser.dropout;
    const bool seen = !dropped && range_m > 0.0 && range_m <= laser.range_max_m;
    scan.ranges_m.push_back(seen ? static_cast<float>(range_m) : 0.0f);
  }
  return scan;
}

}  // namespace crsm
