#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/graph/placed_loop.hpp"
#include "common/map/byte_map.hpp"
#include "common/map/dense_grid.hpp"
#include "common/map/map_delta.hpp"
#include "common/marks/mark.hpp"
#include "common/metrics/path_sketch.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"
#include "services/map_viewer/timeline.hpp"

namespace crsm {

/// Numbers the changes of a scene. Who remembers the last one that it has seen can be told what is newer.
using ChangeNumber = std::uint64_t;

/// The map as it is shown: whole tiles, and the order in which they have changed.
class SceneMap {
 public:
  struct Tile {
    TileBytes cells;
    std::vector<std::uint8_t> last_runs;  ///< what the last change of it was, as of map_tile_t
    ChangeNumber changed = 0;             ///< the last time, ...
    ChangeNumber changed_before = 0;      ///< ... and the time before
    std::int64_t changed_in = 0;          ///< version of the map that brought it
    Tile() { cells.fill(kUnexploredByte); }
  };

  /// Another map begins, of which nothing is known yet.
  void Begin(double cell_size_m);

  /// What a tile is now. Nothing happens where it was so before.
  void Set(TileIndex index, const TileBytes& cells, std::int64_t version);

  /// What all of the map is now; one with other cells begins anew.
  void Replace(const ByteMap& map, std::int64_t version);

  /// All that was set belongs to this version, and is all of it.
  void SetVersion(std::int64_t epoch, std::int64_t version);

  /// Tells maps that were begun apart.
  int generation() const { return generation_; }
  std::int64_t epoch() const { return epoch_; }
  std::int64_t version() const { return version_; }
  double cell_size_m() const { return cell_size_m_; }
  ChangeNumber last_change() const { return last_change_; }

  const std::map<TileIndex, Tile>& tiles() const { return tiles_; }
  /// All tiles by their last change.
  const std::map<ChangeNumber, TileIndex>& changes() const { return changes_; }

  /// The last change that is in that version of the map, for who has held it since; 0 where it is of another epoch.
  ChangeNumber FindVersion(std::int64_t epoch, std::int64_t version) const;

 private:
  int generation_ = 0;
  std::int64_t epoch_ = 0;
  std::int64_t version_ = 0;
  double cell_size_m_ = 0.05;
  ChangeNumber last_change_ = 0;
  std::map<TileIndex, Tile> tiles_;
  std::map<ChangeNumber, TileIndex> changes_;
};

/// A robot: the last scan, where it was taken on the map that is shown, and how it fits there.
struct SceneRobot {
  ScanMatch match;
  CriticalRays scan;  ///< empty where it was not heard
};

/// One scan in the running curves.
struct SceneSample {
  std::int64_t utime = 0;
  float fitness = 0.0F;
  MatchState state = MatchState::kFirst;
};

class History;

/// All that there is to see of one robot. It is filled by who hears the robot, or reads its journal, and read by feeds,
/// each of which remembers what it has told already.
class Scene {
 public:
  explicit Scene(std::string name) : name_(std::move(name)) {}

  static constexpr std::size_t kMostSamples = 1024;

  /// Of the robot: its channel prefix, or the folder of its results.
  const std::string& name() const { return name_; }

  SceneMap& map() { return map_; }
  const SceneMap& map() const { return map_; }

  /// Where the robot was, by all that is known; `anew`: another path than before, and not more of it.
  void SetPath(const PathSketch& path, bool anew);
  const PathSketch& path() const { return path_; }
  int path_generation() const { return path_generation_; }

  void SetRobot(SceneRobot robot);
  const SceneRobot& robot() const { return robot_; }
  ChangeNumber robot_change() const { return robot_change_; }

  /// The newest are kept.
  void AddSample(const SceneSample& sample);
  const std::deque<SceneSample>& samples() const { return samples_; }
  /// How many there were: the last of samples() is the one before this number.
  std::int64_t num_samples() const { return num_samples_; }

  /// Of a run that has ended: it does not change any more.
  void SetTimeline(Timeline timeline) { timeline_ = std::move(timeline); }
  const Timeline& timeline() const { return timeline_; }

  /// How it was known at moments of the run; null while that is not there.
  void SetHistory(std::shared_ptr<const History> history);
  const std::shared_ptr<const History>& history() const { return history_; }

  /// Those that hold are shown.
  void SetLoops(std::vector<PlacedLoop> loops);
  const std::vector<PlacedLoop>& loops() const { return loops_; }

  /// Places with names.
  void SetMarks(std::vector<PlacedMark> marks);
  const std::vector<PlacedMark>& marks() const { return marks_; }

  /// What is done when somebody adds, moves or removes one; nothing can be where none was set.
  void SetMarkHandler(std::function<void(const Mark&)> mark) { mark_ = std::move(mark); }
  /// False where nothing can be done.
  bool TakeMark(const Mark& mark) const {
    if (mark_) mark_(mark);
    return mark_ != nullptr;
  }

  /// Lines about what has just happened; nothing if there are none.
  void AddNews(const std::vector<std::string>& lines);
  const std::string& newest_news() const { return newest_news_; }
  std::int64_t num_news() const { return num_news_; }

  /// What is done when somebody says where the robot is; nothing can be where none was set.
  void SetStartHandler(std::function<void(const Pose2&)> start_at) { start_at_ = std::move(start_at); }
  /// False where nothing can be done.
  bool StartAt(const Pose2& T_map_laser) const {
    if (start_at_) start_at_(T_map_laser);
    return start_at_ != nullptr;
  }

  /// What somebody changes in a copy of the map, and what became of it, as one JSON object; empty where nobody can.
  /// is_written: files of it are being replaced at the moment.
  void SetEdits(std::string json, bool is_written);
  const std::string& edits() const { return edits_; }
  bool writes_edits() const { return writes_edits_; }

  /// What is done with edits: false where they are none. Nothing can be where no handler was set.
  void SetEditsHandler(std::function<bool(std::string_view)> take_edits) { take_edits_ = std::move(take_edits); }
  bool TakeEdits(std::string_view json) const { return take_edits_ && take_edits_(json); }

  /// What else is to be told, as one JSON object: services, counts.
  void SetInfo(std::string json);
  const std::string& info() const { return info_; }
  /// Of info, loops, marks, edits or news.
  ChangeNumber info_change() const { return info_change_; }

 private:
  std::string name_;
  SceneMap map_;
  PathSketch path_;
  int path_generation_ = 1;
  SceneRobot robot_;
  ChangeNumber robot_change_ = 0;
  std::deque<SceneSample> samples_;
  std::int64_t num_samples_ = 0;
  Timeline timeline_;
  std::shared_ptr<const History> history_;
  std::vector<PlacedLoop> loops_;
  std::vector<PlacedMark> marks_;
  std::function<void(const Mark&)> mark_;
  std::string newest_news_;
  std::int64_t num_news_ = 0;
  std::function<void(const Pose2&)> start_at_;
  std::string edits_;
  bool writes_edits_ = false;
  std::function<bool(std::string_view)> take_edits_;
  std::string info_ = "{}";
  ChangeNumber info_change_ = 1;
};

}  // namespace crsm
