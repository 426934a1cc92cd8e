#include "common/map/surface_drawing.hpp"

#include <algorithm>
#include <cmath>

#include "common/map/walk_cells.hpp"
#include "common/scan/surface.hpp"

namespace crsm {
namespace {

// A hit is placed to this part of a cell: 1.6 mm, a few times finer than lasers are.
constexpr int kPartBits = 5;
constexpr int kParts = 1 << kPartBits;

/// The marks of the four cells around a hit, by where between their centres it lies.
std::vector<std::array<std::uint8_t, 4>> ComputeHitMarks(double hit_spread) {
  const auto ToMark = [&](double share) {
    const int mark = static_cast<int>(std::min(1.0, hit_spread * share) * kOccupiedMark);
    return static_cast<std::uint8_t>(mark > kFreeMark ? mark : 0);
  };
  std::vector<std::array<std::uint8_t, 4>> marks;
  for (int y = 0; y < kParts; ++y) {
    for (int x = 0; x < kParts; ++x) {
      const double right = static_cast<double>(x) / kParts;
      const double up = static_cast<double>(y) / kParts;
      marks.push_back({ToMark((1.0 - right) * (1.0 - up)), ToMark(right * (1.0 - up)), ToMark((1.0 - right) * up),
                       ToMark(right * up)});
    }
  }
  return marks;
}

}  // namespace

SurfaceDrawing::SurfaceDrawing(const DrawingConstants& constants)
    : constants_(constants), hit_marks_(ComputeHitMarks(constants.hit_spread)) {}

BlendIntensity SurfaceDrawing::Draw(const ScanOnMap& scan, TileCanvas& canvas) const {
  const Eigen::Matrix2Xd& hits_m = scan.hits_m;
  const Eigen::Matrix2Xd& hits_cells = scan.hits_cells;
  canvas.MarkFree(scan);
  for (Eigen::Index i = 0; i < hits_cells.cols(); ++i) MarkHit(hits_cells.col(i), canvas);
  const double near_m = constants_.near_hits_cells * scan.cell_size_m;
  const auto joined = Gaps(hits_m, constants_.surface).FindSurfaces(near_m, constants_.join_max_m);
  for (Eigen::Index i = 0; i < std::ssize(joined); ++i) {
    if (!joined[static_cast<std::size_t>(i)]) continue;
    const bool is_near = (hits_m.col(i + 1) - hits_m.col(i)).norm() <= near_m;
    if (!is_near && IsAlongBeam(hits_m.col(i), hits_m.col(i + 1), constants_.surface)) continue;
    MarkSurface(hits_cells.col(i), hits_cells.col(i + 1), canvas);
    MarkBehind(hits_cells.col(i), hits_cells.col(i + 1), scan.cell_size_m, canvas);
  }
  // "The intensity of the update is proportionate to the mean sparseness of the current scan."
  const double intensity =
      std::min(std::max(ComputeMeanSparseness(scan.rays), constants_.intensity_min), constants_.intensity_max);
  const auto Limited = [&](double value) { return static_cast<float>(std::min(constants_.intensity_limit, value)); };
  return {Limited(intensity), Limited(intensity * constants_.occupied_density),
          static_cast<float>(constants_.first_intensity)};
}

/// Hits scatter. Rays that end further away thin a wall out on its near side; on its far side nothing else does, and
/// walls would grow away from the laser, each match be a little too far ahead.
void SurfaceDrawing::MarkBehind(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells, double cell_size_m,
                                TileCanvas& canvas) const {
  const Eigen::Vector2d way = to_cells - from_cells;  // the laser turns to the left, and looks at it from there
  const double length_cells = std::sqrt(way.squaredNorm());
  if (length_cells == 0.0) return;  // two hits on one point have no far side
  const double behind_cells = constants_.erase_behind_m / cell_size_m;
  const Eigen::Vector2d behind = Eigen::Vector2d(way.y(), -way.x()) * (behind_cells / length_cells);
  const auto num_steps = static_cast<int>(length_cells) + 1;
  for (int i = 0; i < num_steps; ++i) {
    const Eigen::Vector2d at_cells = from_cells + way * (static_cast<double>(i) / num_steps);
    WalkCells(at_cells, at_cells + behind, [&](Cell cell, Cell next) {
      if (canvas.IsExplored(cell)) canvas.Mark(cell, kFreeMark);
      if (next != cell && canvas.IsExplored(next)) canvas.Mark(next, kFreeMark);
    });
  }
}

void SurfaceDrawing::MarkSurface(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells,
                                 TileCanvas& canvas) const {
  const Eigen::Vector2d way = to_cells - from_cells;
  const auto num_steps = static_cast<int>(std::sqrt(way.squaredNorm()) / constants_.step_cells) + 1;
  for (int i = 1; i < num_steps; ++i) MarkHit(from_cells + way * (static_cast<double>(i) / num_steps), canvas);
}

/// A hit occupies the cells around it, each by how near it is: so the map knows where in a cell a wall stands, and a
/// match is finer than the cells.
void SurfaceDrawing::MarkHit(const Eigen::Vector2d& at_cells, TileCanvas& canvas) const {
  const Eigen::Vector2d from_centre = at_cells.array() - 0.5;
  const Cell at = CellOf((from_centre * kParts).array() + 0.5);  // in parts of a cell
  const Cell low{at.x >> kPartBits, at.y >> kPartBits};          // rounded down
  constexpr int kPartMask = kParts - 1;
  const auto& marks = hit_marks_[static_cast<std::size_t>((at.y & kPartMask) << kPartBits | (at.x & kPartMask))];
  if ((low.x & kTileMask) < kTileMask && (low.y & kTileMask) < kTileMask) {  // all in one tile
    std::uint8_t* slots = canvas.FindMark(low);
    if (!slots) return;
    const std::array<std::uint8_t*, 4> each{slots, slots + 1, slots + kTileSide, slots + kTileSide + 1};
    for (std::size_t i = 0; i < 4; ++i) *each[i] = std::max(*each[i], marks[i]);
    return;
  }
  for (int i = 0; i < 4; ++i) {
    const std::uint8_t mark = marks[static_cast<std::size_t>(i)];
    if (mark > 0) canvas.Mark({low.x + (i & 1), low.y + (i >> 1)}, mark);
  }
}

}  // namespace crsm
