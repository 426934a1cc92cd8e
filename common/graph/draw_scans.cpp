#include "common/graph/draw_scans.hpp"

namespace crsm {

ByteMap DrawScans(const DrawingRules& drawing, std::span<const PlacedScan> scans) {
  ByteMap cells(drawing.parameters.cell_size_m);
  for (const TileChange& tile : MapUpdater(drawing).Redraw(scans)) cells.Apply(tile);
  return cells;
}

}  // namespace crsm
