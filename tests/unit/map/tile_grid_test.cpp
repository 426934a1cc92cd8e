#include "common/map/tile_grid.hpp"

#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "catch.hpp"
#include "common/map/map_geometry.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

struct Tile {};

}  // namespace

TEST_CASE("cells left of and below the origin belong to tiles with negative numbers") {
  CHECK(TileOf({0, 0}) == TileIndex{0, 0});
  CHECK(TileOf({63, 64}) == TileIndex{0, 1});
  CHECK(TileOf({-1, -64}) == TileIndex{-1, -1});
  CHECK(TileOf({-65, 128}) == TileIndex{-2, 2});
}

TEST_CASE("every cell of a tile has a place of its own, row by row from the lower left, and is found again by it") {
  int offset = 0;
  for (int y = -64; y < 0; ++y) {
    for (int x = -64; x < 0; ++x) REQUIRE(OffsetInTile({x, y}) == offset++);
  }
  for (const Cell cell : {Cell{0, 0}, {63, 64}, {-1, -64}, {-65, 127}, {-kMaxCell, kMaxCell - 1}}) {
    CHECK(CellAt(TileOf(cell), OffsetInTile(cell)) == cell);
  }
}

TEST_CASE("a rectangle grows to hold a tile, and what it held; what lies beyond has a place of its own") {
  TileRectangle rectangle;
  CHECK(rectangle.num_places() == 1);
  CHECK(rectangle.Place({3, 4}) == 0);
  for (const TileIndex index : {TileIndex{3, 4}, {-20, 5}, {40, -7}}) {
    CHECK_FALSE(rectangle.Contains(index));
    const TileRectangle before = rectangle;
    rectangle = rectangle.GrownTo(index);
    CHECK(rectangle.Contains(index));
    if (before.width > 0) CHECK(rectangle.Contains(before.origin));
  }
  std::set<std::size_t> places;
  for (int y = 0; y < static_cast<int>(rectangle.height); ++y) {
    for (int x = 0; x < static_cast<int>(rectangle.width); ++x) {
      places.insert(rectangle.Place({rectangle.origin.x + x, rectangle.origin.y + y}));
    }
  }
  CHECK(places.size() == std::size_t{rectangle.width} * rectangle.height);
  CHECK(*places.rbegin() < rectangle.num_places());
  for (const TileIndex beyond : {TileIndex{-1000, 4}, {3, 1000}, {1000, -1000}, {rectangle.origin.x - 1, 0}}) {
    CHECK_FALSE(rectangle.Contains(beyond));
    CHECK(rectangle.Place(beyond) < rectangle.num_places());
    CHECK(places.count(rectangle.Place(beyond)) == 0);
  }
}

TEST_CASE(
    "a grid grows in any direction, a few times, and loses nothing; its entries stand in the order they came in") {
  TileGrid<Tile> grid;
  std::map<TileIndex, Tile*> reference;
  std::vector<TileIndex> order;
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const TileIndex index{static_cast<int>(random.Uniform(-60.0, 60.0)), static_cast<int>(random.Uniform(-60.0, 60.0))};
    CHECK((grid.Find(index) != nullptr) == reference.contains(index));
    Tile& tile = grid.Touch(index);
    const auto [known, is_new] = reference.emplace(index, &tile);
    CHECK(known->second == &tile);
    if (is_new) order.push_back(index);
  }
  REQUIRE(grid.entries().size() == order.size());
  for (std::size_t i = 0; i < order.size(); ++i) CHECK(grid.entries()[i].index == order[i]);
  int num_wrong = 0;
  for (int y = -70; y < 70; ++y) {
    for (int x = -70; x < 70; ++x) {
      const auto found = reference.find({x, y});
      num_wrong += grid.Find({x, y}) != (found == reference.end() ? nullptr : found->second);
    }
  }
  CHECK(num_wrong == 0);
  TileRectangle rectangle;
  int num_changes = 0;
  for (int reach = 0; reach < 128; ++reach) {
    for (const TileIndex index : {TileIndex{reach, reach}, {-reach, -reach}, {reach, -reach}}) {
      num_changes += !rectangle.Contains(index);
      if (!rectangle.Contains(index)) rectangle = rectangle.GrownTo(index);
      REQUIRE(rectangle.Contains(index));
    }
  }
  CHECK(num_changes < 20);                        // 1.5^14 = 292 tiles a side, the first steps being longer
  CHECK(rectangle.num_places() < 4 * 255 * 255);  // each side is less than twice as long as it has to be
}

