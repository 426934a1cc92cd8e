#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// How far a log was published, in a file, so that a publisher that is started again goes on there: the number of scans
/// that need not be sent any more. Survives the end of the process at any moment.
class Position {
 public:
  /// path: of the file, which is made if need be; empty for none, then the position is 0. Throws std::runtime_error
  /// that names the file if it cannot be opened or holds something else.
  explicit Position(const std::string& path);
  ~Position();
  Position(const Position&) = delete;

  std::int64_t num_scans() const { return num_scans_; }

  /// One scan more. Where the disk is full the file keeps an earlier number: scans are sent twice then, and known to
  /// be.
  void Advance();

 private:
  int descriptor_ = -1;
  std::int64_t num_scans_ = 0;
};

}  // namespace crsm
