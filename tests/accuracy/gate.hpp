#pragma once

#include <string>
#include <vector>

#include "accuracy/courses.hpp"

namespace crsm {

/// Maps all courses with all their seeds on all cores, the first seed of each before the second, prints a table, and
/// returns what is out of bounds, a line each.
///
/// CRSM_STOP_AT_FIRST in the environment: no run begins after one that is out of bounds.
/// CRSM_ACCURACY_SEEDS=N: N seeds of each course, to find what the bounds should be.
std::vector<std::string> RunGate(std::vector<Course> courses);

}  // namespace crsm
