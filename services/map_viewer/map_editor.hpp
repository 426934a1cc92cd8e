#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "common/results/map_edits.hpp"
#include "services/map_viewer/scene.hpp"

namespace crsm {

/// The edits of a finished run, which a page makes: kept in its folder as edits.json, with the edited map beside the
/// map. That takes seconds for a large map: it is done in a thread, and only for the newest edits. Without edits these
/// files are removed. Where the folder cannot be written, the scene takes no edits.
class MapEditor {
 public:
  /// The scene outlives the editor, which sets what it tells of edits and how it takes them.
  MapEditor(std::string folder, Scene& scene);
  /// Waits for the thread.
  ~MapEditor();
  MapEditor(const MapEditor&) = delete;

  /// Tells the scene what has been written, and begins to write what is newer.
  void Step();

 private:
  /// One that is written. `error` belongs to the thread until it is done.
  struct Job {
    std::atomic<bool> done = false;
    std::string error;
  };

  bool Take(std::string_view json);
  void Tell(const char* state, const std::string& why = "");

  std::string folder_;
  Scene& scene_;
  MapEdits edits_;
  bool is_wanted_ = false;  ///< that the edits are written
  std::unique_ptr<Job> job_;
  std::thread worker_;
};

}  // namespace crsm
