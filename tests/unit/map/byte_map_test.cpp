#include "common/map/byte_map.hpp"

#include <vector>

#include "catch.hpp"

namespace crsm {
namespace {

using Bytes = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("a map is unexplored until a change comes, and then only there") {
  ByteMap map(0.05);
  CHECK(map.At({0, 0}) == kUnexploredByte);
  CHECK(map.Apply({{-2, 1}, {0, 65, 0, 1, 9}}));  // cell (1, 1) of the tile
  CHECK(map.At({-127, 65}) == 9);
  CHECK(map.At({-126, 65}) == kUnexploredByte);
  CHECK(map.At({127, 65}) == kUnexploredByte);
}

TEST_CASE("a change beyond the limits of the map is refused") {
  ByteMap map(0.05);
  CHECK_FALSE(map.Apply({{kMaxTile, 0}, {0, 0, 0, 1, 9}}));
  CHECK_FALSE(map.Apply({{0, -kMaxTile - 1}, {0, 0, 0, 1, 9}}));
  CHECK(map.Apply({{-kMaxTile, kMaxTile - 1}, {0, 0, 0, 1, 9}}));
}

TEST_CASE("a tile so far away that the rectangle around the map would not fit into memory is refused") {
  ByteMap map(0.05);
  CHECK(map.Apply({{-kMaxTile, -kMaxTile}, {0, 0, 0, 1, 9}}));
  CHECK_FALSE(map.Apply({{kMaxTile - 1, kMaxTile - 1}, {0, 0, 0, 1, 9}}));
  CHECK(map.Apply({{-kMaxTile + 1, -kMaxTile}, {0, 0, 0, 1, 9}}));
  CHECK(map.tiles().entries().size() == 2);
  CHECK(map.ToDenseGrid().cells.size() == kTileSide + 1);
}

TEST_CASE("a change that changes nothing makes no tile") {
  ByteMap map(0.05);
  CHECK(map.Apply({{3, 4}, {}}));
  CHECK(map.tiles().entries().empty());
}

TEST_CASE("an unexplored map is a grid without cells") {
  ByteMap map(0.05);
  CHECK(map.ToDenseGrid().cells.empty());
  CHECK(map.Apply({{0, 0}, {0, 0, 0, 1, kUnexploredByte}}));
  const DenseGrid grid = map.ToDenseGrid();
  CHECK(grid.width_cells == 0);
  CHECK(grid.height_cells == 0);
  CHECK(grid.cells.empty());
  CHECK(grid.cell_size_m == 0.05);
}

TEST_CASE("a cell that is set is there, and one that there is no room for is refused") {
  ByteMap map(0.1);
  CHECK(map.Set({-127, 65}, 9));
  CHECK(map.At({-127, 65}) == 9);
  CHECK(map.At({-126, 65}) == kUnexploredByte);
  CHECK_FALSE(map.Set({kMaxCell, 0}, 9));
  CHECK_FALSE(map.Set({kMaxCell - 1, kMaxCell - 1}, 9));  // the rectangle around both would not fit into memory
  CHECK(map.tiles().entries().size() == 1);
  CHECK(map.geometry().cell_size_m() == 0.1);
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
