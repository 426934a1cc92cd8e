#include "common/map/map_updater.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

// From 0.5 with intensity 0.1 and Dens_occu 2: 0.5 + 0.5 * 0.1 and 0.5 - 0.5 * 0.2, in 255ths.
constexpr int kFreeOnce = 140;
constexpr int kOccupiedOnce = 102;

/// A map and the replica that its deltas make.
class TestMap {
 public:
  explicit TestMap(MapUpdater drawn_by = PlainUpdater()) : updater(std::move(drawn_by)), bytes(0.05) {}
  explicit TestMap(const DrawingConstants& constants)
      : TestMap(MapUpdater(DrawingRules(TestParameters().update, constants))) {}

  MapDelta Draw(const LaserScan& scan, const Pose2& T_map_laser = {}, MatchState state = MatchState::kOk) {
    const CriticalRays rays = AllRays(scan);
    MapDelta delta = updater.Update(rays, {scan.utime, T_map_laser, 1.0, 1, 1, updater.version(), state});
    for (const TileChange& change : delta.tiles) REQUIRE(bytes.Apply(change));
    return delta;
  }
  int At(int x, int y) const { return bytes.At({x, y}); }

  /// Whether all tiles, whole, make the map that the deltas made.
  void CheckWholeTiles() const {
    ByteMap replica(0.05);
    for (std::size_t tile = 0; tile < updater.num_tiles(); ++tile) {
      const auto whole = updater.TileSince(tile, 0);
      REQUIRE((whole && replica.Apply(*whole)));
    }
    CHECK(replica.ToDenseGrid().cells == bytes.ToDenseGrid().cells);
  }

  MapUpdater updater;
  ByteMap bytes;
};

/// With the plain updater's intensity and density: a hit occupies one cell or more, whole.
constexpr DrawingConstants kPlain{
    .occupied_density = 2.0, .intensity_min = 0.1, .intensity_max = 0.1, .first_intensity = 0.0, .hit_spread = 4.0};

DrawingConstants Spreading(double hit_spread, double occupied_density = kPlain.occupied_density) {
  DrawingConstants constants = kPlain;
  constants.hit_spread = hit_spread;
  constants.occupied_density = occupied_density;
  return constants;
}

LaserScan Beam(float range_m, float angle_rad = 0.0f) { return {1, angle_rad, 0.01f, {range_m}}; }

// Off the sides of cells, so that rounding decides nothing.
constexpr Pose2 kInCell{0.02, 0.02, 0.0};

}  // namespace

TEST_CASE("a beam frees the cells on its way and occupies the one in which it ends") {
  TestMap map;
  const MapDelta delta = map.Draw(Beam(1.0f), kInCell);
  for (int x = 0; x < 20; ++x) CHECK(map.At(x, 0) == kFreeOnce);
  CHECK(map.At(20, 0) == kOccupiedOnce);
  for (const auto& [x, y] : {Cell{-1, 0}, {21, 0}, {5, 1}, {5, -1}}) CHECK(map.At(x, y) == kUnexploredByte);
  CHECK(delta.version == 1);
  CHECK(delta.tiles.size() == 1);
}

TEST_CASE("a beam visits the cells that its line crosses and no others") {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    TestMap map;
    const Pose2 pose{random.Uniform(-2.0, 2.0), random.Uniform(-2.0, 2.0), random.Uniform(-kPi, kPi)};
    const double range_m = random.Uniform(0.1, 3.0);
    map.Draw(Beam(static_cast<float>(range_m)), pose);
    const Eigen::Vector2d way(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
    std::set<std::pair<int, int>> crossed;
    for (double m = 0.0; m < range_m; m += 1e-4) {
      crossed.insert({static_cast<int>(std::floor((pose.x_m + m * way.x()) / 0.05)),
                      static_cast<int>(std::floor((pose.y_m + m * way.y()) / 0.05))});
    }
    for (const auto& [x, y] : crossed) CHECK(map.At(x, y) != kUnexploredByte);
    const DenseGrid grid = map.bytes.ToDenseGrid();
    const auto num_explored =
        grid.cells.size() - static_cast<std::size_t>(std::count(grid.cells.begin(), grid.cells.end(), kUnexploredByte));
    CHECK(num_explored <= crossed.size() + 2);  // corners cut by less than the 0.1 mm of this test
    CHECK(std::count(grid.cells.begin(), grid.cells.end(), kOccupiedOnce) == 1);
  }
}

