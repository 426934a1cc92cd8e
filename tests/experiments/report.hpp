#pragma once

#include <filesystem>

#include "tests/experiments/outcome.hpp"
#include "tests/experiments/plan.hpp"

namespace crsm {

/// Writes results.md into `out`: each table of the plan with the paper's figures beside ours, and the figures, drawn by
/// gnuplot as SVG files beside it. Runs without an outcome are shown as such. Throws std::runtime_error if a file
/// cannot be written or gnuplot fails.
void WriteReport(const Plan& plan, const Outcomes& outcomes, const std::filesystem::path& out);

}  // namespace crsm
