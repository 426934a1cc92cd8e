#pragma once

#include <string>
#include <vector>

namespace crsm {

/// What is measured on a simulated world.
enum class Measured {
  kRun,       ///< the whole run: its map and its path
  kRightMap,  ///< single matches, each from the true last pose, on the map that the true poses make
  kOwnMap,    ///< single matches on the map that the run makes of its own poses
};

/// One run of the algorithm on one source.
struct Run {
  std::string world;    ///< "env1" to "env4"
  std::string profile;  ///< "paper" or "default"
  std::string method = "segments";
  int num_evaluations = 10000;
  int seed = 1;
  std::string changed = "";  ///< one of kChanges, empty: none
  Measured measured = Measured::kRun;
};

inline const std::vector<std::string> kProfiles = {"paper", "default"};
inline const std::vector<std::string> kMapped = {"env1", "env2", "env3"};
inline const std::vector<std::string> kSelectionMethods = {"all", "uniform", "density", "segments"};
inline const std::vector<std::string> kTimed = {"env1", "env2", "env3", "env4"};

/// What in one profile is changed into that of the other; the velocity model, which both have, is taken out.
inline const std::vector<std::string> kChanges = {"velocity model",
                                                  "ray selection",
                                                  "matcher",
                                                  "map update",
                                                  "sparse updates",
                                                  "intensity from 0.04 to 0.2",
                                                  "obstacles six times as intense"};

struct Plan {
  int num_seeds = 5;
  std::vector<int> evaluations = {100, 500, 1000, 5000, 10000, 20000, 30000};  ///< N_HC of Tables 1 to 3
  int standard_evaluations = 10000;                                            ///< and of all others

  /// The ablation has many kinds of runs, whose differences are large.
  int num_ablation_seeds() const { return num_seeds < 3 ? num_seeds : 3; }
};

/// A name that no other run has.
std::string NameOf(const Run& run);

/// Every run that the findings need, each once, the longest first.
std::vector<Run> ListRuns(const Plan& plan);

/// About how long a run takes, in no unit.
double CostOf(const Run& run);

}  // namespace crsm
