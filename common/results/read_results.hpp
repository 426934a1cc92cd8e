#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace crsm {

/// The mean fitness that the summary.json in `dir` tells (the paper's MFV). Throws std::runtime_error that names the
/// file and what is wrong with it.
double ReadMeanFitness(const std::filesystem::path& dir);

/// What a summary.json tells of a run, where many are to be compared. What it does not tell is left out.
struct RunSummary {
  std::int64_t scans = 0;
  std::int64_t floating = 0;
  std::int64_t lost = 0;
  std::int64_t without_rays = 0;
  std::int64_t left_out = 0;
  std::optional<std::int64_t> loops;  ///< closed
  double mean_fitness = 0.0;
  std::string trust;  ///< as Name(Trust)
  std::optional<double> wall_s;
  std::string made_from;        ///< as of RunOrigin; empty where nobody knows, and so are the next two
  std::string recorded;         ///< as of FormatUtc
  std::string mapped;           ///< likewise
  std::optional<double> off_m;  ///< so far off the map may be
  std::string identity;         ///< of the map, as that of its journal; empty where it has none
};

/// What the map in `dir` was made from, as of RunOrigin; empty where its summary.json does not say.
std::string ReadMadeFrom(const std::filesystem::path& dir);

/// Throws std::runtime_error as ReadMap.
RunSummary ReadSummary(const std::filesystem::path& dir);

}  // namespace crsm