TEST_CASE("each cell is updated once a scan, however many beams cross it") {
  TestMap map;
  map.Draw(ScanRoom(kInCell), kInCell);
  CHECK(map.At(0, 0) == kFreeOnce);
  CHECK(map.At(3, 2) == kFreeOnce);
  const DenseGrid grid = map.bytes.ToDenseGrid();
  for (const int byte : grid.cells) REQUIRE((byte == kFreeOnce || byte == kOccupiedOnce || byte == kUnexploredByte));
}

TEST_CASE("an occupied cell wins over a free one within a scan") {
  for (const auto& ranges_m : {std::vector<float>{3.0f, 1.0f}, {1.0f, 3.0f}}) {
    TestMap map;
    map.Draw({1, 0.0f, 0.001f, ranges_m}, kInCell);
    CHECK(map.At(20, 0) == kOccupiedOnce);
    CHECK(map.At(30, 0) == kFreeOnce);
  }
}

TEST_CASE("cells follow the asymptotic rule of the paper; ours makes the first update of a cell more intense") {
  DrawingConstants first_more = kPlain;
  first_more.first_intensity = 0.6;
  DrawingConstants denser = first_more;
  denser.occupied_density = 8.0;  // more intense than the first one has to be
  struct Case {
    TestMap map;
    double first_free, first_occupied, then_free, then_occupied;  ///< intensities
  };
  Case cases[] = {{TestMap(PlainUpdater(TestParameters().update, {3.0, 0.07, 0.07})), 0.07, 0.21, 0.07, 0.21},
                  {TestMap(first_more), 0.6, 0.6, 0.1, 0.2},
                  {TestMap(denser), 0.6, 0.8, 0.1, 0.8}};
  for (auto& [map, first_free, first_occupied, then_free, then_occupied] : cases) {
    double free = 0.5;
    double occupied = 0.5;
    for (int scan = 0; scan < 60; ++scan) {
      map.Draw(Beam(1.0f), kInCell);
      free += (1.0 - free) * (scan == 0 ? first_free : then_free);
      occupied -= occupied * (scan == 0 ? first_occupied : then_occupied);
      CHECK(std::abs(map.At(10, 0) - 255.0 * free) <= 0.51);  // rounded, in single precision
      CHECK(std::abs(map.At(20, 0) - 255.0 * occupied) <= 0.51);
    }
  }
}

TEST_CASE("no explored cell has the byte of an unexplored one") {
  TestMap map(
      PlainUpdater(TestParameters().update, {1.0, 0.001, 0.001}));  // 0.5 +- 0.0005 is 127.6 and 127.4 in 255ths
  for (int scan = 0; scan < 300; ++scan) {                          // crosses the middle upwards and downwards
    map.Draw(Beam(scan < 20 || scan > 100 ? 1.0f : 2.0f), kInCell);
    REQUIRE(map.At(10, 0) != kUnexploredByte);
    REQUIRE(map.At(20, 0) != kUnexploredByte);
  }
}

TEST_CASE("the intensity of the update is the scan's mean sparseness") {
  TestMap map(PlainUpdater(TestParameters().update, {}));
  map.Draw({1, 0.0f, 0.05f, std::vector<float>(60, 2.0f)}, kInCell);  // chord: 4 sin(0.025) = 0.1
  CHECK(map.At(10, 0) == kFreeOnce);
  TestMap sparser(PlainUpdater(TestParameters().update, {}));
  sparser.Draw({1, 0.0f, 0.075f, std::vector<float>(40, 2.0f)}, kInCell);
  CHECK(sparser.At(10, 0) > kFreeOnce);
}

