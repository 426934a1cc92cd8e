#pragma once

#include <string>
#include <vector>

namespace crsm {

/// One run of the algorithm on one source.
struct Run {
  std::string source;   ///< "env1" to "env4", or a log of the Radish repository: "intel", "fr079"
  std::string profile;  ///< "paper" or "default"
  std::string method = "segments";
  int num_evaluations = 10000;
  std::string update = "both";  ///< of the adjustments of section 6: "both", "sparseness" or "none"
  int seed = 1;
};

inline const std::vector<std::string> kProfiles = {"paper", "default"};
inline const std::vector<std::string> kSelectionMethods = {"all", "uniform", "density", "segments"};
inline const std::vector<std::string> kUpdates = {"both", "none", "sparseness"};  // as Fig. 25 shows them
inline const std::vector<std::string> kRadishLogs = {"intel", "fr079"};

/// What there is to choose from.
inline const std::vector<std::string> kExperiments = {"table1", "table2", "table3", "table4", "table5", "table6",
                                                      "fig21",  "fig22",  "fig23",  "fig24",  "fig25",  "radish"};

struct Plan {
  std::vector<std::string> experiments = kExperiments;
  int num_seeds = 5;
  std::vector<int> evaluations = {100, 500, 1000, 5000, 10000, 20000, 30000};  ///< N_HC of Tables 1 to 3
  int standard_evaluations = 10000;                                            ///< and of all others

  bool Has(const std::string& experiment) const;
};

/// A name that no other run has, and that is a file name.
std::string NameOf(const Run& run);

/// The flags of slam_offline that make this run.
std::vector<std::string> FlagsOf(const Run& run);

/// Every run that the plan's experiments need, each once, the longest first.
std::vector<Run> ListRuns(const Plan& plan);

/// About how long a run takes, in no unit.
double CostOf(const Run& run);

}  // namespace crsm
