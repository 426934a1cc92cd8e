#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "services/map_viewer/feed.hpp"
#include "services/map_viewer/scene.hpp"

namespace crsm {

/// Points of a path, as a page is told them: number u32, and of each what record 3 says.
std::string PackPath(std::span<const PathSketch::Kept> points);

/// What the page of this viewer is told. Each message is binary, little-endian, and made of records: kind (1 byte),
/// size of the rest (4 bytes), the rest. services/map_viewer/page/wire.js reads them.
///
///   1 map      anew u8, epoch i64, version i64, tiles left u32, cell size f64 [m], number of tiles u16, and of each:
///              x y i16, whole u8, number of bytes u16, runs as in map_tile_t. anew: begins with an empty map; whole:
///              with an unexplored tile; tiles left: of this epoch's version, which come in other messages
///   2 robot    utime i64, state u8 as in scan_match_t, or 5: nothing of the scan was a measurement, trajectory i32,
///              floating u8, x y yaw f64 [m, m, rad], fitness f32, covariance xx xy yy yaw yaw f32, degenerate axis x y
///              f32, number of rays u16, of each angle and range f32 [rad, m], number of critical rays u16, of each its
///              index u16
///   3 path     generation u32, first point u32, number of points u32, of each its scan's number u32, x y f32 [m],
///              state u8, or 4: it has a pose, but on another piece than the one that is shown, trajectory i32
///   4 samples  number u32, of each time f64 [s], fitness f32, state u8
///   5 info     JSON: names of all robots, whether the page may only look, loops, marks, edits, the newest news and how
///              many there were, and Scene::info
///   6 timeline of a run that has ended: number of scans u32, then of all scans time f64 [s], then of all x, then y,
///              then yaw f32 [m, m, rad], then x, then y, then yaw f32 [m, m, rad] where it was matched first, NaN
///              if nowhere, then fitness f32, then degenerate axis f32 [rad], NaN if there is none, then trajectory
///              i32, then state u8 as of the path
///
///   7 then     how a finished run was known at a moment: whether it is the end u8, how many loops were closed u32,
///              number of the newest of them u16, of each x y x y f32 [m], number of points u32, of each as of the
///              path. The map comes as tiles that differ from those that the page has; none of this is told at first
///
/// A page may ask for one of these scans by the text "scan NUMBER": it comes as the robot; and by "then NUMBER" for
/// what was known at that scan, where info has "knows_then". By "start X Y YAW" [m, m, rad] it says where a robot is
/// that is localised on a finished map, and by "mark JSON" that a place with a name lies somewhere: {"id", "kind",
/// "name", "points": [[x, y], ...]} [m, map frame]; without points that it is removed. By "edits JSON" it says all that
/// is changed in a copy of a finished map, as ParseMapEdits reads it. Who may only look is sent away if he says
/// anything but "scan" and "then".
class PageFeed : public Feed {
 public:
  static constexpr const char* kSubprotocol = "crsm.view.v1";

  /// What a page remembers of a map after its connection was lost.
  struct Cursor {
    std::int64_t epoch = 0;
    std::int64_t version = 0;
  };

  /// names: of all robots that can be asked for, of which `scene` is one.
  PageFeed(const Scene& scene, std::vector<std::string> names, const Cursor& cursor, bool may_change = true);

  std::optional<Message> Next() override;
  bool has_more() const override { return has_more_; }
  bool Hear(std::string_view message, bool is_text) override;

 private:
  bool HearScan(std::string_view number);
  bool HearThen(std::string_view number);
  bool HearStart(std::string_view pose) const;
  bool HearMark(std::string_view json) const;
  void AddMap(std::string& message);
  void AddRobot(std::string& message);
  void AddPath(std::string& message);
  void AddSamples(std::string& message);
  void AddInfo(std::string& message);
  void AddTimeline(std::string& message);
  void AddThen(std::string& message);
  bool AddTilesOfMoment(std::string& message);
  void AppendMap(std::string& message, bool anew, std::ptrdiff_t num_left, std::uint16_t num_tiles,
                 const std::string& tiles) const;

  const Scene& scene_;
  std::vector<std::string> names_;
  bool may_change_;
  bool has_more_ = false;
  std::optional<int> map_generation_;  ///< that the page holds
  ChangeNumber map_told_ = 0;
  ChangeNumber robot_told_ = 0;
  int path_generation_ = 0;
  std::size_t path_told_ = 0;
  std::int64_t samples_told_ = 0;
  ChangeNumber info_told_ = 0;
  std::size_t timeline_told_ = 0;           ///< scans
  std::optional<std::size_t> scan_wanted_;  ///< of the timeline
  std::optional<std::size_t> moment_;       ///< of the history, that is told
  bool moment_changed_ = false;
  std::vector<std::size_t> held_;  ///< of each tile of the history as many changes as the page holds; empty: all
};

}  // namespace crsm
