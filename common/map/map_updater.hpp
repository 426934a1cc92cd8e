#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/map/byte_map.hpp"
#include "common/map/drawing_constants.hpp"
#include "common/map/map_delta.hpp"
#include "common/map/map_geometry.hpp"
#include "common/map/scan_drawing.hpp"
#include "common/map/tile_canvas.hpp"
#include "common/math/point.hpp"
#include "common/parameters.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/packed_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// A scan, and where it was taken.
struct PlacedScan {
  PackedRays rays;
  Pose2 T_map_laser;
};

/// Scans that are drawn in their order.
struct ScanBatch {
  bool anew = false;  ///< nothing that was drawn before stays
  std::vector<PlacedScan> scans;
};

/// How a map is drawn.
struct DrawingRules {
  DrawingRules(const UpdateParameters& update, const DrawingConstants& ours = {},
               const PaperDrawingConstants& of_paper = {})
      : parameters(update), constants(ours), paper(of_paper) {}

  UpdateParameters parameters;
  DrawingConstants constants;   ///< of our drawing
  PaperDrawingConstants paper;  ///< of the paper's
};

/// The owner of the map: draws matched scans into it. Source: section 6.
class MapUpdater {
 public:
  /// Draws scans as the parameters' algorithm does.
  explicit MapUpdater(const DrawingRules& rules);
  MapUpdater(const UpdateParameters& parameters, std::unique_ptr<const ScanDrawing> drawing)
      : parameters_(parameters), geometry_(parameters.cell_size_m), drawing_(std::move(drawing)) {}

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
  void DrawMore(const PlacedScan& scan) { Draw(scan.rays.Unpack(), scan.T_map_laser, nullptr); }

  /// All of the map is as another one of such cells, in the version that there is. T_map_last_drawn: where the last of
  /// its scans was taken. Returns what that changes.
  std::vector<TileChange> Replace(MapUpdater other, const Pose2& T_map_last_drawn);

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

  /// Whether that is far enough from the last scan that was drawn to draw another.
  bool MovedEnough(const Pose2& T_map_laser) const;

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
  std::size_t num_tiles() const { return canvas_.tiles().entries().size(); }

  /// A whole tile, for a replica that lacks it; nothing if it has not changed since `version`.
  std::optional<TileChange> TileSince(std::size_t tile, std::int64_t version) const;
  /// Brings a map of the same cells, as it was in a version, to what this is; -1: it is empty.
  void CopyTo(ByteMap& map, std::int64_t version = -1) const;

 private:
  struct Box {
    Point low;
    Point high;
  };

  /// before: as of TileCanvas::Blend.
  bool Draw(const ValidRays& rays, const Pose2& T_map_laser, BytesBefore* before);
  void DrawAll(std::span<const PlacedScan> scans, BytesBefore& before);
  void Clear(BytesBefore& before);
  /// What is not as before any more, which has changed in this version.
  std::vector<TileChange> ListChanges(const BytesBefore& before);

  UpdateParameters parameters_;
  MapGeometry geometry_;
  std::unique_ptr<const ScanDrawing> drawing_;
  TileCanvas canvas_;
  std::int64_t num_scans_cut_ = 0;
  std::int64_t version_ = 0;
  bool finished_ = false;
  bool put_off_ = false;
  std::optional<Box> put_off_within_;  ///< around all that was put off
  std::optional<Pose2> T_map_last_drawn_;
};

}  // namespace crsm
