#include "common/match/fit/fitness_field.hpp"

#include <unistd.h>

#include <cmath>
#include <fstream>

#include "catch.hpp"
#include "common/match/fit/fitness_derivatives.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/math/random.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

const MapGeometry kGeometry(0.05);

/// A pseudo-random byte for each cell, a fifth of them unexplored.
std::uint8_t Noise(Cell cell) {
  const auto hash = Random(1, static_cast<std::uint64_t>(cell.x) << 32 ^ static_cast<std::uint32_t>(cell.y)).Next();
  return hash % 5 == 0 ? kUnexploredByte : static_cast<std::uint8_t>(hash >> 8);
}

template <class Paint>
ByteMap Map(Paint&& paint) {
  return PaintMap(-2, 1, paint);
}

std::vector<TileIndex> AllTiles(const ByteMap& map) {
  std::vector<TileIndex> tiles;
  for (const auto& entry : map.tiles().entries()) tiles.push_back(entry.index);
  return tiles;
}

/// Of this process.
double ResidentMb() {
  double all = 0.0;
  double resident = 0.0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

FitnessField Field(const ByteMap& map, double unexplored_score, bool interpolate) {
  FitnessField field(map.geometry(), {unexplored_score, interpolate});
  field.Refresh(map, AllTiles(map));
  return field;
}

/// Changes a tile of a map, and tells a field that follows it.
template <class Paint>
void PaintOver(ByteMap& map, FitnessField& field, TileIndex index, Paint&& paint) {
  TileBytes before = kUnexploredBytes;
  if (const ByteMap::Tile* tile = map.tiles().Find(index)) before = tile->cells;
  TileBytes after;
  for (int k = 0; k < kTileCells; ++k) after[static_cast<std::size_t>(k)] = paint(CellAt(index, k));
  REQUIRE(map.Apply({index, PackRuns(before, after)}));
  field.RefreshCells(map, {CellsOf(index)});
}

/// Rays of up to `reach_m` to all sides.
Eigen::Matrix2Xd DrawHits(int num_rays, double reach_m, std::uint64_t seed) {
  Random random(seed);
  Eigen::Matrix2Xd hits_m(2, num_rays);
  for (int i = 0; i < num_rays; ++i)
    hits_m.col(i) << random.Uniform(-reach_m, reach_m), random.Uniform(-reach_m, reach_m);
  return hits_m;
}

/// Rays to all sides, and to both sides of the corners of a tile in whose middle the laser stands.
Eigen::Matrix2Xd DrawHitsOverCorners(int num_rays, std::uint64_t seed) {
  constexpr double kHalf_m = 0.05 * kTileSide / 2;
  constexpr double kBeside_m = 0.01;  // less than half a cell: the scores of all tiles that meet there count
  Eigen::Matrix2Xd hits_m(2, num_rays + 16);
  hits_m.leftCols(num_rays) = DrawHits(num_rays, kHalf_m + 0.1, seed);
  for (int i = 0; i < 16; ++i) {
    const auto Side = [&](int bit, int inside_bit) {
      return (i >> bit & 1 ? kHalf_m : -kHalf_m) + (i >> inside_bit & 1 ? kBeside_m : -kBeside_m);
    };
    hits_m.col(num_rays + i) << Side(0, 1), Side(2, 3);
  }
  return hits_m;
}

/// A ray that ends there, in cells, if the laser is at the origin.
RaysInCells OneRay(float x, float y) {
  return {Eigen::ArrayXf::Constant(1, x), Eigen::ArrayXf::Constant(1, y), Eigen::ArrayXi::Ones(1)};
}

/// A ray that ends somewhere around a point of the 1/128 lattice [cells], where no other is nearer.
RaysInCells OneRayAround(double x, double y, Random& random) {
  const auto Around = [&](double cells) { return static_cast<float>(cells + random.Uniform(-0.45, 0.45) / 128.0); };
  const float around_x = Around(x);
  return OneRay(around_x, Around(y));
}

/// Whether two fields give the same fitness, by the bilinear and by the smooth one, and the same derivatives.
bool Alike(const FitnessField& a, const FitnessField& b, const RaysInCells& rays, const Pose2& pose) {
  const FitnessDerivatives of_a = a.Differentiate(rays, pose);
  const FitnessDerivatives of_b = b.Differentiate(rays, pose);
  return a.Evaluate(rays, pose) == b.Evaluate(rays, pose) && of_a.value == of_b.value &&
         of_a.gradient == of_b.gradient && of_a.hessian == of_b.hessian;
}

/// Lines 6 to 10 of section 5.2 for a ray that ends in this cell. unexplored_beside: what an unexplored neighbour
/// counts.
double ScoreLiterally(const ByteMap& map, Cell cell, double unexplored_score, int unexplored_beside = 127) {
  if (map.At(cell) == 127) return unexplored_score;
  const auto Beside = [&](int dx, int dy) {
    const int byte = map.At({cell.x + dx, cell.y + dy});
    return 255 - (byte == 127 ? unexplored_beside : byte);
  };
  return 10.0 * (255 - map.At(cell)) + Beside(-1, 0) + Beside(1, 0) + Beside(0, -1) + Beside(0, 1);
}

/// Section 5.2 line by line on the bytes of the map, divided by the largest sum.
double EvaluateLiterally(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& pose,
                         double unexplored_score) {
  double fitness_value = 0.0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const double x_m = std::cos(pose.yaw_rad) * hits_m(0, i) - std::sin(pose.yaw_rad) * hits_m(1, i) + pose.x_m;
    const double y_m = std::sin(pose.yaw_rad) * hits_m(0, i) + std::cos(pose.yaw_rad) * hits_m(1, i) + pose.y_m;
    const Cell cell{static_cast<int>(std::floor(x_m / 0.05)), static_cast<int>(std::floor(y_m / 0.05))};
    fitness_value += ScoreLiterally(map, cell, unexplored_score);
  }
  return fitness_value / (3570.0 * static_cast<double>(hits_m.cols()));
}

}  // namespace

