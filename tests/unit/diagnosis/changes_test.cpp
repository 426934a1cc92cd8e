#include "common/diagnosis/changes.hpp"

#include <array>
#include <cmath>

#include "catch.hpp"
#include "common/worlds/world.hpp"

namespace crsm {
namespace {

using Box = std::array<double, 4>;  // x, y, width, height [m]

constexpr Box kRoom{0.0, 0.0, 6.0, 4.0};
constexpr Box kTable{3.0, 2.5, 0.6, 0.5};

std::vector<Wall> MakeWalls(const std::vector<Box>& boxes) {
  std::vector<Wall> walls;
  for (const auto& [x, y, w, h] : boxes) {
    const std::array<Point, 4> corners{{{x, y}, {x + w, y}, {x + w, y + h}, {x, y + h}}};
    for (std::size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
  }
  return walls;
}

/// Free within the room, occupied along the sides of the boxes, unexplored within those that stand in it.
ByteMap MakeMap(const std::vector<Box>& boxes) {
  ByteMap map(0.05);
  const MapGeometry& geometry = map.geometry();
  for (double y = 0.025; y < 4.0; y += 0.05) {
    for (double x = 0.025; x < 6.0; x += 0.05) map.Set(geometry.CellAt(x, y), kFreeByte);
  }
  for (const auto& [x0, y0, w, h] : boxes) {
    if (w < 6.0) {
      for (double y = y0 + 0.025; y < y0 + h; y += 0.05) {
        for (double x = x0 + 0.025; x < x0 + w; x += 0.05) map.Set(geometry.CellAt(x, y), kUnexploredByte);
      }
    }
    for (double along = 0.0; along <= 1.0; along += 0.002) {
      for (const auto& [x, y] : {std::pair(x0 + along * w, y0), std::pair(x0 + along * w, y0 + h),
                                 std::pair(x0, y0 + along * h), std::pair(x0 + w, y0 + along * h)}) {
        map.Set(geometry.CellAt(x, y), kOccupiedByte);
      }
    }
  }
  return map;
}

ValidRays See(const std::vector<Box>& boxes, const Pose2& pose) {
  const std::vector<Wall> walls = MakeWalls(boxes);
  ValidRays rays;
  for (int i = 0; i < 360; ++i) {
    const double angle = -kPi + i * kPi / 180.0;
    rays.angle_rad.push_back(static_cast<float>(angle));
    rays.range_m.push_back(
        static_cast<float>(CastRay(walls, {pose.x_m, pose.y_m}, ComputeSinCos(angle + pose.yaw_rad))));
  }
  return rays;
}

/// A scan a second, on the way along the room.
class Drive {
 public:
  explicit Drive(ChangeFinder& finder) : finder_(finder) {}

  double sigma_m = 0.01;
  double off_m = 0.0;  ///< of the poses, across the way
  MatchState state = MatchState::kOk;

  void Along(const std::vector<Box>& boxes, double from_m = 0.5, double to_m = 5.5, double step_m = 0.2) {
    for (double x = from_m; x <= to_m; x += step_m) At(boxes, x);
  }

  void At(const std::vector<Box>& boxes, double x_m) {
    ScanMatch match;
    match.utime = utime_ += 1'000'000;
    match.T_map_laser = {x_m, 1.0 + off_m, 0.0};
    match.state = state;
    match.covariance = {sigma_m * sigma_m, 0.0, 0.0, sigma_m * sigma_m, 0.0, 1e-6};
    finder_.Add(See(boxes, {x_m, 1.0, 0.0}), match);
  }

 private:
  ChangeFinder& finder_;
  std::int64_t utime_ = 0;
};

bool IsAtTable(const MapChange& change) {
  return std::abs(change.middle.x_m - 3.3) < 0.3 && std::abs(change.middle.y_m - 2.75) < 0.3;
}

}  // namespace

TEST_CASE("where nothing has changed, nothing is found") {
  for (const std::vector<Box>& boxes : {std::vector<Box>{kRoom}, {kRoom, kTable}}) {
    const ByteMap map = MakeMap(boxes);
    ChangeFinder finder(map);
    Drive(finder).Along(boxes);
    CHECK(finder.Find().empty());
  }
}

TEST_CASE("a table that has come is new, with its size, its place, when it was first seen and from how many places") {
  const ByteMap map = MakeMap({kRoom});
  ChangeFinder finder(map);
  Drive drive(finder);
  drive.Along({kRoom}, 0.5, 2.0);
  CHECK(finder.Find().empty());
  drive.Along({kRoom, kTable});
  const std::vector<MapChange> changes = finder.Find();
  REQUIRE(changes.size() == 1);
  CHECK(changes[0].kind == ChangeKind::kNew);
  CHECK(IsAtTable(changes[0]));
  CHECK(changes[0].length_m == Approx(0.6).margin(0.11));  // a cell at each end
  CHECK(changes[0].first_utime == 9'000'000);              // after eight scans without it
  CHECK(changes[0].num_places >= 6);                       // 5 m, each 0.5 m
  CHECK(changes[0].num_places <= 11);
}

TEST_CASE("a table that is no longer there has gone") {
  const ByteMap map = MakeMap({kRoom, kTable});
  ChangeFinder finder(map);
  Drive(finder).Along({kRoom});
  const std::vector<MapChange> changes = finder.Find();
  REQUIRE(changes.size() == 1);
  CHECK(changes[0].kind == ChangeKind::kGone);
  CHECK(IsAtTable(changes[0]));
  CHECK(changes[0].area_m2() == Approx(0.3).margin(0.13));
  CHECK(LargestArea(changes) == changes[0].area_m2());
}

TEST_CASE("a change is seen from two places at least, and by scans that are not lost") {
  const ByteMap map = MakeMap({kRoom});
  ChangeFinder finder(map);
  Drive drive(finder);
  for (int i = 0; i < 20; ++i) drive.At({kRoom, kTable}, 2.0);
  CHECK(finder.Find().empty());
  drive.state = MatchState::kLost;
  drive.Along({kRoom, kTable});
  CHECK(finder.Find().empty());
}

TEST_CASE("who stands somewhere and walks on is no change, and a door that closes again has not gone") {
  const ByteMap empty = MakeMap({kRoom});
  ChangeFinder person(empty);
  Drive past_person(person);
  past_person.Along({kRoom, kTable});
  CHECK(person.Find().size() == 1);
  past_person.Along({kRoom});
  CHECK(person.Find().empty());

  const ByteMap with_table = MakeMap({kRoom, kTable});
  ChangeFinder door(with_table);
  Drive past_door(door);
  past_door.Along({kRoom});
  CHECK(door.Find().size() == 1);
  past_door.Along({kRoom, kTable});
  past_door.Along({kRoom, kTable});
  CHECK(door.Find().empty());
}

TEST_CASE("what an error of the pose explains is no change, and a ray that is known badly says nothing") {
  const ByteMap map = MakeMap({kRoom, kTable});
  for (const double sigma_m : {0.06, 1.0, 100.0}) {
    ChangeFinder finder(map);
    Drive drive(finder);
    drive.off_m = 0.2;
    drive.sigma_m = sigma_m;
    drive.Along({kRoom, kTable});
    CHECK(finder.Find().empty());
  }
  ChangeFinder finder(map);
  Drive drive(finder);
  drive.off_m = 0.2;
  drive.sigma_m = 0.001;
  drive.Along({kRoom, kTable});
  CHECK_FALSE(finder.Find().empty());
}

TEST_CASE("what the map's own scans contradict is an error of the map, and no change") {
  const ByteMap map = MakeMap({kRoom, kTable});
  ChangeFinder finder(map);
  for (double x = 0.5; x < 5.5; x += 0.3) finder.Learn(See({kRoom}, {x, 1.0, 0.0}), {x, 1.0, 0.0});
  Drive(finder).Along({kRoom});
  CHECK(finder.Find().empty());
}

TEST_CASE("scans without rays, and poses beyond all maps, do no harm") {
  const ByteMap map = MakeMap({kRoom});
  ChangeFinder finder(map);
  finder.Add({}, {});
  for (const double far_m : {1e7, -1e300}) {
    ScanMatch match;
    match.utime = static_cast<std::int64_t>(far_m > 0);
    match.state = MatchState::kOk;
    match.T_map_laser.x_m = far_m;
    finder.Add(See({kRoom}, {1, 1, 0}), match);
  }
  CHECK(finder.Find().empty());
}

TEST_CASE("changes are told in lines, and as comma-separated values") {
  const std::vector<MapChange> changes{{ChangeKind::kNew, {1.0, -2.0}, 0.6, 0.5, 0.25, 7, 3},
                                       {ChangeKind::kGone, {0.0, 0.0}, 0.2, 0.05, 0.0, 8, 2}};
  CHECK(FormatChanges(changes) == std::vector<std::string>{"new: 0.6 x 0.5 m at 1.0, -2.0, seen from 3 places",
                                                           "gone: 0.2 x 0.1 m at 0.0, 0.0, seen from 2 places"});
  CHECK(FormatChanges({}).size() == 1);
  CHECK(FormatChangesCsv(changes) ==
        "kind,x_m,y_m,length_m,width_m,yaw_rad,area_m2,first_utime,places\n"
        "new,1.000,-2.000,0.600,0.500,0.250,0.3000,7,3\n"
        "gone,0.000,0.000,0.200,0.050,0.000,0.0100,8,2\n");
  CHECK(LargestArea({}) == 0.0);
}

}  // namespace crsm
