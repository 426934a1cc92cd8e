#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "services/base/path_lock.hpp"

namespace crsm {

/// A folder of results that this process alone writes to: no other makes a map there, runs a stack, or goes on with the
/// journal in it, as map_updater may without a word of the folder.
class ResultsLock {
 public:
  /// flag: how the user named the folder, which is there. Throws std::runtime_error that names another process that has
  /// it.
  ResultsLock(std::string flag, std::filesystem::path out);

  /// Takes in the journal that is there now, if any. Throws as the constructor.
  void Renew();

  /// Throws std::runtime_error where the journal is not there any more.
  void CheckIsInPlace() const;

 private:
  std::string flag_;
  std::filesystem::path out_;
  PathLock folder_;
  std::optional<PathLock> log_;  ///< that of a stack, also while none of its processes has begun to write
  std::optional<PathLock> journal_;
};

}  // namespace crsm