TEST_CASE("neighbouring hits on one surface become a line where that is wanted") {
  for (const bool join : {false, true}) {
    DrawingConstants constants = kPlain;
    constants.join_max_m = join ? 0.8 : 0.0;
    TestMap map(constants);
    LaserScan scan{1, -0.3f, 0.1f, {}};  // the wall x = 3.001 m, a hit every six cells
    for (int i = 0; i < 7; ++i) scan.ranges_m.push_back(static_cast<float>(2.981 / std::cos(-0.3 + 0.1 * i)));
    map.Draw(scan, kInCell);
    int num_occupied = 0;
    for (int y = -30; y <= 30; ++y) num_occupied += map.At(60, y) == kOccupiedOnce;
    // One of the seven hits lies in the middle between two rows. Joined: from y = 0.02 - 0.922 m to 0.02 + 0.922 m,
    // cells -19 to 18
    CHECK(num_occupied == (join ? 38 : 8));
  }
}

TEST_CASE("behind a surface that is seen fades what was drawn there, and only that") {
  TestMap map(kPlain);
  // A wall across, from both sides of the way to it, so that it is one surface; then the same wall 5 cm nearer.
  const auto Wall = [](float range_m) {
    const float edge_m = range_m / std::cos(0.02f);
    return LaserScan{1, -0.02f, 0.02f, {edge_m, range_m, edge_m}};
  };
  map.Draw(Wall(1.0f), kInCell);
  REQUIRE(map.At(20, 0) == kOccupiedOnce);
  map.Draw(Wall(0.95f), kInCell);
  CHECK(map.At(19, 0) < kUnexploredByte);
  CHECK(map.At(20, 0) > kOccupiedOnce);
  CHECK(map.At(21, 0) == kUnexploredByte);  // nobody has been there
  for (int i = 0; i < 20; ++i) map.Draw(Wall(0.95f), kInCell);
  CHECK(map.At(20, 0) > kUnexploredByte);  // free

  TestMap far(kPlain);  // further behind nothing fades
  far.Draw(Wall(1.0f), kInCell);
  for (int i = 0; i < 20; ++i) far.Draw(Wall(0.8f), kInCell);
  CHECK(far.At(20, 0) == kOccupiedOnce);

  TestMap alone(kPlain);  // nor does it behind a hit of no surface
  alone.Draw(Beam(1.0f), kInCell);
  alone.Draw(Beam(0.95f), kInCell);
  CHECK(alone.At(20, 0) == kOccupiedOnce);
}

TEST_CASE("two hits on one point are a surface without a far side") {  // numbers that are none: for the sanitizers
  TestMap map(kPlain);
  const CriticalRays twice{1, {{0.0f, 0.0f}, {1.0f, 1.0f}}, {0, 1}};
  for (const TileChange& change : map.updater.Update(twice, {1, kInCell, 1.0, 1, 1, 0, MatchState::kOk}).tiles) {
    REQUIRE(map.bytes.Apply(change));
  }
  CHECK(map.At(20, 0) == kOccupiedOnce);
  CHECK(map.At(21, 0) == kUnexploredByte);
}

TEST_CASE("a hit that spreads occupies the cells around it by how near they are") {
  TestMap map(Spreading(1.0, 1.0));
  // It ends 0.3 of the way from the centre of cell (20, 0) to that of (21, 0), and 0.4 from row 0 to row 1.
  map.Draw(Beam(0.985f), {0.055, 0.045, 0.0});
  const auto Once = [](double share) { return 255.0 * (0.5 + 0.1 * (1.0 - share - 0.5)); };
  for (const int x : {20, 21}) {
    for (const int y : {0, 1}) {
      const double share = (x == 20 ? 0.7 : 0.3) * (y == 0 ? 0.6 : 0.4);
      CHECK(std::abs(map.At(x, y) - Once(share)) <= 1.0);
    }
  }
  CHECK(map.At(10, 0) == kFreeOnce);
  for (const auto& [x, y] : {Cell{22, 0}, {21, 2}, {20, -1}, {19, 1}}) CHECK(map.At(x, y) == kUnexploredByte);
}

TEST_CASE("the spread of hits makes up for walls between cells, up to whole cells") {
  TestMap map(Spreading(2.0));
  map.Draw(Beam(1.0f), {0.05, 0.025, 0.0});  // ends between cells 20 and 21
  CHECK(map.At(20, 0) == kOccupiedOnce);
  CHECK(map.At(21, 0) == kOccupiedOnce);
  CHECK(map.At(19, 0) == kFreeOnce);
  CHECK(map.At(22, 0) == kUnexploredByte);
}