TEST_CASE("rays on cells of value 0 amid such cells fit perfectly, on cells of value 255 not at all, nor do no rays") {
  const RaysInCells rays = ToCells(DrawHits(100, 2.0, 1), kGeometry);
  for (const bool interpolate : {false, true}) {
    const FitnessField occupied = Field(Map([](Cell) { return kOccupiedByte; }), -100.0, interpolate);
    const FitnessField free = Field(Map([](Cell) { return kFreeByte; }), -100.0, interpolate);
    for (const Pose2& pose : {Pose2{}, {-0.1, -3.0, 2.0}, {-3.2, 0.0, -1.0}}) {
      CHECK(occupied.Evaluate(rays, pose) == 1.0);
      CHECK(free.Evaluate(rays, pose) == 0.0);
      CHECK(occupied.Evaluate(ToCells(Eigen::Matrix2Xd(2, 0), kGeometry), pose) == 0.0);
    }
  }
}

TEST_CASE("a ray on an unexplored cell scores -100 of 3570, on an empty map and beyond its tiles too") {
  const RaysInCells rays = ToCells(DrawHits(10, 1.0, 2), kGeometry);
  for (const bool interpolate : {false, true}) {
    const FitnessField empty(kGeometry, {-100.0, interpolate});
    CHECK(empty.Evaluate(rays, {}) == Approx(-100.0 / 3570.0));
    const FitnessField far = Field(Map(Noise), -100.0, interpolate);
    CHECK(far.Evaluate(rays, {100.0, -200.0, 0.5}) == Approx(-100.0 / 3570.0));
    CHECK(FitnessField(kGeometry, {0.0, interpolate}).Evaluate(rays, {}) == 0.0);
  }
}

TEST_CASE("without interpolation the fitness is section 5.2 to the letter") {
  const ByteMap map = Map(Noise);
  for (const double unexplored_score : {-100.0, 0.0, 35.0}) {
    const FitnessField field = Field(map, unexplored_score, false);
    Random random(3);
    for (std::uint64_t i = 0; i < 40; ++i) {
      const Eigen::Matrix2Xd hits_m = DrawHits(50, 4.0, i);
      const Pose2 pose{random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0), random.Uniform(-kPi, kPi)};
      // Single precision could put a ray into the next cell if it ended within 1e-6 m of it: none of these does.
      CHECK(field.Evaluate(ToCells(hits_m, kGeometry), pose) ==
            Approx(EvaluateLiterally(map, hits_m, pose, unexplored_score)).margin(1e-12));
    }
  }
}

