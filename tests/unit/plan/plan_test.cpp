#include "common/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "common/worlds/world.hpp"

namespace crsm {
namespace {

std::vector<Wall> MakeBox(double x_m, double y_m, double width_m, double height_m) {
  const std::vector<Point> corners{
      {x_m, y_m}, {x_m + width_m, y_m}, {x_m + width_m, y_m + height_m}, {x_m, y_m + height_m}};
  std::vector<Wall> walls;
  for (std::size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
  return walls;
}

void Append(std::vector<Wall>& walls, const std::vector<Wall>& more) {
  walls.insert(walls.end(), more.begin(), more.end());
}

/// What a laser sees all around, two beams a degree.
PlacedScan See(const std::vector<Wall>& walls, const Pose2& T_map_laser, std::uint64_t seed, double noise_m = 0.01) {
  Random random(seed, 1);
  ValidRays rays;
  constexpr int kBeams = 720;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = -kPi + 2.0 * kPi * i / kBeams;
    const double range_m =
        CastRay(walls, {T_map_laser.x_m, T_map_laser.y_m}, ComputeSinCos(angle + T_map_laser.yaw_rad));
    if (range_m > 30.0) continue;
    rays.angle_rad.push_back(static_cast<float>(angle));
    rays.range_m.push_back(static_cast<float>(range_m + noise_m * random.Gaussian()));
  }
  return {rays, T_map_laser};
}

/// From places of a room, 0.5 m apart.
std::vector<PlacedScan> SeeFrom(const std::vector<Wall>& walls, double from_x_m, double to_x_m, double y_m) {
  std::vector<PlacedScan> scans;
  for (double x_m = from_x_m; x_m <= to_x_m; x_m += 0.5) {
    scans.push_back(See(walls, {x_m, y_m, 0.3 * x_m}, scans.size() + static_cast<std::uint64_t>(100.0 * y_m)));
  }
  return scans;
}

void Append(std::vector<PlacedScan>& scans, const std::vector<PlacedScan>& more) {
  scans.insert(scans.end(), more.begin(), more.end());
}

/// How far the nearest end of a wall is from a point.
double FindNearestEnd(const Plan& plan, const Point& at) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const PlanWall& wall : plan.walls) {
    for (const Point& end : {wall.from, wall.to}) {
      nearest_m = std::min(nearest_m, std::hypot(end.x_m - at.x_m, end.y_m - at.y_m));
    }
  }
  return nearest_m;
}

/// Two rooms of 4 x 3 and 3 x 3 m with a thin wall between, and a door of 0.9 m in it.
std::vector<Wall> MakeTwoRooms() {
  std::vector<Wall> walls = MakeBox(0, 0, 7, 3);
  walls.push_back({{4, 0}, {4, 1}});
  walls.push_back({{4, 1.9}, {4, 3}});
  return walls;
}

std::vector<PlacedScan> SeeTwoRooms(const std::vector<Wall>& walls) {
  std::vector<PlacedScan> scans = SeeFrom(walls, 0.8, 6.4, 1.4);
  Append(scans, SeeFrom(walls, 0.8, 3.4, 2.2));
  Append(scans, SeeFrom(walls, 4.8, 6.4, 0.8));
  return scans;
}

}  // namespace

TEST_CASE("a room of 5 x 4 m has four walls that meet in its corners, and its area") {
  const Plan plan = MakePlan(SeeFrom(MakeBox(0, 0, 5, 4), 1.0, 4.0, 1.5));
  REQUIRE(plan.walls.size() == 4);
  // Ranges have an error of 10 mm, and hundreds of them are of each wall.
  for (const Point& corner : {Point{0, 0}, Point{5, 0}, Point{5, 4}, Point{0, 4}}) {
    CHECK(FindNearestEnd(plan, corner) < 0.003);
  }
  double length_m = 0.0;
  for (const PlanWall& wall : plan.walls) {
    length_m += wall.length_m;
    CHECK(wall.snapped);
    CHECK(wall.sigma_offset_m < 0.003);
  }
  CHECK(length_m == Approx(18.0).margin(0.01));
  REQUIRE(plan.rooms.size() == 1);
  CHECK(plan.rooms[0].area_m2 == Approx(20.0).epsilon(0.005));  // a quarter of a cell of 2 cm along each wall
  CHECK(plan.doors.empty());
  REQUIRE(plan.directions_rad.size() == 1);
  CHECK(std::abs(std::remainder(plan.directions_rad[0], kPi / 2.0)) < 0.002);
}

