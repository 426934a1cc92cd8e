#include "common/worlds/simulator.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

/// A room of 4 x 3 m with a quiet laser that looks at -180, -90, 0 and 90 deg; the speeds make 1 cm or 0.1 rad a scan.
World Room(const std::string& waypoints, const std::string& laser = "laser 360 4 8 10 0\n") {
  return ParseWorld("box 0 0 4 3\nspeed 0.1 1\n" + laser + waypoints, "room");
}

/// 10 s ahead, pi / 2 s of turning to the left, 10 s ahead; a scan every 0.1 s.
const std::string kCorner = "waypoint 1 1\nwaypoint 2 1\nwaypoint 2 2\n";

/// What the wheels tell at each scan.
std::vector<Pose2> OdometryOf(const std::string& wheels, std::uint64_t seed = 1) {
  Simulator simulator(Room(kCorner + wheels), seed);
  std::vector<Pose2> poses;
  while (simulator.Next()) {
    REQUIRE(simulator.Odometry());
    poses.push_back(*simulator.Odometry());
  }
  return poses;
}

/// The first scan of a robot that drives up from (1, 1), where a room's walls are 1 m behind, 3 m to the right, 2 m
/// ahead and 1 m to the left: in this order the four beams meet them.
LaserScan FirstScan(const std::string& laser, std::uint64_t seed = 1) {
  return *Simulator(Room("waypoint 1 1\nwaypoint 1 2\n", laser), seed).Next();
}

constexpr double kRounded = 2e-6;  // RoundOdometry, and headings count thrice

}  // namespace

TEST_CASE("the first scan shows the room from where the path begins") {
  Simulator simulator(Room("waypoint 1 1\nwaypoint 1 2\n"), 1);
  const auto scan = simulator.Next();
  REQUIRE(scan);
  CHECK(scan->utime == 1000000);
  CHECK(scan->angle_min_rad == static_cast<float>(-kPi));
  CHECK(scan->angle_step_rad == static_cast<float>(kPi / 2.0));
  REQUIRE(scan->ranges_m.size() == 4);
  const double expected_m[] = {1.0, 3.0, 2.0, 1.0};
  for (std::size_t i = 0; i < 4; ++i) CHECK(scan->ranges_m[i] == Approx(expected_m[i]).epsilon(1e-6));  // floats
  CheckPose(*simulator.TruePose(), {}, 1e-12);
}

TEST_CASE("what is beyond the laser's reach is no return") {
  const LaserScan scan = FirstScan("laser 360 4 2.5 10 0\n");
  CHECK(scan.ranges_m[1] == 0.0f);
  CHECK(scan.ranges_m[2] == Approx(2.0));
}

TEST_CASE(
    "a wall, a box or somebody who walks is there from its beginning until its end, and a leg may lead through it") {
  const std::string waypoints = "waypoint 1 1\nwaypoint 1 2\n";
  Simulator walls(Room(waypoints + "wall 0.5 1.5 3 1.5 until_s 0.2\nbox 2 0 1 3 from_s 0.3\n"), 1);
  Simulator person(Room(waypoints + "person 2 1 2 1.001 0.001 from_s 0.1 until_s 0.3\n"), 1);
  for (int k = 0; k < 6; ++k) {  // a scan every 0.1 s, up at 0.01 m a scan
    CAPTURE(k);
    const auto scan = walls.Next();
    REQUIRE(scan);
    CHECK(scan->ranges_m[2] == Approx((k < 2 ? 0.5 : 2.0) - 0.01 * k).epsilon(1e-6));  // ahead
    CHECK(scan->ranges_m[1] == Approx(k < 3 ? 3.0 : 1.0).epsilon(1e-6));               // to the right
    CHECK((person.Next()->ranges_m[1] < 2.9f) == (k == 1 || k == 2));
  }
}

