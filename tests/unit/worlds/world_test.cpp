#include "common/worlds/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

const std::string kRest =
    "laser 180 181 8 10 0.01\n"
    "speed 0.3 0.5\n"
    "waypoint 1 1\n"
    "waypoint 3 1\n";
const std::string kRoom = "box 0 0 4 3\n" + kRest;

double DistanceToWall(const Wall& wall, const Point& point) {
  const double dx_m = wall.to.x_m - wall.from.x_m;
  const double dy_m = wall.to.y_m - wall.from.y_m;
  const double along = ((point.x_m - wall.from.x_m) * dx_m + (point.y_m - wall.from.y_m) * dy_m) /
                       std::max(dx_m * dx_m + dy_m * dy_m, 1e-12);
  const double u = std::clamp(along, 0.0, 1.0);
  return std::hypot(wall.from.x_m + u * dx_m - point.x_m, wall.from.y_m + u * dy_m - point.y_m);
}

double DistanceToWalls(const World& world, const Point& point) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Wall& wall : world.walls) nearest_m = std::min(nearest_m, DistanceToWall(wall, point));
  return nearest_m;
}

/// The distance of the path to the walls, as far as the first place that is nearer than `keeps_m`. A step is as long as
/// nothing on it can be nearer, but 1 cm at least.
double ClosestOnPath(const World& world, double keeps_m) {
  double closest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < world.path.size() && closest_m >= keeps_m; ++i) {
    const Point& from = world.path[i - 1];
    const Point& to = world.path[i];
    const double length_m = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
    for (double way_m = 0.0; way_m < length_m && closest_m >= keeps_m;) {
      const double share = way_m / length_m;
      const double free_m =
          DistanceToWalls(world, {from.x_m + (to.x_m - from.x_m) * share, from.y_m + (to.y_m - from.y_m) * share});
      closest_m = std::min(closest_m, free_m);
      way_m += std::max(0.01, free_m - keeps_m);
    }
    closest_m = std::min(closest_m, DistanceToWalls(world, to));
  }
  return closest_m;
}

}  // namespace

TEST_CASE("a world is read from its text, comments and all") {
  const World world = ParseWorld(
      "# a room\n\n"
      "box 1 2 3 4   # x, y, width, height\n"
      "\twall -1 0 -1 5\r\n"
      "speed 0.3 0.5\n"
      "waypoint 2 3\n"
      "waypoint 3 5\n"
      "laser 270 540 9.5 20 0.02",
      "room.world");
  REQUIRE(world.walls.size() == 5);
  double length_m = 0.0;
  for (int i = 0; i < 4; ++i) {
    const Wall& wall = world.walls[static_cast<std::size_t>(i)];
    length_m += std::hypot(wall.to.x_m - wall.from.x_m, wall.to.y_m - wall.from.y_m);
  }
  CHECK(length_m == 14.0);
  CHECK(world.walls[4].to.y_m == 5.0);
  REQUIRE(world.path.size() == 2);
  CHECK(world.path[1].y_m == 5.0);
  CHECK(world.laser.fov_rad == Approx(1.5 * kPi));
  CHECK(world.laser.beams == 540);
  CHECK(world.laser.range_max_m == 9.5);
  CHECK(world.laser.rate_hz == 20.0);
  CHECK(world.laser.noise_m == 0.02);
  CHECK(world.linear_m_s == 0.3);
  CHECK(world.angular_rad_s == 0.5);
}

