#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "common/logs/replacement.hpp"

namespace crsm {

/// Writes a finished run as an MCAP file, to be looked at along its time in Foxglove or Lichtblick: each scan and where
/// it was taken, and fifty times along the run the path and what has changed of the map, as it was known then.
/// Throws std::runtime_error as ReadFinishedRun, or if the file cannot be written; it is there as a whole or not at
/// all.
void WriteMcap(const std::string& results, const std::filesystem::path& file);

/// The same piece by piece. Throws std::runtime_error once `is_stopped` says so, which is asked after each
/// scan, with how many there were and what share of all they are; also if `sink` throws.
void WriteMcap(const std::string& results, const Sink& sink,
               const std::function<bool(std::int64_t num_scans, double share)>& is_stopped);

}  // namespace crsm