TEST_CASE(
    "with interpolation the fitness of one ray is bilinear between the centres of four cells, both sides of a wall "
    "alike") {
  const ByteMap map = Map(Noise);
  const FitnessField field = Field(map, -100.0, true);
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    // Points of the 1/128 lattice on which rays are placed, in cells; all tiles and their seams.
    const double x = std::floor(random.Uniform(-128.0, 127.0) * 128.0) / 128.0;
    const double y = std::floor(random.Uniform(-128.0, 127.0) * 128.0) / 128.0;
    const Cell cell{static_cast<int>(std::floor(x - 0.5)), static_cast<int>(std::floor(y - 0.5))};
    const double right = x - 0.5 - cell.x;
    const double up = y - 0.5 - cell.y;
    const auto Score = [&](int dx, int dy) { return ScoreLiterally(map, {cell.x + dx, cell.y + dy}, -100.0, 255); };
    const double expected = ((Score(0, 0) * (1 - right) + Score(1, 0) * right) * (1 - up) +
                             (Score(0, 1) * (1 - right) + Score(1, 1) * right) * up) /
                            3570.0;
    CAPTURE(x, y);
    CHECK(field.Evaluate(OneRayAround(x, y, random), {}) == Approx(expected).margin(1e-12));
  }
}

TEST_CASE("the smooth fitness of one ray is a quadratic B-spline of nine cells") {
  const ByteMap map = Map(Noise);
  for (const bool interpolate : {false, true}) {
    const FitnessField field = Field(map, -100.0, interpolate);
    Random random(12);
    for (int i = 0; i < 500; ++i) {
      const double x = std::floor(random.Uniform(-128.0, 127.0) * 128.0) / 128.0;
      const double y = std::floor(random.Uniform(-128.0, 127.0) * 128.0) / 128.0;
      const Cell cell{static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y))};
      const auto Weight = [](double from_centre) {
        const double far = std::abs(from_centre);
        return far < 0.5 ? 0.75 - far * far : 0.5 * (1.5 - far) * (1.5 - far);
      };
      double expected = 0.0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Cell at{cell.x + dx, cell.y + dy};
          expected += Weight(x - at.x - 0.5) * Weight(y - at.y - 0.5) *
                      ScoreLiterally(map, at, -100.0, interpolate ? 255 : 127) / 3570.0;
        }
      }
      CAPTURE(x, y);
      CHECK(field.Differentiate(OneRay(static_cast<float>(x), static_cast<float>(y)), {}).value ==
            Approx(expected).margin(1e-6));
    }
  }
}

TEST_CASE("the derivatives of the smooth fitness are its slopes, and add up to what changes on a way") {
  const ByteMap map = Map(Noise);
  const FitnessField field = Field(map, -100.0, true);
  const RaysInCells rays = ToCells(DrawHits(203, 4.0, 3), kGeometry, Eigen::ArrayXi::LinSpaced(203, 1, 21));
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d from(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), random.Uniform(-3.0, 3.0));
    const auto At = [&](const Eigen::Vector3d& pose) {
      return field.Differentiate(rays, {pose.x(), pose.y(), pose.z()});
    };
    for (int axis = 0; axis < 3; ++axis) {
      // A ray passes several cells on the way; where it does, the second derivative jumps.
      const Eigen::Vector3d way = (axis == 2 ? 0.02 : 0.1) * Eigen::Vector3d::Unit(axis);
      constexpr int kSteps = 400;
      double value = 0.0;
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      for (int k = 0; k < kSteps; ++k) {
        const FitnessDerivatives here = At(from + (k + 0.5) / kSteps * way);
        value += here.gradient.dot(way) / kSteps;
        gradient += here.hessian * way / kSteps;
        REQUIRE(here.hessian == here.hessian.transpose());
      }
      const FitnessDerivatives before = At(from);
      const FitnessDerivatives after = At(from + way);
      CAPTURE(i, axis);
      CHECK(value == Approx(after.value - before.value).margin(1e-4));
      for (int other = 0; other < 3; ++other) {
        CHECK(gradient[other] == Approx(after.gradient[other] - before.gradient[other]).margin(0.02));
      }
    }
  }
}

