#include "common/map/map_delta.hpp"

#include "catch.hpp"
#include "common/map/byte_map.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

using Bytes = std::vector<std::uint8_t>;

TileBytes Unexplored() {
  TileBytes cells;
  cells.fill(kUnexploredByte);
  return cells;
}

TileBytes With(TileBytes cells, std::initializer_list<std::size_t> places, std::uint8_t byte) {
  for (const std::size_t place : places) cells[place] = byte;
  return cells;
}

}  // namespace

TEST_CASE("a tile packs into runs of its changed cells: place, count and bytes, with gaps of up to four cells") {
  const auto Pack = [](std::initializer_list<std::size_t> places) {
    return PackRuns(Unexplored(), With(Unexplored(), places, 9));
  };
  CHECK(Pack({}).empty());
  CHECK(Pack({300}) == Bytes{1, 44, 0, 1, 9});                   // 300 = 256 + 44
  CHECK(Pack({2, 20}) == Bytes{0, 2, 0, 1, 9, 0, 17, 0, 1, 9});  // skips from the end of the first
  CHECK(Pack({0, 5}) == Bytes{0, 0, 0, 6, 9, 127, 127, 127, 127, 9});
  CHECK(Pack({0, 6}) == Bytes{0, 0, 0, 1, 9, 0, 5, 0, 1, 9});
  for (std::size_t step = 1; step <= 6; ++step) {
    TileBytes cells = Unexplored();
    for (std::size_t i = 0; i < kTileCells; i += step) cells[i] = 7;
    const Bytes runs = PackRuns(Unexplored(), cells);
    CHECK(runs.size() <= kMaxRunBytes);
    if (step == 1) CHECK(Bytes(runs.begin(), runs.begin() + 5) == Bytes{0, 0, 16, 0, 7});
  }
}

TEST_CASE("what is packed unpacks to the same tile and is never larger than a whole one") {
  Random random(1);
  for (const double share : {0.0, 0.0005, 0.01, 0.1, 0.2, 0.5, 0.99}) {
    TileBytes before;
    TileBytes after;
    for (std::size_t i = 0; i < kTileCells; ++i) {
      before[i] = static_cast<std::uint8_t>(random.Next());
      after[i] = random.Uniform(0.0, 1.0) < share ? static_cast<std::uint8_t>(random.Next()) : before[i];
    }
    const Bytes runs = PackRuns(before, after);
    CAPTURE(share);
    CHECK(runs.size() <= kMaxRunBytes);
    CHECK(UnpackRuns(runs, before));
    CHECK(before == after);
  }
}

TEST_CASE("malformed runs are refused and leave the tile as it was") {
  const std::vector<Bytes> malformed{
      {0},                                 // a header cut short
      {0, 0, 0},                           //
      {0, 0, 0, 1},                        // no cells
      {0, 0, 0, 2, 9},                     // one cell too few
      {0, 0, 0, 0},                        // a run of none
      {0, 0, 0, 1, 9, 7},                  // bytes left over
      {16, 0, 0, 1, 9},                    // begins behind the last cell
      {15, 255, 0, 2, 9, 9},               // ends behind it
      {255, 255, 255, 255, 9},             //
      {15, 255, 0, 1, 9, 0, 0, 0, 1, 9},   // the second begins behind it
      {0, 0, 0, 1, 9, 255, 255, 0, 1, 9},  //
  };
  for (const Bytes& runs : malformed) {
    TileBytes cells = Unexplored();
    CHECK_FALSE(UnpackRuns(runs, cells));
    CHECK(cells == Unexplored());
    ByteMap map(0.05);
    CHECK_FALSE(map.Apply({{0, 0}, runs}));
    CHECK(map.tiles().entries().empty());
  }
}

TEST_CASE("the changed cells of a tile are the rectangle around its runs") {
  const TileBytes before = Unexplored();
  TileBytes after = before;
  const auto Changed = [&] { return FindChangedCells({{-2, 1}, PackRuns(before, after)}); };
  const auto Change = [&](int x, int y) { after[static_cast<std::size_t>(OffsetInTile({x, y}))] = 7; };
  Change(5, 9);
  CHECK(Changed() == CellRectangle{{-128 + 5, 64 + 9}, {-128 + 5, 64 + 9}});
  Change(3, 20);
  Change(40, 11);
  CHECK(Changed() == CellRectangle{{-128 + 3, 64 + 9}, {-128 + 40, 64 + 20}});
  Change(63, 10);
  Change(0, 11);  // one run with the last, over the end of a row
  CHECK(Changed() == CellRectangle{{-128, 64 + 9}, {-128 + 63, 64 + 20}});
  after.fill(7);
  CHECK(Changed() == CellsOf({-2, 1}));
}

}  // namespace crsm
