#include "common/map/byte_map.hpp"

#include <vector>

#include "catch.hpp"

namespace crsm {
namespace {

using Bytes = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("a map is unexplored until a change comes or a cell is set, and then only there") {
  ByteMap changed(0.05);
  CHECK(changed.At({0, 0}) == kUnexploredByte);
  CHECK(changed.Apply({{-2, 1}, {0, 65, 0, 1, 9}}));  // cell (1, 1) of the tile
  ByteMap set(0.1);
  CHECK(set.geometry().cell_size_m() == 0.1);
  CHECK(set.Set({-127, 65}, 9));
  for (const ByteMap* map : {&changed, &set}) {
    CHECK(map->At({-127, 65}) == 9);
    CHECK(map->At({-126, 65}) == kUnexploredByte);
    CHECK(map->At({127, 65}) == kUnexploredByte);
  }
}

TEST_CASE("what is beyond the limits, or so far away that the rectangle around the map has no room, is refused") {
  ByteMap map(0.05);
  const std::vector<std::uint8_t> one_cell{0, 0, 0, 1, 9};
  for (const TileIndex beyond : {TileIndex{kMaxTile, 0}, {0, -kMaxTile - 1}})
    CHECK_FALSE(map.Apply({beyond, one_cell}));
  CHECK_FALSE(map.Set({kMaxCell, 0}, 9));
  CHECK(map.Apply({{-kMaxTile, -kMaxTile}, one_cell}));
  CHECK_FALSE(map.Apply({{kMaxTile - 1, kMaxTile - 1}, one_cell}));
  CHECK_FALSE(map.Set({kMaxCell - 1, kMaxCell - 1}, 9));
  CHECK(map.Apply({{-kMaxTile + 1, -kMaxTile}, one_cell}));
  CHECK(map.tiles().entries().size() == 2);
  CHECK(map.ToDenseGrid().cells.size() == kTileSide + 1);
}

TEST_CASE("a change that changes nothing makes no tile, and an unexplored map is a grid without cells") {
  ByteMap map(0.05);
  CHECK(map.Apply({{3, 4}, {}}));
  CHECK(map.tiles().entries().empty());
  CHECK(map.Apply({{0, 0}, {0, 0, 0, 1, kUnexploredByte}}));
  const DenseGrid grid = map.ToDenseGrid();
  CHECK((grid.width_cells == 0 && grid.height_cells == 0 && grid.cells.empty()));
  CHECK(grid.cell_size_m == 0.05);
}

TEST_CASE("a tile in which nothing is explored any more is no longer there, and can come again") {
  ByteMap map(0.05);
  for (const TileIndex index : {TileIndex{0, 0}, {1, 0}, {2, 0}}) CHECK(map.Apply({index, {0, 7, 0, 1, 9}}));
  CHECK(map.Apply({{1, 0}, {0, 7, 0, 1, kUnexploredByte}}));
  CHECK(map.tiles().entries().size() == 2);
  CHECK(map.tiles().Find({1, 0}) == nullptr);
  CHECK(map.At({2 * kTileSide + 7, 0}) == 9);
  CHECK(map.Apply({{1, 0}, {0, 8, 0, 1, 5}}));
  CHECK(map.At({kTileSide + 7, 0}) == kUnexploredByte);
  CHECK(map.At({kTileSide + 8, 0}) == 5);
}

TEST_CASE("a dense grid is the rectangle around the explored cells, row by row from the lower left") {
  ByteMap map(0.1);
  CHECK(map.Apply({{-1, -1}, {15, 255, 0, 1, 5}}));  // cell (-1, -1)
  CHECK(map.Apply({{0, 0}, {0, 66, 0, 1, 6}}));      // cell (2, 1)
  const DenseGrid grid = map.ToDenseGrid();
  CHECK(grid.origin_x_cells == -1);
  CHECK(grid.origin_y_cells == -1);
  CHECK(grid.width_cells == 4);
  CHECK(grid.height_cells == 3);
  CHECK(grid.cells == Bytes{5, 127, 127, 127, 127, 127, 127, 127, 127, 127, 127, 6});
}

}  // namespace crsm
