#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/map/byte_map.hpp"
#include "common/map/map_geometry.hpp"
#include "common/match/fit/fitness_kernel.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

class RaysInCells;
struct FitnessDerivatives;

/// What a ray scores between cells, and where nothing is known.
struct ScoreRules {
  double unexplored_score = 0.0;  ///< for a ray that ends in an unexplored cell; a full hit scores 3570
  bool interpolate = true;        ///< bilinear between the centres of cells; false: the cell in which a ray ends
};

/// What a ray scores that ends in a given cell, kept up to date with the map: one read a ray instead of five.
/// Source: section 5.2, lines 6 to 10.
class FitnessField {
 public:
  /// geometry: of the map's cells. kernel: how scores are summed, all of which give the same.
  explicit FitnessField(const MapGeometry& geometry, const ScoreRules& rules = {},
                        FitnessKernel kernel = FindFitnessKernels().back());

  /// Takes over the tiles that changed, from the map after the change.
  void Refresh(const ByteMap& map, const std::vector<TileIndex>& changed);

  /// The same for those cells of them that changed.
  void RefreshCells(const ByteMap& map, const std::vector<CellRectangle>& changed);

  /// Fitness of rays seen from a pose, their weighted mean: [0, 1], below 0 where much is unexplored and that is
  /// punished. The laser is `T_map_laser`, rays and pose within the limits of the map. Returns 0 without rays. The same
  /// on every machine.
  double Evaluate(const RaysInCells& rays, const Pose2& T_map_laser) const;

  /// The fitness by a quadratic B-spline between cells, whether or not the field interpolates, and its derivatives. It
  /// is the mean of the bilinear one over a cell around each point: it has no edges, but is lower on thin walls. The
  /// same on every machine too.
  FitnessDerivatives Differentiate(const RaysInCells& rays, const Pose2& T_map_laser) const;

 private:
  /// Frees address space that the system gave.
  struct Unmap {
    std::size_t num_bytes;
    void operator()(ScorePair* pairs) const;
  };
  using Pairs = std::unique_ptr<ScorePair[], Unmap>;

  FitnessTask MakeTask(const RaysInCells& rays, const Pose2& T_map_laser, double shift, int units) const;
  static Pairs MakeBlankTiles(const TileRectangle& rectangle);
  ScorePair* FindTile(TileIndex index) const { return pairs_.get() + rectangle_.Place(index) * kPairsInTile; }
  void MakeRoom(const ByteMap& map);
  void RefreshPairs(const ByteMap& map, TileIndex index, const CellRectangle& stale);
  void Blank(TileIndex index);

  MapGeometry geometry_;
  std::int16_t unexplored_score_;
  bool interpolate_;
  FitnessKernel kernel_;
  TileRectangle rectangle_;
  std::vector<bool> written_;  ///< whether the system gave memory for a tile, by its place in the rectangle
  Pairs pairs_;                ///< scores less unexplored_score_: what is unexplored holds 0
};

}  // namespace crsm
