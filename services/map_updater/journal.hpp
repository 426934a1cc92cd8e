#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "common/laser_scan.hpp"
#include "common/scan_match.hpp"
#include "services/runtime/event_log_writer.hpp"

namespace crsm {

/// Everything that a map is made of, on the disk as it happens: FOLDER/journal.lcm, an LCM log that lcm-logplayer and
/// lcm-spy read too. For every match the scan (LASER) if there was one, then the match (SCAN_MATCH).
class Journal {
 public:
  /// Begins a new journal. Throws std::runtime_error if there is one already, or if it cannot be written.
  explicit Journal(const std::filesystem::path& folder);

  /// Called for each entry of a journal; the scan is nullptr where none came.
  using Visit = std::function<void(const LaserScan* scan, const ScanMatch& match)>;

  /// Reads the journal in `folder` from its beginning, then goes on writing at its end. A tail that was torn by a crash
  /// is cut off after the last whole event; `num_cut_bytes` then says how much. Throws std::runtime_error if there is
  /// no journal, if it is damaged elsewhere, or if it cannot be written.
  Journal(const std::filesystem::path& folder, const Visit& visit);

  std::uintmax_t num_cut_bytes() const { return num_cut_bytes_; }

  /// Keeps one match, handed to the operating system when this returns: it survives the end of the process. Throws
  /// std::runtime_error if it cannot be written.
  void Append(const LaserScan* scan, const ScanMatch& match);

 private:
  std::uintmax_t num_cut_bytes_ = 0;
  std::optional<EventLogWriter> log_;
};

}  // namespace crsm
