#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace crsm {

/// What a run has come to, as its summary.json says.
struct Outcome {
  std::int64_t scans = 0;
  std::int64_t lost = 0;
  std::int64_t dropped_overload = 0;  ///< scans, in all processes
  std::optional<bool> trusted = {};   ///< the verdict on the map, where there is one
};

/// Nothing if the file is not there, or is no summary.
std::optional<Outcome> ReadOutcome(const std::filesystem::path& summary);

/// With --strict, where the map is not to be trusted.
inline constexpr int kUntrustedExitCode = 3;

/// The last words of a run, on stdout. Returns its exit code: 0, or with `strict` what the verdict on the map deserves;
/// throws std::runtime_error where there is none.
int ReportOutcome(const std::filesystem::path& out, bool strict);

}  // namespace crsm
