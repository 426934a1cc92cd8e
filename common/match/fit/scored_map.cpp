#include "common/match/fit/scored_map.hpp"

#include <utility>
#include <vector>

#include "common/match/fit/fitness_derivatives.hpp"

namespace crsm {

ScoredMap::ScoredMap(ByteMap cells, const ScoreRules& rules)
    : cells_(std::move(cells)), field_(cells_.geometry(), rules) {
  std::vector<TileIndex> all;
  for (const auto& entry : cells_.tiles().entries()) all.push_back(entry.index);
  field_.Refresh(cells_, all);
}

bool ScoredMap::Apply(std::span<const TileChange> changes) {
  std::vector<CellRectangle> changed;
  const bool all_applied = cells_.Apply(changes, [&](const TileChange& change) {
    if (change.runs.empty()) return;
    changed.push_back(cells_.tiles().Find(change.index) ? FindChangedCells(change) : CellsOf(change.index));
  });
  field_.RefreshCells(cells_, changed);
  return all_applied;
}

FitnessDerivatives ScoredMap::Differentiate(const RaysInCells& rays, const Pose2& T_map_laser) const {
  return field_.Differentiate(rays, T_map_laser);
}

}  // namespace crsm
