#pragma once

#include <filesystem>
#include <string>

namespace crsm {

/// A folder or a file that this process alone writes to, until its end, however it ends. The lock (flock) is on the
/// folder itself: it leaves no file behind. Other processes heed it by asking for it too.
class PathLock {
 public:
  /// flag: how the user named the path, for the error. Throws std::runtime_error that says which process has it, if one
  /// has, or if there is neither a folder nor a file. Where the disk knows no locks, none is held.
  PathLock(const std::string& flag, const std::filesystem::path& path);
  ~PathLock();
  PathLock(const PathLock&) = delete;

  /// Whether the path still leads to what was locked: not where that was moved, removed or replaced.
  bool IsInPlace() const;

 private:
  void Take(const std::string& flag);

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace crsm