TEST_CASE("in a sweep each beam is measured from where the laser is then, the last one at the time of the scan") {
  // Up at 0.1 m/s, a scan every 0.1 s; the beams of a sweep are 0.03 s apart: behind, right, ahead, left.
  Simulator at_once(Room("waypoint 1 1\nwaypoint 1 2\n"), 1);
  Simulator sweeping(Room("waypoint 1 1\nwaypoint 1 2\n", "laser 360 4 8 10 0 sweep_s 0.09\n"), 1);
  for (int i = 0; i < 5; ++i) {
    const auto expected = at_once.Next();
    const auto scan = sweeping.Next();
    REQUIRE(scan);
    CHECK(sweeping.TruePose() == at_once.TruePose());
    const double moved_m = i == 0 ? 0.0 : 0.1;  // in a second; before the drive it stands
    CHECK(scan->ranges_m[0] == Approx(expected->ranges_m[0] - moved_m * 0.09).epsilon(1e-6));
    CHECK(scan->ranges_m[2] == Approx(expected->ranges_m[2] + moved_m * 0.03).epsilon(1e-6));
    CHECK(scan->ranges_m[3] == Approx(expected->ranges_m[3]).epsilon(1e-6));
  }
}

TEST_CASE("with an angle scale, beams look at that share of the angle that the scan says") {
  const LaserScan scan = FirstScan("laser 360 4 9 10 0 angle_scale 0.95\n");
  CHECK(scan.angle_min_rad == static_cast<float>(-kPi));
  CHECK(scan.angle_step_rad == static_cast<float>(kPi / 2.0));
  // 3 m before the right wall, the beam to the right is 4.5 degrees ahead of the perpendicular.
  CHECK(scan.ranges_m[1] == Approx(3.0 / std::cos(4.5 * kPi / 180.0)).epsilon(1e-6));
  CHECK(scan.ranges_m[2] == Approx(2.0).epsilon(1e-6));
}

TEST_CASE("the laser drives straight, turns on the spot and drives on, at the world's speeds") {
  Simulator simulator(Room("waypoint 1 1\nwaypoint 2 1\nwaypoint 2 2\n"), 1);
  std::vector<Pose2> poses;
  std::int64_t utime = 1000000;
  while (const auto scan = simulator.Next()) {
    CHECK(scan->utime == utime);
    utime += 100000;
    poses.push_back(*simulator.TruePose());
  }
  // 10 s ahead, pi / 2 s of turning, 10 s ahead: scans at 0.0 to 21.5 s, and one at the end.
  REQUIRE(poses.size() == 217);
  CHECK(poses[50].x_m == Approx(0.5));
  CHECK(poses[50].yaw_rad == 0.0);
  CHECK(poses[110].x_m == Approx(1.0));
  CHECK(poses[110].y_m == Approx(0.0).margin(1e-12));
  CHECK(poses[110].yaw_rad == Approx(1.0));
  CHECK(poses[200].y_m == Approx(0.1 * (20.0 - 10.0 - kPi / 2.0)));
  CHECK(poses[216].x_m == Approx(1.0));
  CHECK(poses[216].y_m == Approx(1.0));
  CHECK(poses[216].yaw_rad == Approx(kPi / 2.0));
}

TEST_CASE("the laser faces its way in every direction") {
  for (int degrees = -180; degrees < 180; degrees += 15) {
    CAPTURE(degrees);
    const double yaw_rad = degrees * kPi / 180.0;
    World world = Room("waypoint 2 1.5\nwaypoint 3 1.5\n");
    const Point middle{2.0 + 0.5 * std::cos(yaw_rad), 1.5 + 0.5 * std::sin(yaw_rad)};
    world.path = {{2.0, 1.5}, middle, {2.0, 1.5}, {2.5, 1.5}};
    Simulator simulator(world, 1);
    const auto first = simulator.Next();
    // Towards the upper right or lower left corner and so on: what the beam ahead meets tells the heading.
    CHECK(first->ranges_m[2] == Approx(CastRay(world.walls, {2.0, 1.5}, {std::sin(yaw_rad), std::cos(yaw_rad)})));
    ReadAll(simulator);
    const Pose2 last = *simulator.TruePose();
    CHECK(std::cos(last.yaw_rad) == Approx(std::cos(-yaw_rad)).margin(1e-12));
    CHECK(std::sin(last.yaw_rad) == Approx(std::sin(-yaw_rad)).margin(1e-12));
    CHECK(last.x_m == Approx(0.5 * std::cos(yaw_rad)).margin(1e-12));
    CHECK(last.y_m == Approx(-0.5 * std::sin(yaw_rad)).margin(1e-12));
  }
}