TEST_CASE("an error in a world names the file, the line and what would be right") {
  const std::vector<std::pair<std::string, std::string>> errors = {
      {"wal 0 0 1 1\n" + kRoom,
       "w:1: 'wal' is none of box, companion, corner, laser, person, speed, wall, waypoint, wheels"},
      {"# one\nbox 0 0 4\n" + kRest, "w:2: 3 numbers after 'box', must be 4: box x_m y_m width_m height_m"},
      {"wall 0 0 1 2 3\n" + kRest, "w:1: 5 numbers after 'wall', must be 4: wall x1_m y1_m x2_m y2_m"},
      {"wall 0 0 1 nan\n" + kRest, "w:1: wall y2_m is 'nan', must be a number from -1000 to 1000"},
      {"box 0 0 -4 3\n" + kRest, "w:1: box width_m is '-4', must be a number from 0.001 to 1000"},
      {"laser 180 1 8 10 0\n", "w:1: laser beams is '1', must be a number from 2 to 4096"},
      {"laser 180 2.5 8 10 0\n", "w:1: laser beams is 2.5, must be a whole number"},
      {"laser 180 181 8 10 0 dropout 1.5\n", "w:1: laser dropout is '1.5', must be a number from 0 to 1"},
      {"laser 180 181 8 10 0 drop 0.1\n",
       "w:1: laser option 'drop' is none of dropout, quantum_m, sweep_s, angle_scale, each with a number"},
      {"laser 180 181 8 10 0 dropout\n",
       "w:1: 6 numbers after 'laser', must be 5: laser fov_deg beams range_max_m rate_hz noise_m"},
      {"wall 0 0 1 2 from_s 3 until_s 3\n" + kRest, "w:1: until_s is 3, must be above from_s, which is 3"},
      {"box 0 0 1 2 until_s -1\n" + kRest, "w:1: box until_s is '-1', must be a number from 0 to 1000000"},
      {"corner\n", "w:1: a corner needs a name: corner NAME x_m y_m"},
      {"corner a 1\n", "w:1: 1 numbers after 'corner', must be 2: corner NAME x_m y_m"},
      {"corner a 1 1\ncorner a 2 2\n", "w:2: a second corner 'a'; each needs a name of its own"},
      {"person 1 1 2 2 0\n", "w:1: person speed_m_s is '0', must be a number from 0.001 to 10"},
      {kRoom + "speed 1 1\n", "w:6: a second 'speed' line; there must be one"},
      {"wheels -1 1 0 0\n", "w:1: wheels way_scale is '-1', must be a number from 0 to 10"},
      {"wheels 1 1 0 0 yaw_deg 181\n", "w:1: wheels yaw_deg is '181', must be a number from -180 to 180"},
      {"wheels 1 1 0 0\nwheels 1 1 0 0\n", "w:2: a second 'wheels' line; there must be one"},
      {"", "w: no line 'laser fov_deg beams range_max_m rate_hz noise_m'"},
      {"laser 180 181 8 10 0\n", "w: no line 'speed linear_m_s angular_rad_s'"},
      {kRest, "w: no wall and no box; there is nothing to see"},
      {"box 0 0 4 3\nlaser 180 181 8 10 0\nspeed 1 1\nwaypoint 1 1\n", "w: 1 waypoints, must be two or more"},
      {kRoom + "waypoint 3 1\n", "w:6: this waypoint repeats the one before it"},
      {kRoom + "waypoint 5 1\n", "w:6: the way to this waypoint goes through a wall; go around it"},
      {kRoom + "waypoint 3 3\n", "w:6: the way to this waypoint goes through a wall; go around it"},
  };
  for (const auto& [text, error] : errors) CHECK(ErrorOf([&] { ParseWorld(text, "w"); }) == error);
  CHECK(ErrorOf([] { ParseWorld(kRoom, "w"); }).empty());
}

TEST_CASE("a world is loaded by its name or from its file") {
  CHECK(LoadWorld("demo").walls.size() > 50);
  const ScratchFile file(kRoom);
  CHECK(LoadWorld(file.path()).walls.size() == 4);
  const ScratchFile wrong("box 1\n");
  CHECK(ErrorOf([&] { LoadWorld(wrong.path()); }).find(wrong.path() + ":1: ") == 0);
  CHECK(LoadWorldText(file.path()) == kRoom);
  CHECK(ErrorOf([] { LoadWorld("no_such"); }).ends_with("symmetric, twins, campus[:LENGTH_M[:NUMBER]]"));
  CHECK(ErrorOf([] { LoadWorld("corridr"); }).ends_with("; did you mean sim:corridor?"));
  CHECK(ErrorOf([] { LoadWorld("campsu"); }).ends_with("; did you mean sim:campus?"));
}

