#include "common/map/map_updater.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/map/paper_drawing.hpp"
#include "common/map/scan_on_map.hpp"
#include "common/map/surface_drawing.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

std::unique_ptr<const ScanDrawing> MakeDrawing(const DrawingRules& rules) {
  if (rules.parameters.algorithm == Algorithm::kPaper) return std::make_unique<PaperDrawing>(rules.paper);
  return std::make_unique<SurfaceDrawing>(rules.constants);
}

}  // namespace

MapUpdater::MapUpdater(const DrawingRules& rules) : MapUpdater(rules.parameters, MakeDrawing(rules)) {}

MapDelta MapUpdater::Update(const CriticalRays& scan, const ScanMatch& match) {
  if (scan.utime != match.utime) throw std::invalid_argument("MapUpdater: the match is of another scan");
  MapDelta delta = UpdateWithoutScan();
  if (finished_ || match.state == MatchState::kLost || !MovedEnough(match.T_map_laser)) return delta;
  BytesBefore before;
  delta.drawn = Draw(scan.rays, match.T_map_laser, &before);
  delta.tiles = ListChanges(before);
  if (delta.drawn) T_map_last_drawn_ = match.T_map_laser;
  return delta;
}

std::vector<TileChange> MapUpdater::Redraw(std::span<const PlacedScan> scans) {
  BytesBefore before;
  Clear(before);
  DrawAll(scans, before);
  if (!scans.empty()) T_map_last_drawn_ = scans.back().T_map_laser;
  return ListChanges(before);
}

std::vector<TileChange> MapUpdater::DrawMore(std::span<const PlacedScan> scans) {
  BytesBefore before;
  DrawAll(scans, before);
  return ListChanges(before);
}

void MapUpdater::DrawAll(std::span<const PlacedScan> scans, BytesBefore& before) {
  for (const PlacedScan& scan : scans) Draw(scan.rays.Unpack(), scan.T_map_laser, &before);
}

std::vector<TileChange> MapUpdater::Replace(MapUpdater other, const Pose2& T_map_last_drawn) {
  T_map_last_drawn_ = T_map_last_drawn;
  std::vector<TileChange> changes;
  const auto Take = [&](std::size_t entry, std::unique_ptr<TileCanvas::Tile> tile) {
    const auto& [index, mine] = canvas_.tiles().entries()[entry];
    tile->changed_in_version = mine->changed_in_version;
    if (tile->bytes() != mine->bytes()) {
      tile->changed_in_version = version_;
      changes.push_back({index, PackRuns(mine->bytes(), tile->bytes())});
    }
    canvas_.tiles().Replace(entry, std::move(tile));
  };
  auto others = std::move(other.canvas_.tiles()).TakeEntries();
  std::ranges::sort(others, {}, &TileGrid<TileCanvas::Tile>::Entry::index);
  const std::size_t num_mine = num_tiles();
  for (std::size_t i = 0; i < num_mine; ++i) {
    const auto& [index, mine] = canvas_.tiles().entries()[i];
    const auto found = std::ranges::lower_bound(others, index, {}, &TileGrid<TileCanvas::Tile>::Entry::index);
    if (found != others.end() && found->index == index) {
      Take(i, std::move(found->tile));
    } else if (mine->cells) {
      Take(i, std::make_unique<TileCanvas::Tile>());
    }
  }
  bool cut = false;
  for (auto& [index, tile] : others) {
    if (!tile) continue;
    if (!canvas_.tiles().HasRoomFor(index)) {
      cut = true;
      continue;
    }
    canvas_.tiles().Touch(index);
    Take(num_tiles() - 1, std::move(tile));
  }
  num_scans_cut_ += other.num_scans_cut_ + (cut ? 1 : 0);
  return changes;
}

/// before: gets the tiles that are not in it yet, as they were.
void MapUpdater::Clear(BytesBefore& before) {
  for (auto& [index, tile] : canvas_.tiles().entries()) {
    if (!tile->cells) continue;
    before.try_emplace(index, tile->bytes());
    tile->cells.reset();
  }
}