TEST_CASE("the same seed gives the same scans, another seed other ones") {
  const auto ScansOf = [](std::uint64_t seed) {
    Simulator simulator(LoadWorld("corridor"), seed);
    return ReadAll(simulator);
  };
  CHECK(ScansOf(7).size() > 900);
  CHECK(ScansOf(7) == ScansOf(7));
  CHECK(ScansOf(7) != ScansOf(8));
}

TEST_CASE("walls beyond the laser's reach change nothing, and one that noise brings within it is seen") {
  const auto ScansOf = [](const std::string& walls) {
    Simulator simulator(ParseWorld(walls + "laser 180 180 5 5 0.1\nspeed 1 1\nwaypoint 0 0\nwaypoint 2 0\n", "w"), 3);
    return ReadAll(simulator);
  };
  const std::string near = "wall -3 -4 6 -4\n";
  CHECK(ScansOf(near) == ScansOf(near + "wall -20 7 20 7\nwall 30 -9 30 9\n"));
  CHECK(ScansOf(near) != ScansOf(near + "wall 7.1 -1 7.1 1\n"));
}

TEST_CASE("ranges are as noisy as the world says, come in its steps, and as many are dropped as it says") {
  constexpr std::size_t kBeams = 4096;
  const auto Ranges = [](const std::string& rest) { return FirstScan("laser 360 4096 8 10 " + rest, 3).ranges_m; };
  const std::vector<float> quiet = Ranges("0\n");
  const std::vector<float> noisy = Ranges("0.02\n");
  const std::vector<float> stepped = Ranges("0.02 quantum_m 0.05\n");
  double sum = 0.0;
  double sum_of_squares = 0.0;
  double largest_step_m = 0.0;
  for (std::size_t i = 0; i < kBeams; ++i) {
    const double error_m = noisy[i] - quiet[i];
    sum += error_m;
    sum_of_squares += error_m * error_m;
    CHECK(stepped[i] / 0.05 == Approx(std::round(stepped[i] / 0.05)).margin(1e-4));
    largest_step_m = std::max(largest_step_m, std::abs(static_cast<double>(stepped[i]) - noisy[i]));
  }
  CHECK(sum / kBeams == Approx(0.0).margin(4.0 * 0.02 / 64.0));                   // four sigma of a mean of 4096
  CHECK(std::sqrt(sum_of_squares / kBeams) == Approx(0.02).epsilon(4.0 / 90.5));  // and of their deviation
  CHECK(largest_step_m <= 0.025 + 1e-6);
  const std::vector<float> dropping = Ranges("0 dropout 0.2\n");
  const auto num_dropped = std::count(dropping.begin(), dropping.end(), 0.0f);
  CHECK(static_cast<double>(num_dropped) == Approx(0.2 * kBeams).margin(4.0 * std::sqrt(0.2 * 0.8 * kBeams)));
}

TEST_CASE("somebody who walks to and fro stands in the way, and the truth knows nothing of it") {
  // 4 cm a scan on a way of 0.8 m; the beam ahead runs along it, from 1 m before its start.
  Simulator simulator(Room("waypoint 1 1\nwaypoint 1.5 1\nperson 2 1 2.8 1 0.4\n"), 1);
  const auto Ahead = [&] {
    const auto scan = simulator.Next();
    return static_cast<double>(scan->ranges_m[2]) + simulator.TruePose()->x_m;
  };
  const double first_m = 1.0 - kPersonRadius_m;
  CHECK(Ahead() == Approx(first_m));
  CHECK(Ahead() == Approx(first_m + 0.04));
  for (int i = 2; i < 20; ++i) Ahead();
  CHECK(Ahead() == Approx(first_m + 0.8));
  CHECK(Ahead() == Approx(first_m + 0.76));
  for (int i = 22; i < 40; ++i) Ahead();
  CHECK(Ahead() == Approx(first_m));
}

