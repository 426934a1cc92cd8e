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
  std::int64_t lost = 0;
  std::optional<std::int64_t> loops;  ///< closed
  double mean_fitness = 0.0;
  std::string trust;  ///< as Name(Trust)
  std::optional<double> wall_s;
};

/// Throws std::runtime_error as ReadMap.
RunSummary ReadSummary(const std::filesystem::path& dir);

}  // namespace crsm
