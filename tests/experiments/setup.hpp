#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/slam.hpp"
#include "tests/experiments/plan.hpp"

namespace crsm {

/// What a run is made with.
struct Setup {
  Parameters parameters;
  Slam::Parts parts;
  Slam::Constants constants;
};

/// By the run's profile, its laser, and what it changes.
Setup SetUp(const Run& run);

/// How many rays a profile picks.
struct Band {
  int low, high;
};
Band BandOf(const std::string& profile);

}  // namespace crsm
