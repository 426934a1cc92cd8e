#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"
#include "services/runtime/event_log_writer.hpp"

namespace crsm {

/// What a journal is to be of; one of something else is refused.
struct JournalSubject {
  double cell_size_m = 0.0;   ///< of the map
  bool finished_map = false;  ///< localization on the map of another journal; else the map is made of this one
};

/// Called for each entry of a journal; the scan is nullptr where none was drawn.
using VisitJournal = std::function<void(const CriticalRays* scan, const ScanMatch& match)>;

/// Everything that a map is made of, on the disk as it happens: FOLDER/journal.lcm, an LCM log that lcm-logplayer and
/// lcm-spy read too. First an empty map_delta_t that says the map's epoch (MAP_EPOCH; FINISHED_MAP_EPOCH where the
/// journal is of a localization), then for every match the scan (CRITICAL_RAYS) if it was drawn, and the match
/// (SCAN_MATCH).
class Journal {
 public:
  /// Begins a new journal, of a new epoch. Throws std::runtime_error if there is one already, or if it cannot be
  /// written.
  Journal(const std::filesystem::path& folder, const JournalSubject& subject);

  /// Reads the journal in `folder` from its beginning, then goes on writing at its end. A tail that was torn by a crash
  /// is cut off after the last whole event; `num_cut_bytes` then says how much. Throws std::runtime_error if there is
  /// no journal, if it is damaged elsewhere or of another subject, or if it cannot be written.
  Journal(const std::filesystem::path& folder, const JournalSubject& subject, const VisitJournal& visit);

  /// Of the map: drawn by who began the journal.
  std::int64_t epoch() const { return epoch_; }
  std::uintmax_t num_cut_bytes() const { return num_cut_bytes_; }

  /// Keeps one match, and its scan where it was drawn (else nullptr), handed to the operating system when this returns:
  /// it survives the end of the process. Throws std::runtime_error if it cannot be written.
  void Append(const CriticalRays* scan, const ScanMatch& match);

 private:
  JournalSubject subject_;
  std::int64_t epoch_;
  bool epoch_written_ = false;
  std::uintmax_t num_cut_bytes_ = 0;
  std::optional<EventLogWriter> log_;
};

/// Reads a journal and leaves it as it is. Throws as the second constructor.
void ReadJournal(const std::filesystem::path& folder, const JournalSubject& subject, const VisitJournal& visit);

/// Where run_stack and slam_offline keep the journal of a folder of results.
inline std::filesystem::path JournalFolder(const std::filesystem::path& out) { return out / "journal"; }

/// Makes `out` the folder in which the map of `earlier` goes on: its journal is copied, unless they are the same
/// folder. Throws std::runtime_error if there is none, or if it cannot be copied.
void TakeOverJournal(const std::filesystem::path& earlier, const std::filesystem::path& out);

/// Makes room for a new journal in a folder of results.
void RemoveJournal(const std::filesystem::path& out);

}  // namespace crsm
