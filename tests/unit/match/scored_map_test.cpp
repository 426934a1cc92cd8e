#include "common/match/scored_map.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

std::uint8_t Stripes(Cell cell) { return cell.x % 3 == 0 ? kOccupiedByte : kFreeByte; }

/// Rays over the nine tiles around the origin.
RaysInCells RaysOn(const ScoredMap& map) {
  Random random(1);
  Eigen::Matrix2Xd hits_m(2, 500);
  for (int i = 0; i < 500; ++i) hits_m.col(i) << random.Uniform(-3.2, 6.4), random.Uniform(-3.2, 6.4);
  return map.InCells(hits_m);
}

constexpr double kCell_m = 0.05;

/// How far from a wall its hits may fit best [cells]: where the optimum is flat, its further end. The wall is
/// `wall_cells` above the centre of a cell, and lies along the cells; it occupies them as MapUpdater draws it.
template <class Fitness>
double FindBestPlace(double wall_cells, Fitness&& fitness) {
  const auto Wall = [&](Cell cell) {
    const double share = std::clamp(2.5 * (1.0 - std::abs(cell.y - wall_cells)), 0.0, 1.0);
    return static_cast<std::uint8_t>(std::lround(254.0 * (1.0 - share)));
  };
  ScoredMap map(kCell_m);
  REQUIRE(map.Apply(PaintTiles(-1, 1, Wall)));
  Eigen::Matrix2Xd hits_m(2, 40);
  for (int i = 0; i < 40; ++i) hits_m.col(i) << -1.0 + 0.0517 * i, 0.0;
  const RaysInCells rays = map.InCells(hits_m);
  double best = -1.0;
  double first_cells = 0.0;
  double last_cells = 0.0;
  for (double y_cells = -1.5; y_cells < 2.5; y_cells += 0.01) {
    const double there = fitness(map, rays, Pose2{0.0, (y_cells + 0.5) * kCell_m, 0.0});
    if (there > best + 1e-6) {
      best = there;
      first_cells = y_cells;
    }
    if (there > best - 1e-6) last_cells = y_cells;
  }
  return std::max(std::abs(first_cells - wall_cells), std::abs(last_cells - wall_cells));
}

}  // namespace

TEST_CASE("a wall along the cells fits where it stands by the smooth fitness, and by the other at a cell's centre") {
  const auto Rough = [](const ScoredMap& map, const auto& rays, const Pose2& pose) { return map.Fitness(rays, pose); };
  const auto Smooth = [](const ScoredMap& map, const auto& rays, const Pose2& pose) {
    return map.SmoothFitness(rays, pose);
  };
  double rough_cells = 0.0;
  double smooth_cells = 0.0;
  for (int i = 0; i < 20; ++i) {
    rough_cells += FindBestPlace(0.05 * i, Rough) / 20.0;
    smooth_cells += FindBestPlace(0.05 * i, Smooth) / 20.0;
  }
  CHECK(rough_cells > 0.25);  // at the nearest centre it would be a quarter of a cell in the mean
  CHECK(smooth_cells < 0.75 * rough_cells);
}

TEST_CASE("after changes of which some are refused, cells and scores are those of the others") {
  const std::vector<TileChange> good = PaintTiles(-1, 1, Stripes);
  std::vector<TileChange> mixed;
  for (const TileChange& change : good) {
    mixed.push_back({change.index, {0, 0, 0, 1}});              // a run without its byte
    mixed.push_back({{kMaxTile + 1, 0}, change.runs});          // beyond the limits
    mixed.push_back({change.index, {0xff, 0xff, 0, 9, 1, 1}});  // cut off, and beyond the tile
    mixed.push_back(change);
    mixed.push_back({{change.index.x + 100, 0}, {}});  // nothing changes
  }
  ScoredMap map(0.05);
  CHECK_FALSE(map.Apply(mixed));
  ScoredMap reference(0.05);
  CHECK(reference.Apply(good));
  CHECK(map.cells().ToDenseGrid().cells == reference.cells().ToDenseGrid().cells);
  CHECK(map.cells().tiles().entries().size() == good.size());
  CHECK(reference.Fitness(RaysOn(reference), {}) > 0.1);  // a third of the cells is occupied
  for (const Pose2& pose : {Pose2{}, {0.51, 0.02, 0.3}, {-3.0, 1.0, 2.0}}) {
    CHECK(map.Fitness(RaysOn(map), pose) == reference.Fitness(RaysOn(reference), pose));
  }
}

TEST_CASE("a change that is refused changes neither cells nor scores of what was there") {
  ScoredMap map(0.05);
  REQUIRE(map.Apply(PaintTiles(-1, 1, Stripes)));
  const auto before = map.cells().ToDenseGrid().cells;
  const double fitness = map.Fitness(RaysOn(map), {});
  for (const std::vector<std::uint8_t>& runs : {std::vector<std::uint8_t>{0, 0, 0, 1}, {0, 0, 0, 1, 9, 7}}) {
    const std::vector<TileChange> change{{{0, 0}, runs}};
    CHECK_FALSE(map.Apply(change));
    CHECK(map.cells().ToDenseGrid().cells == before);
    CHECK(map.Fitness(RaysOn(map), {}) == fitness);
  }
}

TEST_CASE("a map that is there already has the scores of one that was applied piece by piece") {
  ScoredMap pieces(0.05, {-100.0, true});
  for (const TileChange& change : PaintTiles(-1, 1, Stripes)) REQUIRE(pieces.Apply(std::span(&change, 1)));
  const ScoredMap whole(PaintMap(-1, 1, Stripes), {-100.0, true});
  for (const Pose2& pose : {Pose2{}, {0.51, 0.02, 0.3}, {-3.0, 1.0, 2.0}}) {
    CHECK(pieces.Fitness(RaysOn(pieces), pose) == whole.Fitness(RaysOn(whole), pose));
  }
}

}  // namespace crsm
