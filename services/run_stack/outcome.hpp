#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace crsm {

/// What a run has come to, as its summary.json says.
struct Outcome {
  std::int64_t scans = 0;
  std::int64_t lost = 0;                  ///< of those
  std::vector<std::string> verdict = {};  ///< for people: the counts, and what speaks against the map
  bool trusted = false;
  std::int64_t dropped_overload = 0;  ///< scans, in all processes
};

/// Nothing if the file is not there, or is no summary.
std::optional<Outcome> ReadOutcome(const std::filesystem::path& summary);

/// The last words of a run, on stdout. Returns its exit code: 0, or with `strict` kUntrustedExitCode where the map is
/// not to be trusted. With `strict` throws std::runtime_error where there is no verdict.
int ReportOutcome(const std::filesystem::path& out, bool strict);

}  // namespace crsm
