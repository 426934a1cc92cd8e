#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/diagnosis/changes.hpp"
#include "common/scan/scan_counts.hpp"
#include "services/diagnosis/changes_over.hpp"

namespace crsm {

/// What a run has come to, as its summary.json says.
struct Outcome {
  bool ended = false;  ///< else it is of some scan on the way
  ScanCounts counts = {};
  std::vector<std::string> verdict = {};  ///< for people: the counts, and what speaks against the map
  bool trusted = false;
  std::optional<std::vector<MapChange>> changes = {};  ///< where the run localised
  std::int64_t dropped_overload = 0;                   ///< scans, in all processes
  std::string identity = {};                           ///< of the map; empty where it has no journal
};

/// Nothing if the file is not there, or is no summary.
std::optional<Outcome> ReadOutcome(const std::filesystem::path& summary);

/// The last words of a run, on stdout. Returns its exit code: 0, or with `strict` kUntrustedExitCode where the map is
/// not to be trusted, or kChangedExitCode where `changes_over` is exceeded. Throws std::runtime_error where there is a
/// summary of some scan on the way and none of the end, where the summary and the journal are of two maps, and with
/// `strict` where there is none at all.
int ReportOutcome(const std::filesystem::path& out, bool strict, const ChangesOver& changes_over = {});

}  // namespace crsm
