#pragma once

#include <string>
#include <vector>

namespace crsm {

/// What is measured on a simulated world or a log.
enum class Measured {
  kRun,       ///< the whole run: its map and its path
  kRightMap,  ///< single matches, each from the true last pose, on the map that the true poses make
  kOwnMap,    ///< single matches on the map that the run makes of its own poses
};

/// One run of the algorithm on one source.
struct Run {
  std::string source;   ///< "env1" to "env4", or a log of the Radish repository: "intel", "fr079"
  std::string profile;  ///< "paper" or "default"
  std::string method = "segments";
  int num_evaluations = 10000;
  std::string update = "both";  ///< of the adjustments of section 6: "both", "sparseness" or "none"
  int seed = 1;
  std::string changed = "";  ///< one of kChanges, empty: none
  Measured measured = Measured::kRun;
};

inline const std::vector<std::string> kProfiles = {"paper", "default"};
inline const std::vector<std::string> kMapped = {"env1", "env2", "env3"};
inline const std::vector<std::string> kSelectionMethods = {"all", "uniform", "density", "segments"};
inline const std::vector<std::string> kUpdates = {"both", "none", "sparseness"};  // as Fig. 25 shows them
inline const std::vector<std::string> kRadishLogs = {"intel", "fr079"};

/// What in one profile is changed into that of the other; the velocity model, which both have, is taken out.
inline const std::vector<std::string> kChanges = {"velocity model",
                                                  "ray selection",
                                                  "matcher",
                                                  "map update",
                                                  "sparse updates",
                                                  "intensity from 0.04 to 0.2",
                                                  "obstacles six times as intense"};

/// What there is to choose from.
inline const std::vector<std::string> kExperiments = {"table1", "table2",  "table3",   "table4", "table5",
                                                      "table6", "fig21",   "fig22",    "fig23",  "fig24",
                                                      "fig25",  "matches", "ablation", "radish"};

struct Plan {
  std::vector<std::string> experiments = kExperiments;
  int num_seeds = 5;
  std::vector<int> evaluations = {100, 500, 1000, 5000, 10000, 20000, 30000};  ///< N_HC of Tables 1 to 3
  int standard_evaluations = 10000;                                            ///< and of all others

  bool Has(const std::string& experiment) const;

  /// The ablation has many kinds of runs, whose differences are large.
  int num_ablation_seeds() const { return num_seeds < 3 ? num_seeds : 3; }
};

/// A name that no other run has, and that is a file name.
std::string NameOf(const Run& run);

/// Every run that the plan's experiments need, each once, the longest first.
std::vector<Run> ListRuns(const Plan& plan);

/// About how long a run takes, in no unit.
double CostOf(const Run& run);

}  // namespace crsm
