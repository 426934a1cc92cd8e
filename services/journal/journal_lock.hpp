#pragma once

#include <filesystem>
#include <optional>

#include "services/base/path_lock.hpp"

namespace crsm {

/// No other program goes on with the journal in a folder of results, or begins one there: map_updater may, without a
/// word of the folder.
class JournalLock {
 public:
  /// Throws as Renew.
  explicit JournalLock(std::filesystem::path out);

  /// Of the journal that is there now, if any. Throws std::runtime_error that names another program that has it.
  void Renew();

  /// Throws std::runtime_error where the journal is not there any more.
  void CheckIsInPlace() const;

 private:
  std::filesystem::path out_;
  std::optional<PathLock> lock_;
};

}  // namespace crsm
