#pragma once

#include <string>

#include "common/diagnosis/range_study.hpp"
#include "common/diagnosis/sweep_study.hpp"

namespace crsm {

// What is said of a log's laser and of a live one alike.

/// "8.19 m is no return (30 % of the beams)"; only where there is one.
std::string DescribeNoReturn(const RangeFinding& finding);

/// What was found of a sweep: "each scan takes 0.182 s, clockwise", ", as its messages say" or ", not as its messages
/// say (0.1 s, clockwise)"; of none "the scans show no sweep".
///
/// scan: any one of the laser. who: says what is said, "its messages say".
std::string DescribeSweep(const SweepFinding& finding, const LaserScan& scan, const std::string& who);

}  // namespace crsm