TEST_CASE(
    "a field that follows changed cells or tiles is the field of the changed map, wherever in their tiles they are") {
  constexpr int kReach = 130;  // cells: tiles -3 to 2
  Random random(10);
  const auto Draw = [&](int low, int high) { return low + static_cast<int>(random.Uniform(0.0, high - low + 1.0)); };
  ByteMap map(0.05);  // of which each change explores a piece
  FitnessField following(kGeometry, {-100.0, true});
  for (int i = 0; i < 300; ++i) {
    // A rectangle in one tile; every other one ends at a side or a corner of it.
    const Cell corner = CellsOf(TileOf({Draw(-kReach, kReach), Draw(-kReach, kReach)})).low;
    const auto DrawRange = [&] {
      const int first = i % 2 == 0 ? Draw(0, 63) : Draw(0, 1) * Draw(0, 63);
      return std::pair{first, i % 4 == 1 ? 63 : std::min(63, first + Draw(0, i % 3 == 0 ? 2 : 63))};
    };
    const auto [x_low, x_high] = DrawRange();
    const auto [y_low, y_high] = DrawRange();
    const CellRectangle changed{{corner.x + x_low, corner.y + y_low}, {corner.x + x_high, corner.y + y_high}};
    const TileIndex tile = TileOf(corner);
    TileBytes before;
    for (int k = 0; k < kTileCells; ++k) before[static_cast<std::size_t>(k)] = map.At(CellAt(tile, k));
    TileBytes after = before;
    for (int y = changed.low.y; y <= changed.high.y; ++y) {
      for (int x = changed.low.x; x <= changed.high.x; ++x) {
        after[static_cast<std::size_t>(OffsetInTile({x, y}))] = Noise({x + 1000 * i, y});
      }
    }
    REQUIRE(map.Apply({tile, PackRuns(before, after)}));
    i % 5 == 0 ? following.Refresh(map, {tile}) : following.RefreshCells(map, {changed});
    const FitnessField anew = Field(map, -100.0, true);
    int num_wrong = 0;
    for (int y = changed.low.y - 4; y <= changed.high.y + 4; ++y) {
      for (int x = changed.low.x - 4; x <= changed.high.x + 4; ++x) {
        const RaysInCells ray = OneRay(static_cast<float>(x) + 0.25f, static_cast<float>(y) + 0.75f);
        num_wrong += !Alike(following, anew, ray, {});
      }
    }
    CAPTURE(i, x_low, x_high, y_low, y_high, tile.x, tile.y);
    REQUIRE(num_wrong == 0);
  }
}

TEST_CASE("a field that makes room for tiles far away loses none") {
  ByteMap map(0.05);
  FitnessField following(kGeometry, {-100.0, true});
  // Each beyond the room around those before, on another side.
  for (const TileIndex far : {TileIndex{0, 0}, {200, 3}, {-120, -2}, {0, 190}, {3, -1}}) {
    for (int y = 0; y < 2; ++y) {
      const TileIndex index{far.x, far.y + y};
      const auto Paint = [&](Cell cell) { return TileOf(cell) == TileIndex{0, 0} ? kOccupiedByte : Noise(cell); };
      PaintOver(map, following, index, Paint);
    }
    const FitnessField anew = Field(map, -100.0, true);
    for (const auto& entry : map.tiles().entries()) {
      const Cell middle = CellAt(entry.index, kTileCells / 2 + kTileSide / 2);
      const Pose2 pose{middle.x * 0.05, middle.y * 0.05, 0.0};
      const RaysInCells rays = ToCells(DrawHitsOverCorners(500, 11), kGeometry);
      CHECK(Alike(following, anew, rays, pose));
    }
  }
}

TEST_CASE("where nothing is explored any more, rays score as in the unexplored, and the memory goes back") {
  constexpr int kSide = 24;  // tiles
  const auto IsKept = [](TileIndex index) { return index == TileIndex{3, 7} || index == TileIndex{4, 8}; };
  ByteMap map(0.05);
  FitnessField field(kGeometry, {-100.0, true});
  const auto ForEachTile = [](auto&& action) {
    for (int k = 0; k < kSide * kSide; ++k) action(TileIndex{k % kSide, k / kSide});
  };
  const double empty_mb = ResidentMb();
  ForEachTile([&](TileIndex index) { PaintOver(map, field, index, Noise); });
  const double full_mb = ResidentMb();
  ForEachTile([&](TileIndex index) {
    if (!IsKept(index)) PaintOver(map, field, index, [](Cell) { return kUnexploredByte; });
  });
  CHECK(map.tiles().entries().size() == 2);
  constexpr double kPairs_mb = kSide * kSide * kPairsInTile * sizeof(ScorePair) * 1e-6;
  CHECK(full_mb - empty_mb > 0.9 * kPairs_mb);
  CHECK(full_mb - ResidentMb() > 0.9 * kPairs_mb);
  const FitnessField anew = Field(map, -100.0, true);
  const RaysInCells rays = ToCells(DrawHitsOverCorners(500, 11), kGeometry);
  ForEachTile([&](TileIndex index) {
    const Cell middle = CellAt(index, kTileCells / 2 + kTileSide / 2);
    REQUIRE(Alike(field, anew, rays, {middle.x * 0.05, middle.y * 0.05, 0.0}));
  });
  PaintOver(map, field, {3, 6}, Noise);
  const FitnessField again = Field(map, -100.0, true);
  CHECK(Alike(field, again, rays, {3.5 * kTileSide * 0.05, 6.5 * kTileSide * 0.05, 0.0}));
}