TEST_CASE("the laser was on the left of the way from one end of a wall to the other") {
  const Plan plan = MakePlan(SeeFrom(MakeBox(0, 0, 5, 4), 1.0, 4.0, 1.5));
  for (const PlanWall& wall : plan.walls) {
    const double cross =
        (wall.to.x_m - wall.from.x_m) * (2.0 - wall.from.y_m) - (wall.to.y_m - wall.from.y_m) * (2.5 - wall.from.x_m);
    CHECK(cross > 0.0);
  }
}

TEST_CASE("a wall that is 3 degrees out of square keeps its direction, one that is 0.02 degrees out does not") {
  std::vector<Wall> walls = MakeBox(0, 0, 8, 4);
  walls[2] = {{8, 4}, {0, 4 + 8 * std::tan(3.0 * kPi / 180.0)}};
  walls[3].from = walls[2].to;
  walls[0] = {{0, 0}, {8, 8 * std::tan(0.02 * kPi / 180.0)}};
  const Plan plan = MakePlan(SeeFrom(walls, 1.0, 7.0, 1.5));
  REQUIRE(plan.walls.size() == 4);
  CHECK(FindNearestEnd(plan, walls[2].to) < 0.01);
  std::vector<double> yaws;  // against a right angle
  for (const PlanWall& wall : plan.walls) {
    yaws.push_back(std::remainder(std::atan2(wall.to.y_m - wall.from.y_m, wall.to.x_m - wall.from.x_m), kPi / 2.0));
  }
  std::ranges::sort(yaws);
  CHECK(yaws[0] == Approx(-3.0 * kPi / 180.0).margin(0.001));
  CHECK(yaws[3] - yaws[1] < 1e-9);
}

TEST_CASE("a gap of 0.9 m that the laser looks through is a door, and closes both rooms; places name them") {
  const std::vector<Wall> walls = MakeTwoRooms();
  const Plan plan = MakePlan(SeeTwoRooms(walls), {{"kitchen", {5.0, 0.4}}, {"nowhere", {50.0, 0.0}}});
  REQUIRE(plan.doors.size() == 1);
  const PlanDoor& door = plan.doors[0];
  CHECK(0.5 * (door.from.y_m + door.to.y_m) == Approx(1.45).margin(0.03));  // hits are 2 cm apart there
  CHECK(std::abs(door.to.y_m - door.from.y_m) == Approx(0.9).margin(0.06));
  REQUIRE(plan.rooms.size() == 2);
  CHECK(plan.rooms[0].area_m2 == Approx(12.0).epsilon(0.015));
  CHECK(plan.rooms[1].area_m2 == Approx(9.0).epsilon(0.015));
  CHECK(plan.rooms[0].name.empty());
  CHECK(plan.rooms[1].name == "kitchen");
}

TEST_CASE("a gap of 2.2 m is no door, and the rooms on both sides are one") {
  std::vector<Wall> walls = MakeBox(0, 0, 7, 3);
  walls.push_back({{4, 0}, {4, 0.4}});
  walls.push_back({{4, 2.6}, {4, 3}});
  const Plan plan = MakePlan(SeeTwoRooms(walls));
  CHECK(plan.doors.empty());
  REQUIRE(plan.rooms.size() == 1);
  CHECK(plan.rooms[0].area_m2 == Approx(21.0).epsilon(0.015));
}

TEST_CASE("furniture is no wall: what stands alone, or before a wall, which is taken to go on behind it") {
  std::vector<Wall> walls = MakeBox(0, 0, 6, 5);
  Append(walls, MakeBox(2.5, 2.6, 0.8, 0.6));    // a table
  Append(walls, MakeBox(2.0, 4.38, 1.2, 0.6));   // a cupboard at the wall
  Append(walls, MakeBox(5.38, 0.02, 0.6, 1.2));  // and one in a corner
  std::vector<PlacedScan> scans = SeeFrom(walls, 0.8, 5.0, 1.5);
  Append(scans, SeeFrom(walls, 0.8, 5.2, 3.6));
  const Plan plan = MakePlan(scans);
  CHECK(plan.walls.size() == 4);
  for (const Point& corner : {Point{0, 0}, Point{6, 0}, Point{6, 5}, Point{0, 5}}) {
    CHECK(FindNearestEnd(plan, corner) < 0.005);
  }
  REQUIRE(plan.rooms.size() == 1);
  CHECK(plan.rooms[0].area_m2 == Approx(30.0).epsilon(0.015));
}

