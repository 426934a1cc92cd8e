#pragma once

#include <span>

#include "common/map/byte_map.hpp"
#include "common/match/fit/fitness_field.hpp"

namespace crsm {

/// A pose and how well the rays fit there.
struct ScoredPose {
  Pose2 pose;
  double fitness = 0.0;
};

/// The map as the matcher holds it: its cells, their size, and what a ray scores that ends in each of them.
class ScoredMap {
 public:
  /// An empty map. rules: as of FitnessField.
  explicit ScoredMap(double cell_size_m, const ScoreRules& rules = {}) : ScoredMap(ByteMap(cell_size_m), rules) {}

  /// A map that is there already.
  explicit ScoredMap(ByteMap cells, const ScoreRules& rules = {});

  /// Takes over what changed in the map. False if a change is malformed, or the map has no room for it; the others are
  /// applied.
  bool Apply(std::span<const TileChange> changes);

  const ByteMap& cells() const { return cells_; }
  const MapGeometry& geometry() const { return cells_.geometry(); }

  /// How well rays fit when the laser stands at `T_map_laser`; as of FitnessField.
  double Fitness(const RaysInCells& rays, const Pose2& T_map_laser) const { return field_.Evaluate(rays, T_map_laser); }

  /// The same by a spline between cells, with its derivatives. The bilinear fitness has its optima at centres of cells,
  /// up to half a cell from where a wall stands; this has no such edges.
  FitnessDerivatives Differentiate(const RaysInCells& rays, const Pose2& T_map_laser) const;

 private:
  ByteMap cells_;
  FitnessField field_;
};

}  // namespace crsm