TEST_CASE("the grid ends at the limits of the map") {
  TileGrid<Tile> grid;
  Tile& low = grid.Touch({-kMaxTile, -kMaxTile});
  Tile& high = grid.Touch({kMaxTile - 1, kMaxTile - 1});
  CHECK(grid.Find({-kMaxTile, -kMaxTile}) == &low);
  CHECK(grid.Find({kMaxTile - 1, kMaxTile - 1}) == &high);
  for (const TileIndex beyond : {TileIndex{kMaxTile, 0}, {-kMaxTile - 1, 0}, {0, kMaxTile}, {0, -kMaxTile - 1}}) {
    CHECK_THROWS_AS(grid.Touch(beyond), std::out_of_range);
    CHECK(grid.Find(beyond) == nullptr);
    CHECK_FALSE(InMapLimits(beyond));
  }
  CHECK(InMapLimits(Cell{-kMaxCell, kMaxCell - 1}));
  CHECK_FALSE(InMapLimits(Cell{kMaxCell, 0}));
}

TEST_CASE("a grid has room for so many tiles, and for those that it has") {
  TileGrid<Tile> grid;
  constexpr int kSide = 128;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      REQUIRE(grid.HasRoomFor({x, y}));
      grid.Touch({x, y});
    }
  }
  REQUIRE(grid.entries().size() == kMostTiles);
  CHECK(grid.HasRoomFor({0, 0}));
  CHECK(grid.HasRoomFor({kSide - 1, kSide - 1}));
  CHECK_FALSE(grid.HasRoomFor({kSide, 0}));
}

TEST_CASE("a grid has room in a rectangle of so many tiles, wherever it is and of whatever shape") {
  TileGrid<Tile> grid;
  CHECK(grid.HasRoomFor({-kMaxTile, kMaxTile - 1}));
  CHECK_FALSE(grid.HasRoomFor({-kMaxTile - 1, 0}));
  grid.Touch({-5, 7});
  for (const TileIndex corner : {TileIndex{-5 + 255, 7 + 255}, {-5 - 255, 7 - 255}, {-5 + 511, 7 - 127}}) {
    CHECK(grid.HasRoomFor(corner));
  }
  for (const TileIndex corner : {TileIndex{-5 + 256, 7 + 255}, {-5 - 255, 7 - 256}, {-kMaxTile, kMaxTile - 1}}) {
    CHECK_FALSE(grid.HasRoomFor(corner));
  }
  grid.Touch({-5 + 255, 7 + 255});
  CHECK(grid.HasRoomFor({-5, 7 + 255}));
  CHECK_FALSE(grid.HasRoomFor({-6, 7}));
}

TEST_CASE("a point belongs to the cell whose lower left corner is before it") {
  const MapGeometry geometry(0.05);
  CHECK(geometry.CellAt(0.0, 0.0) == Cell{0, 0});
  CHECK(geometry.CellAt(0.049, -0.001) == Cell{0, -1});
  CHECK(geometry.CellAt(-0.051, 1.001) == Cell{-2, 20});
  CHECK(geometry.ToCells(0.125) == Approx(2.5));
  for (const double far_m : {4000.0, -4000.0, 1e6, -3e6, HUGE_VAL}) CHECK_FALSE(InMapLimits(geometry.CellAt(0, far_m)));
}

TEST_CASE("a point near the limits of the map is within them with its reach or not at all") {
  const MapGeometry geometry(0.05);
  const double limit_m = 65536 * 0.05;
  CHECK(geometry.InLimits(limit_m - 10.1, 0.0, 10.0));
  CHECK_FALSE(geometry.InLimits(limit_m - 9.9, 0.0, 10.0));
  CHECK_FALSE(geometry.InLimits(0.0, 9.9 - limit_m, 10.0));
  CHECK_FALSE(geometry.InLimits(std::nan(""), 0.0, 10.0));
}

}  // namespace crsm
