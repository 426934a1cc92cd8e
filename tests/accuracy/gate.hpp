#pragma once

#include <string>
#include <vector>

#include "accuracy/courses.hpp"

namespace crsm {

/// How many seeds to take: as many as usual; with CRSM_ACCURACY_SEEDS=N in the environment N, to find what the bounds
/// should be.
int NumSeeds(int usual);

/// Maps all courses with all their seeds on all cores, the first seed of each before the second, prints a table, and
/// returns what is out of bounds, a line each.
///
/// CRSM_STOP_AT_FIRST in the environment: no run begins after one that is out of bounds.
std::vector<std::string> RunGate(std::vector<Course> courses);

}  // namespace crsm
