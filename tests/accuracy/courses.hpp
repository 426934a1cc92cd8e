#pragma once

#include <string>
#include <vector>

#include "accuracy/run.hpp"

namespace crsm {

/// What the runs of a course may come to: at most, and the fitness at least. Errors as of Outcome; infinite where there
/// is no truth.
struct Bounds {
  double worst_m = 0.0;    ///< the worst error of any run
  double typical_m = 0.0;  ///< the worst error of a run, the median over the runs
  double mean_m = 0.0;     ///< the error of a run, the mean over the runs
  double lost = 0.0;       ///< the share of lost scans of any run
  double fitness = 0.0;    ///< the mean fitness of any run
};

/// A drive that is mapped with the seeds 1 to `num_seeds`, and what is asked of it.
struct Course {
  std::string name;
  Drive drive;
  int num_seeds = 0;
  Bounds bounds;
};

/// In this order a broken matcher shows soonest.
std::vector<Course> SimulatedCourses();

/// Of the real logs, those that are there; what is missing is said.
std::vector<Course> RealCourses();

}  // namespace crsm
