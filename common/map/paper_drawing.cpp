#include "common/map/paper_drawing.hpp"

#include <algorithm>

#include "common/map/scan_on_map.hpp"
#include "common/map/tile_canvas.hpp"
#include "common/map/walk_cells.hpp"

namespace crsm {

BlendIntensity PaperDrawing::Draw(const ScanOnMap& scan, TileCanvas& canvas) const {
  const Eigen::Matrix2Xd& hits_cells = scan.hits_cells;
  canvas.MarkFree(scan);
  for (Eigen::Index i = 0; i < hits_cells.cols(); ++i) canvas.Mark(CellOf(hits_cells.col(i)), kOccupiedMark);
  const double intensity =
      std::clamp(ComputeMeanSparseness(scan.rays), constants_.intensity_min, constants_.intensity_max);
  const auto Limited = [&](double value) { return static_cast<float>(std::min(constants_.intensity_limit, value)); };
  return {Limited(intensity), Limited(intensity * constants_.occupied_density), 0.0f};
}

}  // namespace crsm