TEST_CASE("a wall seen again and again is as strong in a cell as its share there") {
  TestMap map(Spreading(1.0));
  LaserScan scan{1, -0.3f, 0.02f, {}};  // the wall x = 3.04 m, 0.3 of the way from the centre of cell 60 to that of 61
  for (int i = 0; i <= 30; ++i) scan.ranges_m.push_back(static_cast<float>(3.015 / std::cos(-0.3 + 0.02 * i)));
  for (int i = 0; i < 200; ++i) map.Draw(scan, {0.025, 0.025, 0.0});
  for (int y = -10; y <= 10; ++y) {
    CHECK(std::abs(map.At(60, y) - 255 * 0.3) < 255 * 0.12);  // a sample is up to an eighth of a cell off its row
    CHECK(std::abs(map.At(61, y) - 255 * 0.7) < 255 * 0.12);
  }
}

TEST_CASE("every call makes a version, also when nothing changes") {
  TestMap map;
  CHECK(map.updater.version() == 0);
  const MapDelta deltas[] = {map.Draw(Beam(1.0f)), map.Draw(Beam(1.0f), {}, MatchState::kLost),
                             map.Draw({1, 0.0f, 0.1f, {0.0f, 0.0f}}), map.updater.UpdateWithoutScan()};
  for (int i = 0; i < 4; ++i) {
    CHECK(deltas[i].version == i + 1);
    CHECK(deltas[i].tiles.empty() == (i > 0));
  }
  CHECK(map.updater.version() == 4);
  CHECK_THROWS_AS(map.updater.Update(AllRays(Beam(1.0f)), MatchedAt(2, {})), std::invalid_argument);  // of another scan
  CHECK(map.updater.version() == 4);
}

TEST_CASE("a scan is drawn after enough motion or enough turning since the last that was drawn") {
  TestMap map(PlainUpdater({.update_distance_m = 0.2, .update_angle_rad = 0.1}));
  const std::pair<Pose2, bool> poses[] = {{{}, true},
                                          {{0.15, 0.0, 0.0}, false},
                                          {{0.15, 0.15, 0.0}, true},
                                          {{0.15, 0.15, 0.09}, false},
                                          {{0.15, 0.15, 0.11}, true},
                                          {{0.15, 0.15, 0.02}, false},
                                          {{0.15, 0.15, 0.0}, true}};
  for (const auto& [pose, is_drawn] : poses) CHECK(map.Draw(Beam(1.0f), pose).tiles.empty() != is_drawn);
}

TEST_CASE("a scan that reaches beyond the map is answered and not drawn") {
  TestMap map;
  const double limit_m = kMaxCell * 0.05;
  for (const Pose2& pose : {Pose2{limit_m - 0.9, 0.0, 0.0}, {0.0, -limit_m, 0.0}, {1e300, 0.0, 0.0}, {NAN, 0.0, 0.0}}) {
    CHECK(map.Draw(Beam(1.0f), pose).tiles.empty());
  }
  CHECK(map.updater.version() == 4);
  CHECK_FALSE(map.Draw(Beam(1.0f), {limit_m - 1.1, 0.0, 0.0}).tiles.empty());
}

TEST_CASE("what the map has no room for is left out and counted, and mapping goes on") {
  TestMap map;
  map.Draw(Beam(1.0f), {-3000.0, -3000.0, 0.0});
  CHECK(map.updater.num_scans_cut() == 0);
  const MapDelta far = map.Draw(Beam(1.0f), {3000.0, 3000.0, 0.0});
  CHECK(far.version == 2);
  CHECK(far.tiles.empty());
  CHECK(map.updater.num_scans_cut() == 1);
  CHECK(map.updater.num_tiles() == 1);
  CHECK(map.Draw(Beam(1.0f), {-3000.0, -3000.0, 0.0}).tiles.size() == 1);
  CHECK(map.updater.num_scans_cut() == 1);
}

TEST_CASE("a replica that missed versions is healed by whole tiles") {
  TestMap map;
  map.Draw(ScanRoom(kInCell), kInCell);
  const std::int64_t old_version = map.updater.version();
  map.Draw(Beam(1.0f, 0.3f), kInCell);  // changes one tile
  int num_tiles = 0;
  for (std::size_t tile = 0; tile < map.updater.num_tiles(); ++tile) {
    num_tiles += map.updater.TileSince(tile, old_version).has_value();
    CHECK_FALSE(map.updater.TileSince(tile, map.updater.version()));
  }
  CHECK(num_tiles == 1);
  map.CheckWholeTiles();
}

