#pragma once

#include <cstdint>
#include <optional>

#include "common/logs/temporary_file.hpp"
#include "common/logs/utime_index.hpp"
#include "common/marks/mark_book.hpp"
#include "common/results/match_sequence.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// All matches so far, on the disk: what a process remembers of them does not grow with their number. They are in a
/// file without a name, which goes with the process; what is to stay is in the journal.
class MatchStore {
 public:
  void Append(const ScanMatch& match);
  std::int64_t size() const { return size_; }

  /// index: 0 to size() - 1. Throws std::runtime_error if the file cannot be read.
  ScanMatch At(std::int64_t index) const;

  /// The match of a scan; nothing if there is none.
  std::optional<ScanMatch> Find(std::int64_t utime) const;

  /// Of all scans the last one up to a time, and the first one behind it; nothing if there is none.
  std::optional<ScanAt> FindUpTo(std::int64_t utime) const;
  std::optional<ScanAt> FindBehind(std::int64_t utime) const;

  /// The least utime of a match that is larger; the largest number if there is none.
  std::int64_t FindNext(std::int64_t utime) const { return utimes_.FindNext(utime); }

  /// All of them, as long as the store is there.
  MatchSequence Sequence() const;

 private:
  std::optional<ScanAt> FindScan(std::optional<std::int64_t> utime) const;

  TemporaryFile file_;
  UtimeIndex utimes_;
  std::int64_t size_ = 0;
};

}  // namespace crsm