TEST_CASE("all kernels give the same fitness, bit by bit") {
  Random random(7);
  const auto Draw = [&](double low, double high) { return random.Uniform(low, high); };
  for (int i = 0; i < 300; ++i) {
    // Tiles here and there, some of them at the limits of the map.
    const int edge = i % 3 == 0 ? 0 : (i % 3 == 1 ? kMaxTile - 4 : -kMaxTile);
    ByteMap map(0.05);
    for (const TileChange& change : PaintTiles(edge, edge + 3, Noise)) {
      if (Draw(0.0, 1.0) < 0.7) REQUIRE(map.Apply(change));
    }
    const double unexplored_score = std::floor(Draw(-3570.0, 3570.0));
    const bool interpolate = i % 2 == 0;

    const auto num_rays = static_cast<int>(Draw(1.0, 200.0));
    const RaysInCells drawn = ToCells(DrawHits(num_rays, Draw(0.01, 12.0), random.Next()), kGeometry);
    Eigen::ArrayXf x = drawn.x();
    Eigen::ArrayXi weight = drawn.weight();
    for (Eigen::Index ray = 0; ray < num_rays; ++ray) {
      x[ray] = Draw(0.0, 1.0) < 0.1 ? std::round(x[ray]) : x[ray];  // on the corners of cells too
      weight[ray] = i % 4 < 2 ? 1 : static_cast<int>(Draw(1.0, 22.0));
    }
    const RaysInCells rays(x, drawn.y(), weight);
    const double middle_m = (edge + 2) * kTileSide * 0.05;
    std::vector<Pose2> poses{{middle_m, middle_m, 0.0}, {1e9, -1e9, 1.0}, {-1e300, 0.0, 1.0}};
    for (int k = 0; k < 20; ++k) {
      poses.push_back({middle_m + Draw(-9.0, 9.0), middle_m + Draw(-9.0, 9.0), Draw(-7.0, 7.0)});
    }

    FitnessField reference(kGeometry, {unexplored_score, interpolate}, PlainFitnessKernel());
    reference.Refresh(map, AllTiles(map));
    for (const FitnessKernel kernel : FindFitnessKernels()) {
      FitnessField field(kGeometry, {unexplored_score, interpolate}, kernel);
      field.Refresh(map, AllTiles(map));
      for (const Pose2& pose : poses) {
        CHECK(Alike(field, reference, rays, pose));
      }
    }
  }
}

TEST_CASE("all kernels sum the largest weights and scores without overflow") {
  const ByteMap map = PaintMap(-1, 1, [](Cell) { return kOccupiedByte; });
  const Eigen::Matrix2Xd hits_m = DrawHits(4096, 1.0, 8);
  for (const FitnessKernel kernel : FindFitnessKernels()) {
    for (const double unexplored_score : {-100.0, -3570.0}) {
      FitnessField field(kGeometry, {unexplored_score, true}, kernel);
      field.Refresh(map, AllTiles(map));
      for (const int weight : {1, 21, 500000}) {
        const RaysInCells rays = ToCells(hits_m, kGeometry, Eigen::ArrayXi::Constant(4096, weight));
        CHECK(field.Evaluate(rays, {1.0, 1.0, 0.5}) == 1.0);
        CHECK(field.Differentiate(rays, {1.0, 1.0, 0.5}).value == Approx(1.0).epsilon(1e-5));
      }
    }
  }
}

TEST_CASE("a field takes memory for what is explored, however far apart that lies") {
  ByteMap map(0.05);
  for (const int corner : {0, 255}) {  // of the largest rectangle
    for (const TileChange& change : PaintTiles(corner, corner, Noise)) REQUIRE(map.Apply(change));
  }
  const double before_mb = ResidentMb();
  const FitnessField field = Field(map, -100.0, true);
  const Pose2 pose{255.5 * kTileSide * 0.05, 255.5 * kTileSide * 0.05, 0.0};
  CHECK(field.Evaluate(ToCells(DrawHits(100, 1.0, 9), kGeometry), pose) > 0.1);
  CHECK(ResidentMb() - before_mb < 20.0);
}

TEST_CASE("the fitness is the mean of the rays' scores by their weights") {
  const FitnessField field = Field(PaintMap(0, 0, [](Cell) { return kOccupiedByte; }), 0.0, false);
  Eigen::Matrix2Xd hits_m(2, 2);  // one in the tile, one in the unexplored
  hits_m << 0.5, -0.5,            //
      0.5, 0.5;
  CHECK(field.Evaluate(ToCells(hits_m, kGeometry, Eigen::Array2i(3, 1)), {}) == Approx(0.75));
}

}  // namespace crsm
