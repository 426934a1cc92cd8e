#include "common/map/blend_cells.hpp"

#include <array>
#include <cmath>

#include "catch.hpp"
#include "common/map/dense_grid.hpp"
#include "common/map/tile_grid.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

struct Cells {
  std::array<std::uint8_t, kTileCells> marks{};
  std::array<float, kTileCells> p_free;
  std::array<std::uint8_t, kTileCells> bytes;

  Cells() {
    p_free.fill(0.5f);
    bytes.fill(kUnexploredByte);
  }
  friend bool operator==(const Cells&, const Cells&) = default;

  /// Whole stretches without a mark, and marks of all kinds.
  void Mark(std::uint64_t seed) {
    Random random(seed);
    for (std::size_t i = 0; i < marks.size(); ++i) {
      const std::uint64_t kind = i / 100 % 3 == 0 ? 0 : random.Next() % 4;
      marks[i] = kind == 0   ? std::uint8_t{0}
                 : kind == 1 ? kFreeMark
                 : kind == 2 ? kOccupiedMark
                             : static_cast<std::uint8_t>(random.Next() % 256);
    }
  }
};

}  // namespace

TEST_CASE("all kernels blend alike, bit by bit") {
  Cells first;
  for (const BlendKernel kernel : FindBlendKernels()) {
    Cells cells;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      cells.Mark(seed);
      kernel({0.1f, 0.17f, 0.6f}, cells.marks.data(), cells.p_free.data(), cells.bytes.data());
      REQUIRE(cells.marks == std::array<std::uint8_t, kTileCells>{});
    }
    if (kernel == FindBlendKernels().front()) first = cells;
    CHECK(cells == first);
  }
}

TEST_CASE("a cell goes towards the share of it that is free, by an intensity that its obstacle decides") {
  for (const BlendKernel kernel : FindBlendKernels()) {
    Cells cells;
    cells.bytes.fill(128);  // explored
    cells.p_free.fill(0.6f);
    cells.marks[7] = kFreeMark;
    cells.marks[8] = kOccupiedMark;
    cells.marks[4095] = 51;  // a fifth
    kernel({0.1f, 0.2f, 0.6f}, cells.marks.data(), cells.p_free.data(), cells.bytes.data());
    const auto IsByteOf = [&](std::size_t i, double p_free) {
      CHECK(std::abs(cells.p_free[i] - p_free) < 1e-6);
      CHECK(cells.bytes[i] == static_cast<int>(255.0 * p_free + 0.5));
    };
    IsByteOf(7, 0.6 + 0.1 * 0.4);
    IsByteOf(8, 0.6 - 0.2 * 0.6);
    IsByteOf(4095, 0.6 + 0.12 * 0.2);
    CHECK(cells.p_free[9] == 0.6f);
    CHECK(cells.bytes[9] == 128);
  }
}

TEST_CASE("a cell that is seen for the first time is believed more readily, and none becomes unexplored again") {
  for (const BlendKernel kernel : FindBlendKernels()) {
    Cells cells;
    cells.marks[0] = kFreeMark;
    cells.p_free[1] = 0.499f;  // whose byte would be 127
    cells.bytes[1] = 120;
    cells.marks[1] = kFreeMark;
    kernel({0.001f, 0.001f, 0.6f}, cells.marks.data(), cells.p_free.data(), cells.bytes.data());
    CHECK(cells.p_free[0] == Approx(0.8));
    CHECK(cells.bytes[0] == 204);
    CHECK(cells.bytes[1] == 126);
  }
}

}  // namespace crsm
