#pragma once

#include <cstdint>
#include <mutex>

#include "common/logs/replacement.hpp"
#include "common/logs/temporary_file.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// The text of trajectory.tum so far, on the disk: one thread adds lines while another copies those that are there.
class TrajectoryText {
 public:
  void Add(const ScanMatch& match);

  /// Whole lines.
  std::uint64_t num_bytes() const;

  /// Gives the bytes from `begin` up to `end` <= num_bytes() to `sink`.
  void Copy(std::uint64_t begin, std::uint64_t end, const Sink& sink) const;

 private:
  mutable std::mutex mutex_;
  TemporaryFile file_;
};

}  // namespace crsm
