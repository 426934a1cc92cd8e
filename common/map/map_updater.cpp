#include "common/map/map_updater.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/map/dense_grid.hpp"
#include "common/map/walk_cells.hpp"
#include "common/scan/surface.hpp"

namespace crsm {
namespace {

constexpr double kNearHitsCells = 2.0;  // hits this close are neighbours in the map whatever they lie on

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

struct MapUpdater::Tile {
  std::array<float, kTileCells> p_free;          // exact; the wire carries it rounded to a byte
  std::array<std::uint8_t, kTileCells> marks{};  // of the scan at hand
  bool marked = false;                           // by it
  bool blank = true;                             // nothing was drawn into it
  TileBytes bytes;
  std::int64_t changed_in_version = 0;

  Tile() { Clear(); }

  void Clear() {
    p_free.fill(0.5f);
    bytes.fill(kUnexploredByte);
    blank = true;
  }
};

MapUpdater::MapUpdater(const UpdateParameters& parameters)
    : parameters_(parameters),
      geometry_(parameters.cell_size_m),
      hit_marks_(ComputeHitMarks(parameters.hit_spread)),
      blend_(FindBlendKernels().back()) {}

MapUpdater::~MapUpdater() = default;
MapUpdater::MapUpdater(MapUpdater&&) noexcept = default;
MapUpdater& MapUpdater::operator=(MapUpdater&&) noexcept = default;

MapDelta MapUpdater::Update(const CriticalRays& scan, const ScanMatch& match) {
  if (scan.utime != match.utime) throw std::invalid_argument("MapUpdater: the match is of another scan");
  MapDelta delta = UpdateWithoutScan();
  if (finished_ || match.state == MatchState::kLost || !MovedEnough(match.T_map_laser)) return delta;
  BytesBefore before;
  delta.drawn = Draw({&scan.rays, match.T_map_laser}, &before);
  delta.tiles = ListChanges(before);
  if (delta.drawn) T_map_last_drawn_ = match.T_map_laser;
  return delta;
}

std::vector<TileChange> MapUpdater::Redraw(std::span<const PlacedScan> scans) {
  BytesBefore before;
  Clear(before);
  for (const PlacedScan& scan : scans) Draw(scan, &before);
  if (!scans.empty()) T_map_last_drawn_ = scans.back().T_map_laser;
  return ListChanges(before);
}

std::vector<TileChange> MapUpdater::DrawMore(std::span<const PlacedScan> scans) {
  BytesBefore before;
  for (const PlacedScan& scan : scans) Draw(scan, &before);
  return ListChanges(before);
}

/// before: gets the tiles that are not in it yet, as they were.
void MapUpdater::Clear(BytesBefore& before) {
  for (auto& [index, tile] : tiles_.entries()) {
    if (tile->blank) continue;  // as most are, once the path is long
    before.try_emplace(index, tile->bytes);
    tile->Clear();
  }
}

bool MapUpdater::HasRoomForPutOff() const {
  if (put_off_cells_.isEmpty()) return true;
  constexpr double kMarginTiles = 2.0;  // for what is marked behind and beside the hits
  const Eigen::Array2d size_tiles = put_off_cells_.sizes().array() / kTileSide + 2.0 * kMarginTiles;
  return size_tiles.prod() <= static_cast<double>(kMostTiles);
}

std::vector<TileChange> MapUpdater::DrawPutOff(std::span<const ScanBatch> batches) {
  put_off_ = false;
  BytesBefore before;
  for (const ScanBatch& batch : batches) {
    if (batch.anew) Clear(before);
    for (const PlacedScan& scan : batch.scans) Draw(scan, &before);
  }
  return ListChanges(before);
}

bool MapUpdater::InLimits(const ValidRays& rays, const Pose2& T_map_laser) const {
  const double reach_m = rays.size() == 0 ? 0.0 : *std::max_element(rays.range_m.begin(), rays.range_m.end());
  return geometry_.InLimits(T_map_laser.x_m, T_map_laser.y_m, reach_m);
}

MapDelta MapUpdater::UpdateWithoutScan() { return {++version_, false, {}}; }

void MapUpdater::Finish() {
  finished_ = true;
  version_ = 0;
  for (const auto& entry : tiles_.entries()) entry.tile->changed_in_version = 1;
}

std::optional<TileChange> MapUpdater::TileSince(std::size_t tile, std::int64_t version) const {
  const auto& entry = tiles_.entries().at(tile);
  if (entry.tile->changed_in_version <= version) return std::nullopt;
  TileBytes other = entry.tile->bytes;
  for (std::uint8_t& byte : other) byte ^= 0xFF;  // differs in every cell, so that the whole tile is packed
  return TileChange{entry.index, PackRuns(other, entry.tile->bytes)};
}

bool MapUpdater::MovedEnough(const Pose2& T_map_laser) const {
  if (!T_map_last_drawn_) return true;
  const Pose2 motion = Inverse(*T_map_last_drawn_) * T_map_laser;
  return Length(motion) >= parameters_.update_distance_m || std::abs(motion.yaw_rad) >= parameters_.update_angle_rad;
}

/// False if there is nothing to draw, or not all of it lies within the limits of the map.
bool MapUpdater::Draw(const PlacedScan& scan, BytesBefore* before) {
  const auto& [rays, T_map_laser] = scan;
  if (rays->size() == 0 || !InLimits(*rays, T_map_laser)) return false;
  if (put_off_) {
    const Eigen::Vector2d at_m(T_map_laser.x_m, T_map_laser.y_m);
    const double reach_m = *std::max_element(rays->range_m.begin(), rays->range_m.end());
    put_off_cells_.extend((at_m.array() - reach_m).matrix() / geometry_.cell_size_m());
    put_off_cells_.extend((at_m.array() + reach_m).matrix() / geometry_.cell_size_m());
    return true;
  }
  const Eigen::Matrix2Xd hits_m = ComputeHits(*rays);
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  Eigen::Matrix2d rotation;
  rotation << cos, -sin, sin, cos;
  const Eigen::Vector2d laser_cells(geometry_.ToCells(T_map_laser.x_m), geometry_.ToCells(T_map_laser.y_m));
  const Eigen::Matrix2Xd hits_cells = (rotation * hits_m / geometry_.cell_size_m()).colwise() + laser_cells;

  for (Eigen::Index i = 0; i < hits_cells.cols(); ++i) MarkFree(laser_cells, hits_cells.col(i));
  for (Eigen::Index i = 0; i < hits_cells.cols(); ++i) MarkHit(hits_cells.col(i));
  if (parameters_.join_hits) {
    const double near_m = kNearHitsCells * geometry_.cell_size_m();
    const auto joined = FindSurfaces(hits_m, near_m, parameters_.join_max_m);
    for (Eigen::Index i = 0; i < std::ssize(joined); ++i) {
      if (!joined[static_cast<std::size_t>(i)]) continue;
      const bool is_near = (hits_m.col(i + 1) - hits_m.col(i)).norm() <= near_m;
      if (!is_near && IsAlongBeam(hits_m.col(i), hits_m.col(i + 1))) continue;
      MarkSurface(hits_cells.col(i), hits_cells.col(i + 1));
      MarkBehind(hits_cells.col(i), hits_cells.col(i + 1));
    }
  }

  // "The intensity of the update is proportionate to the mean sparseness of the current scan."
  const double intensity =
      parameters_.sparseness_intensity
          ? std::min(std::max(ComputeMeanSparseness(*rays), parameters_.intensity_min), parameters_.intensity_max)
          : parameters_.intensity;
  for (const TileIndex index : marked_) {
    Tile& tile = *tiles_.Find(index);
    if (before) before->try_emplace(index, tile.bytes);
    Blend(tile, intensity);
    if (!before) tile.changed_in_version = version_;
  }
  marked_.clear();
  marking_ = nullptr;
  if (std::exchange(cut_, false)) ++num_scans_cut_;
  return true;
}

std::vector<TileChange> MapUpdater::ListChanges(const BytesBefore& before) {
  std::vector<TileChange> changes;
  for (const auto& [index, bytes] : before) {
    Tile& tile = *tiles_.Find(index);
    if (tile.bytes == bytes) continue;
    tile.changed_in_version = version_;
    changes.push_back({index, PackRuns(bytes, tile.bytes)});
  }
  return changes;
}

/// To be called before anything else is marked.
void MapUpdater::MarkFree(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells) {
  constexpr Cell kNowhere{-2 * kMaxCell, kMaxCell};
  std::uint8_t* marks = nullptr;  // those of the tile in which the walk is ...
  Cell corner = kNowhere;         // ... and its first cell
  const auto IsInside = [](int right, int up) { return static_cast<unsigned>(right | up) < kTileSide; };
  const auto MarkOne = [&](Cell cell) {
    if (!IsInside(cell.x - corner.x, cell.y - corner.y)) {
      Tile* tile = MarkTile(TileOf(cell));
      marks = tile ? tile->marks.data() : nullptr;
      corner = tile ? CellsOf(TileOf(cell)).low : kNowhere;
    }
    if (marks) marks[OffsetInTile(cell)] = kFreeMark;
  };
  WalkCells(from_cells, to_cells, [&](Cell cell, Cell next) {
    const Cell a{cell.x - corner.x, cell.y - corner.y};
    const Cell b{next.x - corner.x, next.y - corner.y};
    if (IsInside(a.x | b.x, a.y | b.y)) {
      marks[a.y * kTileSide + a.x] = kFreeMark;
      marks[b.y * kTileSide + b.x] = kFreeMark;
    } else {
      MarkOne(cell);
      MarkOne(next);
    }
  });
}

/// Hits scatter. Rays that end further away thin a wall out on its near side; on its far side nothing else does, and
/// walls would grow away from the laser, each match be a little too far ahead.
void MapUpdater::MarkBehind(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells) {
  if (parameters_.erase_behind_m == 0.0) return;
  const Eigen::Vector2d way = to_cells - from_cells;  // the laser turns to the left, and looks at it from there
  const double length_cells = std::sqrt(way.squaredNorm());
  if (length_cells == 0.0) return;  // two hits on one point have no far side
  const double behind_cells = parameters_.erase_behind_m / geometry_.cell_size_m();
  const Eigen::Vector2d behind = Eigen::Vector2d(way.y(), -way.x()) * (behind_cells / length_cells);
  const auto num_steps = static_cast<int>(length_cells) + 1;
  for (int i = 0; i < num_steps; ++i) {
    const Eigen::Vector2d at_cells = from_cells + way * (static_cast<double>(i) / num_steps);
    WalkCells(at_cells, at_cells + behind, [&](Cell cell, Cell next) {
      if (IsExplored(cell)) Mark(cell, kFreeMark);
      if (next != cell && IsExplored(next)) Mark(next, kFreeMark);
    });
  }
}

void MapUpdater::MarkSurface(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells) {
  if (parameters_.hit_spread == 0.0) {
    WalkCells(from_cells, to_cells, [&](Cell cell, Cell next) {
      Mark(cell, kOccupiedMark);
      Mark(next, kOccupiedMark);
    });
    return Mark(CellOf(to_cells), kOccupiedMark);
  }
  constexpr double kStepCells = 0.25;  // no cell on the way gets less than 3/4 of its share
  const Eigen::Vector2d way = to_cells - from_cells;
  const auto num_steps = static_cast<int>(std::sqrt(way.squaredNorm()) / kStepCells) + 1;
  for (int i = 1; i < num_steps; ++i) MarkHit(from_cells + way * (static_cast<double>(i) / num_steps));
}

/// A hit occupies the cells around it, each by how near it is: so the map knows where in a cell a wall stands, and a
/// match is finer than the cells.
void MapUpdater::MarkHit(const Eigen::Vector2d& at_cells) {
  if (parameters_.hit_spread == 0.0) return Mark(CellOf(at_cells), kOccupiedMark);
  const Eigen::Vector2d from_centre = at_cells.array() - 0.5;
  const Cell at = CellOf((from_centre * kParts).array() + 0.5);  // in parts of a cell
  const Cell low{at.x >> kPartBits, at.y >> kPartBits};          // rounded down
  constexpr int kPartMask = kParts - 1;
  const auto& marks = hit_marks_[static_cast<std::size_t>((at.y & kPartMask) << kPartBits | (at.x & kPartMask))];
  if ((low.x & kTileMask) < kTileMask && (low.y & kTileMask) < kTileMask) {  // all in one tile
    std::uint8_t* slots = FindMark(low);
    if (!slots) return;
    const std::array<std::uint8_t*, 4> each{slots, slots + 1, slots + kTileSide, slots + kTileSide + 1};
    for (std::size_t i = 0; i < 4; ++i) *each[i] = std::max(*each[i], marks[i]);
    return;
  }
  for (int i = 0; i < 4; ++i) {
    const std::uint8_t mark = marks[static_cast<std::size_t>(i)];
    if (mark > 0) Mark({low.x + (i & 1), low.y + (i >> 1)}, mark);
  }
}

/// Each cell counts once a scan, by the largest share that an obstacle has in it.
void MapUpdater::Mark(Cell cell, std::uint8_t mark) {
  if (std::uint8_t* slot = FindMark(cell)) *slot = std::max(*slot, mark);
}

bool MapUpdater::IsExplored(Cell cell) const {
  const TileIndex index = TileOf(cell);
  const Tile* tile = marking_ && index == marking_index_ ? marking_ : tiles_.Find(index);
  return tile && tile->bytes[static_cast<std::size_t>(OffsetInTile(cell))] != kUnexploredByte;
}

/// The mark of a cell; nullptr if there is no room for its tile.
std::uint8_t* MapUpdater::FindMark(Cell cell) {
  const TileIndex index = TileOf(cell);
  if (!marking_ || index != marking_index_) {
    marking_ = MarkTile(index);
    marking_index_ = index;
  }
  return marking_ ? &marking_->marks[static_cast<std::size_t>(OffsetInTile(cell))] : nullptr;
}

/// The tile, on the list of those that the scan touches; nullptr if there is no room for it.
MapUpdater::Tile* MapUpdater::MarkTile(TileIndex index) {
  Tile* tile = tiles_.Find(index);
  if (!tile && tiles_.HasRoomFor(index)) tile = &tiles_.Touch(index);
  if (!tile) {
    cut_ = true;
  } else if (!std::exchange(tile->marked, true)) {
    marked_.push_back(index);
  }
  return tile;
}

/// The asymptotic rule of section 6 on every marked cell; the marks are cleared.
void MapUpdater::Blend(Tile& tile, double intensity) const {
  constexpr double kMaxIntensity = 0.95;  // asymptotic: no cell is ever certain
  const auto Limited = [&](double value) { return static_cast<float>(std::min(kMaxIntensity, value)); };
  tile.marked = tile.blank = false;
  blend_({Limited(intensity), Limited(intensity * parameters_.occupied_density),
          static_cast<float>(parameters_.first_intensity)},
         tile.marks.data(), tile.p_free.data(), tile.bytes.data());
}

}  // namespace crsm