TEST_CASE("corners, people, companions, wheels and options are read; most worlds have no wheels") {
  const World world = ParseWorld(
      "box 0 0 4 3\nspeed 1 1\nwaypoint 1 1\nwaypoint 3 1\ncorner left 0 3\nperson 1 2 3 2.5 0.7\n"
      "companion -1 0.2 until_s 5\n"
      "laser 180 181 8 10 0.01 quantum_m 0.005 dropout 0.1 angle_scale 0.99\n"
      "wheels 1.05 0.97 0.02 0.03 delay_s 0.1 yaw_deg 90 y_m -0.2 x_m 0.1\n",
      "w");
  REQUIRE(world.corners.size() == 1);
  CHECK(world.corners[0].name == "left");
  CHECK(world.corners[0].at.y_m == 3.0);
  REQUIRE(world.people.size() == 1);
  CHECK(world.people[0].to.y_m == 2.5);
  CHECK(world.people[0].speed_m_s == 0.7);
  REQUIRE(world.companions.size() == 1);
  CHECK(world.companions[0].ahead_m == -1.0);
  CHECK(world.companions[0].left_m == 0.2);
  CHECK(world.companions[0].stay.until_s == 5.0);
  CHECK(world.laser.noise_m == 0.01);
  CHECK(world.laser.dropout == 0.1);
  CHECK(world.laser.quantum_m == 0.005);
  CHECK(world.laser.angle_scale == 0.99);
  REQUIRE(world.wheels);
  CHECK(world.wheels->way_scale == 1.05);
  CHECK(world.wheels->turn_scale == 0.97);
  CHECK(world.wheels->way_noise == 0.02);
  CHECK(world.wheels->turn_noise == 0.03);
  CHECK(world.wheels->T_robot_laser.x_m == 0.1);
  CHECK(world.wheels->T_robot_laser.y_m == -0.2);
  CHECK(world.wheels->T_robot_laser.yaw_rad == Approx(kPi / 2.0));
  CHECK(world.wheels->delay_s == 0.1);
  const auto plain = ParseWorld(kRoom + "wheels 1 1 0 0\n", "w").wheels;
  REQUIRE(plain);
  CHECK(plain->T_robot_laser == Pose2{});
  CHECK(plain->delay_s == 0.0);
  CHECK_FALSE(ParseWorld(kRoom, "w").wheels);
}

TEST_CASE("the environments have the paper's areas, laser and speeds, and walls meet at their corners") {
  const std::vector<std::pair<std::string, double>> areas_m2 = {{"env1", 420.0}, {"env2", 264.0}, {"env3", 170.0}};
  for (const auto& [name, area_m2] : areas_m2) {
    CAPTURE(name);
    const World world = LoadWorld(name);
    const Point& upper_right = world.walls[1].to;  // of the box around it all, which is the first line
    CHECK(upper_right.x_m * upper_right.y_m == Approx(area_m2));
    CHECK(world.laser.beams == 270);
    CHECK(world.laser.fov_rad == Approx(1.5 * kPi));
    CHECK(world.laser.range_max_m == 9.5);
    CHECK(world.linear_m_s == 0.15);
    CHECK(world.angular_rad_s == 0.12);
    CHECK(world.corners.size() >= 10);
    for (const Corner& corner : world.corners) {
      CAPTURE(corner.name);
      int along_x = 0;
      int along_y = 0;
      for (const Wall& wall : world.walls) {
        if (DistanceToWall(wall, corner.at) > 1e-9) continue;
        (std::abs(wall.to.x_m - wall.from.x_m) > std::abs(wall.to.y_m - wall.from.y_m) ? along_x : along_y) += 1;
      }
      CHECK(along_x > 0);
      CHECK(along_y > 0);
    }
  }
}

TEST_CASE("a ray meets a disc where the circle's equation says") {
  const Point centre{3.0, 1.0};
  CHECK(CastRayAtDisc(centre, 0.5, {0.0, 1.0}, {0.0, 1.0}) == Approx(2.5));
  CHECK(CastRayAtDisc(centre, 0.5, {0.0, 1.3}, {0.0, 1.0}) == Approx(3.0 - 0.4));  // 3-4-5
  CHECK(std::isinf(CastRayAtDisc(centre, 0.5, {0.0, 1.6}, {0.0, 1.0})));           // passes beside
  CHECK(std::isinf(CastRayAtDisc(centre, 0.5, {0.0, 1.0}, {0.0, -1.0})));          // behind
  CHECK(std::isinf(CastRayAtDisc(centre, 0.5, {3.1, 1.0}, {0.0, 1.0})));           // from within
}