TEST_CASE("what most scans looked through is no wall") {
  const std::vector<Wall> walls = MakeBox(0, 0, 8, 4);
  std::vector<Wall> closed = walls;
  closed.push_back({{4, 0}, {4, 4}});  // a partition that was there at first
  std::vector<PlacedScan> scans = SeeFrom(closed, 1.0, 3.0, 2.0);
  const std::size_t num_closed = MakePlan(scans).walls.size();
  Append(scans, SeeFrom(walls, 1.0, 7.0, 1.5));
  Append(scans, SeeFrom(walls, 1.0, 7.0, 2.5));
  CHECK(num_closed == 4);
  CHECK(MakePlan(scans).walls.size() == 4);
  CHECK(FindNearestEnd(MakePlan(scans), {4, 0}) > 1.0);
}

TEST_CASE("without scans, without rays, and without straight walls a plan is empty") {
  CHECK(MakePlan({}).walls.empty());
  CHECK(MakePlan({}).rooms.empty());
  CHECK(MakePlan({{ValidRays(), Pose2()}}).walls.empty());
  CHECK(MakePlan({See(MakeBox(0, 0, 5, 4), {1, 1, 0}, 1)}).walls.empty());  // once is not often enough
}

TEST_CASE("a pose that is none is refused, and places far apart take bounded memory") {
  const PlacedScan scan = See(MakeBox(0, 0, 5, 4), {1, 1, 0}, 1);
  PlacedScan wrong = scan;
  wrong.T_map_laser.x_m = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(MakePlan({scan, wrong}), std::invalid_argument);
  PlacedScan far = scan;
  far.T_map_laser.x_m = 1e6;
  CHECK(MakePlan({scan, scan, scan, far}).walls.size() <= 4);
}

TEST_CASE("the length of a wall is as wrong as its lines and its share of what the map may be off") {
  Plan plan;
  plan.walls = {{{0, 0}, {3, 0}, 3.0, 0.01, 0.001, true}, {{3, 0}, {3, 4}, 4.0, 0.0, 0.001, true}};
  CHECK(plan.extent_m() == Approx(5.0));
  CHECK(BoundLengthError(plan, plan.walls[0]) == Approx(0.0196));
  plan.map_off_m = 0.5;
  CHECK(BoundLengthError(plan, plan.walls[0]) == Approx(std::hypot(0.0196, 0.3)));
  CHECK(BoundLengthError(plan, plan.walls[1]) == Approx(0.4));
}

TEST_CASE("a DXF file has each wall, door and room on its layer, and no byte that release 12 does not know") {
  Plan plan;
  plan.walls = {{{0, 0}, {3.25, 0}, 3.25, 0.01, 0.001, true}};
  plan.doors = {{{3.25, 0}, {4.15, 0}}};
  plan.rooms = {
      {"K\xc3\xbc"
       "che\n0",
       {1, 1},
       12.34}};
  const std::string text = FormatDxf(plan, {"a log"});
  CHECK(text.starts_with("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n"));
  CHECK(text.ends_with("0\nENDSEC\n0\nEOF\n"));
  CHECK(text.find("0\nLINE\n8\nWALLS\n10\n0.0000\n20\n0.0000\n11\n3.2500\n21\n0.0000\n") != std::string::npos);
  CHECK(text.find("0\nLINE\n8\nDOORS\n10\n3.2500\n") != std::string::npos);
  CHECK(text.find("\n1\nK??che?0, 12.34 m2\n") != std::string::npos);
  CHECK(text.find("\n1\na log\n") != std::string::npos);
  CHECK(std::ranges::count(text, '\n') % 2 == 0);  // pairs of lines
}

}  // namespace crsm
