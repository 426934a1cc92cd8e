#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "services/base/path_lock.hpp"
#include "services/journal/earlier_results.hpp"

namespace crsm {

/// The --out of a stack: results, journal/ and log/. It is this process's alone as long as this object lives.
class ResultsFolder {
 public:
  /// Makes the folder, if need be, ready for a run (MakeRoom). Throws std::runtime_error in one line if results are in
  /// the way, if another process writes there, or if the folder cannot be written.
  ResultsFolder(const std::filesystem::path& out, const EarlierResults& earlier);

  /// What an earlier run has said stays where this one has said nothing.
  ~ResultsFolder();
  ResultsFolder(const ResultsFolder&) = delete;

  const std::filesystem::path& path() const { return out_; }
  std::filesystem::path journal_folder() const { return out_ / "journal"; }
  std::filesystem::path log_folder() const { return out_ / "log"; }
  std::filesystem::path summary() const { return out_ / "summary.json"; }

  /// Of what the map is that goes on, as of RunOrigin; empty if none does.
  const std::string& earlier_made_from() const { return made_from_; }

  /// Size of the journal [bytes]; nothing if there is none.
  std::optional<std::uintmax_t> JournalBytes() const;

  /// Why nothing can be written there, by trying it; empty where it can be. What the processes say of a disk that is
  /// full, or has become read-only, has no place there either.
  std::string WhyNotWritable() const;

  /// Whether nobody has removed or moved the folder, nor the journal once there was one, nor put that of another map in
  /// its place.
  bool IsInPlace();

 private:
  bool HasOwnJournal();
  std::filesystem::path earlier_summary() const { return out_ / ".summary.earlier.json"; }

  std::filesystem::path out_;
  std::string made_from_;
  std::optional<PathLock> log_lock_;
  bool had_journal_ = false;
  std::optional<std::int64_t> identity_;  ///< of the map, since the journal has a scan
};

}  // namespace crsm
