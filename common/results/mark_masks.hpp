#pragma once

#include <string>
#include <vector>

#include "common/logs/replacement.hpp"
#include "common/map/dense_grid.hpp"
#include "common/marks/mark.hpp"

namespace crsm {

/// In percent of the full speed, where robots are to drive slowly.
inline constexpr int kSlowPercent = 50;

/// Adds keepout.png and keepout.yaml where there are outlines of kKeepOutKind, and slow.png and slow.yaml where there
/// are some of kSlowKind: masks of navigation2's costmap filters with the cells of the map, which map_server reads.
/// Mode `scale`: a zone to keep out of is 100, all else 0. Mode `raw`: the pixel is the percentage of the speed, 0
/// where nothing limits it. A cell that an outline touches belongs to the zone. grid: at least one cell.
/// suffix: of the names, before their ends.
void AddMasks(const DenseGrid& grid, const std::vector<PlacedMark>& marks, Replacement& files,
              const std::string& suffix = "");

}  // namespace crsm