TEST_CASE("a companion walks along the path with the robot, straight on beyond its ends, and beside it as it looks") {
  // Right for 1 m, then up; 1 cm a scan, and 16 scans of turning. The beams: behind, right, ahead, left.
  const auto SeenAt = [](const std::string& companion, int scan) {
    Simulator simulator(Room(kCorner + companion), 1);
    for (int i = 0; i < scan; ++i) simulator.Next();
    return simulator.Next()->ranges_m;
  };
  const float touch_m = static_cast<float>(0.5 - kPersonRadius_m);
  CHECK(SeenAt("companion 0.5 0\n", 0)[2] == Approx(touch_m));
  CHECK(SeenAt("companion 0.5 0\n", 50)[2] == Approx(touch_m));
  CHECK(SeenAt("companion 0.4 0\n", 108)[2] > 1.5f);  // half turned: round the corner, beside the beam ahead
  CHECK(SeenAt("companion 0.4 0\n", 116)[2] == Approx(0.2).epsilon(1e-3));  // all but turned: right ahead
  CHECK(SeenAt("companion 0.5 0\n", 216)[2] == Approx(touch_m));            // beyond the end
  CHECK(SeenAt("companion -0.5 0\n", 0)[0] == Approx(touch_m));             // before the start
  CHECK(SeenAt("companion -0.5 0\n", 60)[0] == Approx(touch_m));
  CHECK(SeenAt("companion -0.5 0\n", 186)[0] == Approx(touch_m));  // round the corner: 0.6 m up
  CHECK(SeenAt("companion 0 0.5\n", 50)[3] == Approx(touch_m));
  CHECK(SeenAt("companion 0 -0.5\n", 186)[1] == Approx(touch_m));
  CHECK(SeenAt("companion 0.5 0 from_s 1 until_s 2\n", 9)[2] == Approx(2.91));
  CHECK(SeenAt("companion 0.5 0 from_s 1 until_s 2\n", 10)[2] == Approx(touch_m));
}

TEST_CASE(
    "wheels without a fault tell where the laser truly is, from the start on, and a world without them tells nothing") {
  Simulator simulator(Room(kCorner + "wheels 1 1 0 0\n"), 1);
  CHECK(simulator.Odometry() == Pose2{});
  while (simulator.Next()) {
    REQUIRE(simulator.Odometry());
    CheckPose(*simulator.Odometry(), *simulator.TruePose(), kRounded);
    CHECK(simulator.Odometry() == RoundOdometry(*simulator.Odometry()));
  }
  Simulator without(Room(kCorner), 1);
  without.Next();
  CHECK_FALSE(without.Odometry());
}

TEST_CASE("ways and turns are told by their scales, and from where the laser stands on the robot") {
  const auto poses = OdometryOf("wheels 1.1 0.9 0 0\n");
  REQUIRE(poses.size() == 217);
  CheckPose(poses[50], {0.55, 0.0, 0.0}, kRounded);
  CheckPose(poses[110], {1.1, 0.0, 0.9}, kRounded);
  const double turned_rad = 0.9 * kPi / 2.0;
  CheckPose(poses[216], {1.1 + 1.1 * std::cos(turned_rad), 1.1 * std::sin(turned_rad), turned_rad}, kRounded);

  // The laser looks to the robot's left, and so the robot goes to its own left.
  const auto beside = OdometryOf("wheels 1 1 0 0 x_m 0.2 y_m -0.1 yaw_deg 90\n");
  REQUIRE(beside.size() == 217);
  CheckPose(beside[50], {0.0, 0.5, 0.0}, kRounded);
  // After a quarter of a turn to the left, the laser at (0.2, -0.1) is where it was: the robot has gone around it.
  const Pose2 turned = Pose2{0.2, -0.1 + 1.0, 0.0} * Pose2{0.0, 0.0, kPi / 2.0} * Pose2{-0.2, 0.1, 0.0};
  CheckPose(beside[116], turned * Pose2{0.0, 0.1 * (11.6 - 10.0 - kPi / 2.0), 0.0}, kRounded);
}