TEST_CASE("a ray ends at the wall in front of it, and passes beside a wall, behind it and along it") {
  const World room = ParseWorld(kRoom, "room");
  CHECK(CastRay(room.walls, {1.0, 1.0}, {0.0, -1.0}) == Approx(1.0));
  CHECK(CastRay(room.walls, {1.0, 1.0}, {1.0, 0.0}) == Approx(2.0));
  CHECK(CastRay(room.walls, {1.0, 1.0}, {-0.6, 0.8}) == Approx(1.0 / 0.6));
  CHECK(CastRay(room.walls, {1.0, 0.0}, {1.0, 0.0}) == 0.0);  // standing on a wall
  const std::vector<Wall> wall = {{{1.0, 0.0}, {1.0, 2.0}}};
  CHECK(std::isinf(CastRay({}, {0.0, 0.0}, {0.0, 1.0})));
  CHECK(std::isinf(CastRay(wall, {0.0, 2.1}, {0.0, 1.0})));
  CHECK(std::isinf(CastRay(wall, {1.5, 1.0}, {0.0, 1.0})));
  CHECK(std::isinf(CastRay(wall, {1.0, -1.0}, {1.0, 0.0})));
  CHECK(CastRay(wall, {0.0, 2.0}, {0.0, 1.0}) == Approx(1.0));  // its very end stops a ray
}

TEST_CASE("no ray leaves a closed room through its corners") {
  const World world = ParseWorld("box 0.1 0.3 3.3 2.7\n" + kRest, "room");
  const Point origin{1.7, 1.1};
  for (const Wall& wall : world.walls) {
    const double dx_m = wall.from.x_m - origin.x_m;
    const double dy_m = wall.from.y_m - origin.y_m;
    const double distance_m = std::hypot(dx_m, dy_m);
    CHECK(CastRay(world.walls, origin, {dy_m / distance_m, dx_m / distance_m}) == Approx(distance_m));
  }
}

TEST_CASE("rays in the demo world end where walking in safe steps ends") {
  const World world = LoadWorld("demo");
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Point origin{random.Uniform(0.0, 14.0), random.Uniform(0.0, 10.0)};
    const double angle_rad = random.Uniform(-kPi, kPi);
    // The slow way: as far as the nearest wall in any direction is, no wall can be passed.
    double walked_m = 0.0;
    for (int step = 0; step < 10000; ++step) {
      const double safe_m = DistanceToWalls(
          world, {origin.x_m + walked_m * std::cos(angle_rad), origin.y_m + walked_m * std::sin(angle_rad)});
      if (safe_m < 1e-9) break;
      walked_m += safe_m;
    }
    CHECK(CastRay(world.walls, origin, ComputeSinCos(angle_rad)) == Approx(walked_m).margin(1e-6));
  }
}

TEST_CASE("the paths of the built-in worlds and of campuses keep 0.25 m from every wall") {
  std::vector<std::string> names = ListBuiltInWorlds();
  for (const char* campus : {"campus:1000:1", "campus:1000:2", "campus:1000:3"}) names.push_back(campus);
  for (const std::string& name : names) {
    CAPTURE(name);
    const World world = LoadWorld(name);
    CHECK(ClosestOnPath(world, 0.25) >= 0.25);
    CHECK(world.path.size() > (name.starts_with("campus") ? 20u : 1u));
  }
}

TEST_CASE("a campus is as long as it is asked to be, and each number is another one") {
  const auto LengthOf = [](const World& world) {
    double length_m = 0.0;
    for (std::size_t i = 1; i < world.path.size(); ++i) {
      length_m += std::hypot(world.path[i].x_m - world.path[i - 1].x_m, world.path[i].y_m - world.path[i - 1].y_m);
    }
    return length_m;
  };
  constexpr double kLongestWay_m = 55.0;  // from hall to hall
  CHECK(LengthOf(LoadWorld("campus")) == Approx(3000.0 + 0.5 * kLongestWay_m).margin(0.5 * kLongestWay_m));
  CHECK(LengthOf(LoadWorld("campus:500:7")) == Approx(500.0 + 0.5 * kLongestWay_m).margin(0.5 * kLongestWay_m));
  CHECK(LoadWorldText("campus:3000:1") == LoadWorldText("campus"));
  CHECK(LoadWorldText("campus:3000:2") != LoadWorldText("campus"));
  CHECK(ErrorOf([] { LoadWorld("campus:9"); }) ==
        "campus:9: campus LENGTH_M is '9', must be a number from 10 to 100000");
  CHECK(ErrorOf([] { LoadWorld("campus:500:b"); }) ==
        "campus:500:b: campus NUMBER is 'b', must be a number from 0 to 1000000000");
}

}  // namespace crsm