TEST_CASE("drawn anew, the tiles that are not as they were have changed, and no others") {
  TestMap map;
  map.Draw(Beam(1.0f), kInCell);
  map.Draw(Beam(1.0f), {kInCell.x_m + 10.0, kInCell.y_m, 0.0});
  const std::int64_t version = map.updater.UpdateWithoutScan().version;
  map.updater.UpdateWithoutScan();
  const ValidRays rays = AllRays(Beam(1.0f)).rays;
  const PlacedScan first{rays, kInCell};
  const std::vector<TileChange> changes = map.updater.Redraw({&first, 1});
  CHECK(changes.size() == 1);
  for (const TileChange& change : changes) REQUIRE(map.bytes.Apply(change));
  CHECK(map.At(5, 0) == kFreeOnce);
  CHECK(map.At(205, 0) == kUnexploredByte);
  CHECK_FALSE(map.updater.TileSince(0, version));
  CHECK(map.updater.TileSince(1, version));
  CHECK(map.updater.Redraw({&first, 1}).empty());
}

TEST_CASE("a map that takes the place of another one gives the same, and says what that changes") {
  UpdateParameters parameters = TestParameters().update;
  parameters.update_distance_m = 0.1;
  parameters.update_angle_rad = 1.0;
  TestMap map(PlainUpdater(parameters));
  map.Draw(Beam(1.0f), kInCell);
  map.Draw(Beam(1.0f), {kInCell.x_m + 10.0, kInCell.y_m, 0.0});
  map.Draw(Beam(1.0f), {kInCell.x_m + 20.0, kInCell.y_m, 0.0});
  const std::int64_t version = map.updater.UpdateWithoutScan().version;
  map.updater.UpdateWithoutScan();
  const ValidRays rays = AllRays(Beam(1.0f)).rays;
  const Pose2 turned{kInCell.x_m + 10.0, kInCell.y_m, 0.3};
  const Pose2 new_place{kInCell.x_m - 10.0, kInCell.y_m, 0.0};
  MapUpdater other = PlainUpdater();
  for (const Pose2& place : {turned, kInCell, new_place}) other.DrawMore({rays, place});
  ByteMap expected(0.05);
  for (std::size_t tile = 0; tile < other.num_tiles(); ++tile) REQUIRE(expected.Apply(*other.TileSince(tile, -1)));

  const std::vector<TileChange> changes = map.updater.Replace(std::move(other), new_place);
  for (const TileChange& change : changes) REQUIRE(map.bytes.Apply(change));
  CHECK(map.bytes.ToDenseGrid().cells == expected.ToDenseGrid().cells);
  CHECK(map.updater.version() == version + 1);
  map.CheckWholeTiles();
  CHECK_FALSE(map.updater.TileSince(0, version));  // is as it was
  for (const std::size_t tile : {1, 2, 3}) CHECK(map.updater.TileSince(tile, version));
  // The next scan is drawn if it is far enough from the last one of that map.
  CHECK_FALSE(map.Draw(Beam(1.0f), new_place).drawn);
  CHECK(map.Draw(Beam(1.0f), kInCell).drawn);
  map.CheckWholeTiles();
}

TEST_CASE("a finished map answers and does not change, and its versions start over") {
  TestMap map;
  map.Draw(ScanRoom(kInCell), kInCell);
  map.Draw(Beam(1.0f, 0.3f), kInCell);
  map.updater.Finish();
  CHECK(map.updater.version() == 0);
  for (std::int64_t version = 1; version <= 3; ++version) {
    const MapDelta delta = map.Draw(Beam(2.0f, 0.1f), kInCell);
    CHECK(delta.version == version);
    CHECK(delta.tiles.empty());
  }
  for (std::size_t tile = 0; tile < map.updater.num_tiles(); ++tile) {
    CHECK_FALSE(map.updater.TileSince(tile, 1));  // who holds a version of this epoch has them all
  }
  map.CheckWholeTiles();
}

}  // namespace crsm
