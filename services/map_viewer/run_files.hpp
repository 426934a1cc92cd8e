#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "services/map_viewer/web_server.hpp"

namespace crsm {

/// The files of finished runs for a browser: those of a fixed list that are in their folders, and run.mcap, which is
/// made when it is asked for. That takes minutes for a long run: it is made in a thread, one at a time, and no longer
/// than somebody waits for it.
class RunFiles {
 public:
  static constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;  ///< of a file
  static constexpr std::string_view kEditedMap = "map_edited.tar";     ///< edits.json and kEditedFiles

  /// folders: one for each robot; none where robots are live. most_bytes: larger files are refused.
  explicit RunFiles(std::vector<std::string> folders, std::uint64_t most_bytes = kMostBytes)
      : folders_(std::move(folders)), most_bytes_(most_bytes) {}
  /// Waits for the thread, which ends soon if the process is to end.
  ~RunFiles();
  RunFiles(const RunFiles&) = delete;

  /// JSON: [{"name": "map.png", "bytes": 4711}, ...] of the files that are there. "bytes" is null where that is not
  /// known before.
  WebPage List(std::size_t robot) const;

  /// name: as in the list. Of other names there is no file.
  WebAnswer Find(std::size_t robot, std::string_view name);

 private:
  struct Job;
  WebAnswer MakeEditedMap(std::size_t robot) const;
  WebAnswer MakeMcap(std::size_t robot);

  std::vector<std::string> folders_;
  std::uint64_t most_bytes_;
  std::weak_ptr<Job> job_;  ///< the last one, as long as the thread or a client has it
  std::thread worker_;
};

}  // namespace crsm
