#pragma once

#include <string>

#include "common/diagnosis/range_study.hpp"
#include "common/diagnosis/sweep_study.hpp"

namespace crsm {

// What is said of a log's laser and of a live one alike.

/// "8.19 m is no return (30 % of the beams)"; only where there is one.
std::string DescribeNoReturn(const RangeFinding& finding);

/// Why a sweep is not the one that was said: "24 scans that turn fit better HOW", or that the period is another.
std::string ExplainSweep(const SweepFinding& finding, const std::string& how);

}  // namespace crsm