TEST_CASE("with a delay the wheels tell where the robot was") {
  const auto poses = OdometryOf("wheels 1 1 0 0\n");
  const auto late = OdometryOf("wheels 1 1 0 0 delay_s 0.3\n");
  REQUIRE(late.size() == poses.size());
  for (std::size_t k = 0; k < late.size(); ++k) {
    CAPTURE(k);
    CheckPose(late[k], k < 3 ? Pose2{} : poses[k - 3], 2.0 * kRounded);
  }
}

TEST_CASE("wheels count all turns between rare scans, and the ways around a corner") {
  Simulator simulator(
      Room("waypoint 1 1\nwaypoint 2 1\nwaypoint 1 1.001\nwaypoint 1.3 2\nwheels 1 0.5 0 0\n", "laser 360 4 8 0.1 0\n"),
      1);
  std::optional<Pose2> last;
  while (simulator.Next()) last = simulator.Odometry();
  // A turn to the left by nearly pi, then one to the right: half of each, to less than a thousandth of the path.
  const double first_rad = kPi - 0.001;
  const double second_rad = std::atan2(0.999, 0.3) - first_rad;
  const Pose2 expected =
      Pose2{1.0, 0.0, 0.5 * first_rad} * Pose2{1.0, 0.0, 0.5 * second_rad} * Pose2{std::hypot(0.3, 0.999), 0.0, 0.0};
  REQUIRE(last);
  CheckPose(*last, expected, 2e-3);
}

TEST_CASE("the wheels are as noisy as the world says, with noise that grows with the root") {
  // 400 drives of 2 m and of pi / 2. Ways: of both legs, 1 m each.
  double ways_m2 = 0.0;
  double turns_rad2 = 0.0;
  constexpr int kDrives = 400;
  for (int seed = 1; seed <= kDrives; ++seed) {
    const auto poses = OdometryOf("wheels 1 1 0.02 0.03\n", static_cast<std::uint64_t>(seed));
    ways_m2 += (poses[100].x_m - 1.0) * (poses[100].x_m - 1.0);
    const double turned_rad = poses[216].yaw_rad - kPi / 2.0;
    turns_rad2 += turned_rad * turned_rad;
    CHECK(poses[100].y_m == 0.0);
    CHECK(poses[100].yaw_rad == 0.0);
  }
  const double four_sigma = 4.0 / std::sqrt(2.0 * kDrives);  // of a standard deviation, its share
  CHECK(std::sqrt(ways_m2 / kDrives) == Approx(0.02).epsilon(four_sigma));
  CHECK(std::sqrt(turns_rad2 / kDrives) == Approx(0.03 * std::sqrt(kPi / 2.0)).epsilon(four_sigma));
}

TEST_CASE("wheels change no range of a seed, and their noise is that of the seed") {
  const std::string laser = "laser 360 40 8 10 0.02 dropout 0.1\n";
  Simulator without(Room(kCorner, laser), 5);
  Simulator with(Room(kCorner + "wheels 1 1 0.02 0.03 delay_s 0.1\n", laser), 5);
  CHECK(ReadAll(with) == ReadAll(without));
  CHECK(OdometryOf("wheels 1 1 0.02 0.03\n", 5) == OdometryOf("wheels 1 1 0.02 0.03\n", 5));
  CHECK(OdometryOf("wheels 1 1 0.02 0.03\n", 5) != OdometryOf("wheels 1 1 0.02 0.03\n", 6));
}

TEST_CASE("the simulator's progress rises to 1, and then it ends for good") {
  Simulator simulator(Room("waypoint 1 1\nwaypoint 2 1\n"), 1);
  CHECK(simulator.Progress() == 0.0);
  for (int i = 0; i < 50; ++i) simulator.Next();
  CHECK(simulator.Progress() == Approx(0.5));
  ReadAll(simulator);
  CHECK(simulator.Progress() == 1.0);
  CHECK_FALSE(simulator.Next());
  CHECK(simulator.Counts().empty());
}

}  // namespace crsm
