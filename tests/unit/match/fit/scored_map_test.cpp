#include "common/match/fit/scored_map.hpp"

#include "catch.hpp"
#include "common/match/fit/rays_in_cells.hpp"
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
  return ToCells(hits_m, map.geometry());
}

}  // namespace

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

TEST_CASE("a map that is there already has the scores of one that was applied piece by piece") {
  ScoredMap pieces(0.05, {-100.0, true});
  for (const TileChange& change : PaintTiles(-1, 1, Stripes)) REQUIRE(pieces.Apply(std::span(&change, 1)));
  const ScoredMap whole(PaintMap(-1, 1, Stripes), {-100.0, true});
  for (const Pose2& pose : {Pose2{}, {0.51, 0.02, 0.3}, {-3.0, 1.0, 2.0}}) {
    CHECK(pieces.Fitness(RaysOn(pieces), pose) == whole.Fitness(RaysOn(whole), pose));
  }
}

}  // namespace crsm
