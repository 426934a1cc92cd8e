#pragma once

#include <filesystem>

namespace crsm {

/// The mean fitness that the summary.json in `dir` tells (the paper's MFV). Throws std::runtime_error that names the
/// file and what is wrong with it.
double ReadMeanFitness(const std::filesystem::path& dir);

}  // namespace crsm