bool MapUpdater::HasRoomForPutOff() const {
  if (!put_off_within_) return true;
  const auto& [low, high] = *put_off_within_;
  constexpr double kMarginTiles = 2.0;  // for what is marked behind and beside the hits
  const auto ToTiles = [&](double length_m) { return geometry_.ToCells(length_m) / kTileSide + 2.0 * kMarginTiles; };
  return ToTiles(high.x_m - low.x_m) * ToTiles(high.y_m - low.y_m) <= static_cast<double>(kMostTiles);
}

std::vector<TileChange> MapUpdater::DrawPutOff(std::span<const ScanBatch> batches) {
  put_off_ = false;
  BytesBefore before;
  for (const ScanBatch& batch : batches) {
    if (batch.anew) Clear(before);
    DrawAll(batch.scans, before);
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
  for (const auto& entry : canvas_.tiles().entries()) entry.tile->changed_in_version = 1;
}

std::optional<TileChange> MapUpdater::TileSince(std::size_t tile, std::int64_t version) const {
  const auto& entry = canvas_.tiles().entries().at(tile);
  if (entry.tile->changed_in_version <= version) return std::nullopt;
  TileBytes other = entry.tile->bytes();
  for (std::uint8_t& byte : other) byte ^= 0xFF;  // differs in every cell, so that the whole tile is packed
  return TileChange{entry.index, PackRuns(other, entry.tile->bytes())};
}

void MapUpdater::CopyTo(ByteMap& map, std::int64_t version) const {
  for (std::size_t tile = 0; tile < num_tiles(); ++tile) {
    if (const auto change = TileSince(tile, version)) map.Apply(*change);
  }
}

bool MapUpdater::MovedEnough(const Pose2& T_map_laser) const {
  if (!T_map_last_drawn_) return true;
  const Pose2 motion = Inverse(*T_map_last_drawn_) * T_map_laser;
  return Length(motion) >= parameters_.update_distance_m || std::abs(motion.yaw_rad) >= parameters_.update_angle_rad;
}

/// False if there is nothing to draw, or not all of it lies within the limits of the map.
bool MapUpdater::Draw(const ValidRays& rays, const Pose2& T_map_laser, BytesBefore* before) {
  if (rays.size() == 0 || !InLimits(rays, T_map_laser)) return false;
  if (put_off_) {
    const double reach_m = *std::max_element(rays.range_m.begin(), rays.range_m.end());
    const auto& [x_m, y_m, yaw_rad] = T_map_laser;
    if (!put_off_within_) put_off_within_ = {{x_m, y_m}, {x_m, y_m}};
    auto& [low, high] = *put_off_within_;
    low = {std::min(low.x_m, x_m - reach_m), std::min(low.y_m, y_m - reach_m)};
    high = {std::max(high.x_m, x_m + reach_m), std::max(high.y_m, y_m + reach_m)};
    return true;
  }
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  Eigen::Matrix2d rotation;
  rotation << cos, -sin, sin, cos;
  const Eigen::Vector2d laser_cells(geometry_.ToCells(T_map_laser.x_m), geometry_.ToCells(T_map_laser.y_m));
  const Eigen::Matrix2Xd hits_cells = (rotation * hits_m / geometry_.cell_size_m()).colwise() + laser_cells;

  const ScanOnMap scan_on_map{rays, hits_m, hits_cells, laser_cells, geometry_.cell_size_m()};
  const BlendIntensity intensity = drawing_->Draw(scan_on_map, canvas_);
  if (!canvas_.Blend(intensity, version_, before)) ++num_scans_cut_;
  return true;
}

std::vector<TileChange> MapUpdater::ListChanges(const BytesBefore& before) {
  std::vector<TileChange> changes;
  for (const auto& [index, bytes] : before) {
    TileCanvas::Tile& tile = *canvas_.tiles().Find(index);
    if (tile.bytes() == bytes) continue;
    tile.changed_in_version = version_;
    changes.push_back({index, PackRuns(bytes, tile.bytes())});
  }
  return changes;
}

}  // namespace crsm
