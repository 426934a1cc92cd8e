#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/map/blend_cells.hpp"
#include "common/map/map_delta.hpp"
#include "common/map/map_geometry.hpp"
#include "common/parameters.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// A scan, and where it was taken.
struct PlacedScan {
  const ValidRays* rays;
  Pose2 T_map_laser;
};

/// Scans that are drawn in their order.
struct ScanBatch {
  bool anew = false;  ///< nothing that was drawn before stays
  std::vector<PlacedScan> scans;
};

/// The owner of the map: draws matched scans into it. Source: section 6.
class MapUpdater {
 public:
  explicit MapUpdater(const UpdateParameters& parameters);
  ~MapUpdater();
  MapUpdater(MapUpdater&&) noexcept;
  MapUpdater& operator=(MapUpdater&&) noexcept;

  /// Draws a scan that was taken at `match.T_map_laser`, and says what changed. The map's version rises by one with
  /// every call, also when nothing changes: a lost scan, one without rays or beyond the limits of the map, or too
  /// little motion since the last drawn. Throws std::invalid_argument if the scan is not the one that was matched.
  MapDelta Update(const CriticalRays& scan, const ScanMatch& match);

  /// Draws all of the map anew, as of these scans in their order, in the version that there is. Returns what that
  /// changes.
  std::vector<TileChange> Redraw(std::span<const PlacedScan> scans);

  /// Draws more scans, in the version that there is, wherever they are on the path. Returns what that changes.
  std::vector<TileChange> DrawMore(std::span<const PlacedScan> scans);
  /// The same of one scan, where nobody asks what it changes.
  void DrawMore(const PlacedScan& scan) { Draw(scan, nullptr); }

  /// From now on nothing is drawn, and all else is as if it were. To be called while the map is empty.
  void PutOffDrawing() { put_off_ = true; }
  /// Whether no tile of what was put off can have lacked room: then the map is what was drawn since it was last drawn
  /// anew, and else it may hang on what had come before.
  bool HasRoomForPutOff() const;
  /// Draws what was put off, in the version that there is, and from now on all that comes. Returns what that changes.
  std::vector<TileChange> DrawPutOff(std::span<const ScanBatch> batches);

  /// Goes on with that version, in which nothing has changed, and which is no smaller than the one that there is.
  void SkipTo(std::int64_t version) { version_ = version; }

  /// Whether all of a scan that was taken there lies within the limits of the map.
  bool InLimits(const ValidRays& rays, const Pose2& T_map_laser) const;

  /// Answers a match that has no scan: a version in which nothing changes.
  MapDelta UpdateWithoutScan();

  /// The map is finished and stays as it is: what comes is answered and not drawn. Versions start over at 0, and a
  /// replica that holds version 0 lacks the whole map.
  void Finish();

  std::int64_t version() const { return version_; }
  const MapGeometry& geometry() const { return geometry_; }

  /// Scans of which a part was left out of the map, because it has no room for more tiles.
  std::int64_t num_scans_cut() const { return num_scans_cut_; }

  /// Tiles in the order of their creation.
  std::size_t num_tiles() const { return tiles_.entries().size(); }

  /// A whole tile, for a replica that lacks it; nothing if it has not changed since `version`.
  std::optional<TileChange> TileSince(std::size_t tile, std::int64_t version) const;

 private:
  struct Tile;
  using BytesBefore = std::map<TileIndex, TileBytes>;  ///< tiles that were drawn into, as they were

  bool MovedEnough(const Pose2& T_map_laser) const;
  /// before: tiles that are not in it yet are added; nullptr where nobody asks.
  bool Draw(const PlacedScan& scan, BytesBefore* before);
  void Clear(BytesBefore& before);
  /// What is not as before any more, which has changed in this version.
  std::vector<TileChange> ListChanges(const BytesBefore& before);
  void MarkFree(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells);
  void MarkBehind(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells);
  void MarkSurface(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells);
  void MarkHit(const Eigen::Vector2d& at_cells);
  void Mark(Cell cell, std::uint8_t mark);
  bool IsExplored(Cell cell) const;
  std::uint8_t* FindMark(Cell cell);
  Tile* MarkTile(TileIndex index);
  void Blend(Tile& tile, double intensity) const;

  UpdateParameters parameters_;
  MapGeometry geometry_;
  std::vector<std::array<std::uint8_t, 4>> hit_marks_;  ///< by where between the centres of four cells a hit lies
  BlendKernel blend_;
  TileGrid<Tile> tiles_;
  std::vector<TileIndex> marked_;  ///< tiles that the scan at hand touches
  Tile* marking_ = nullptr;        ///< the one it touched last, nullptr if there is no room for it ...
  TileIndex marking_index_;        ///< ... and where that is
  bool cut_ = false;               ///< there was no room for all of it
  std::int64_t num_scans_cut_ = 0;
  std::int64_t version_ = 0;
  bool finished_ = false;
  bool put_off_ = false;
  Eigen::AlignedBox2d put_off_cells_;  ///< around all that was put off
  std::optional<Pose2> T_map_last_drawn_;
};

}  // namespace crsm
