#include "tests/experiments/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace crsm {

std::string NameOf(const Run& run) {
  std::string name = fmt::format("{}_{}_{}_{}_{}", run.world, run.profile, run.method, run.num_evaluations, run.seed);
  if (run.measured == Measured::kRightMap) name += "_right map";
  if (run.measured == Measured::kOwnMap) name += "_own map";
  if (!run.changed.empty()) name += "_" + run.changed;
  return name;
}

std::vector<Run> ListRuns(const Plan& plan) {
  std::map<std::string, Run> runs;
  const auto AddSeeds = [&](Run run, int num_seeds) {
    for (const std::string& profile : kProfiles) {
      for (int seed = 1; seed <= num_seeds; ++seed) {
        run.profile = profile;
        run.seed = seed;
        runs.emplace(NameOf(run), run);
      }
    }
  };
  const auto Add = [&](const Run& run) { AddSeeds(run, plan.num_seeds); };
  const int standard = plan.standard_evaluations;
  for (const std::string& world : kTimed) {
    for (const std::string& method : kSelectionMethods) Add({world, "", method, standard});
  }
  for (const std::string& world : kMapped) {
    for (const int evaluations : plan.evaluations) Add({world, "", "segments", evaluations});
    // From the last pose: how far the robot drove is for the search to find.
    AddSeeds({world, "", "segments", standard, 1, "velocity model", Measured::kRightMap}, 1);
    AddSeeds({world, "", "segments", standard, 1, "", Measured::kOwnMap}, 1);
    for (const std::string& change : kChanges) {
      AddSeeds({world, "", "segments", standard, 1, change}, plan.num_ablation_seeds());
    }
  }
  std::vector<Run> list;
  for (const auto& [name, run] : runs) list.push_back(run);
  std::stable_sort(list.begin(), list.end(), [](const Run& a, const Run& b) { return CostOf(a) > CostOf(b); });
  return list;
}

double CostOf(const Run& run) {
  constexpr int kEarly = 1000;  // evaluations after which a search that may stop has mostly stopped
  const double rays = run.method == "all" ? (run.world == "env4" ? 600.0 : 270.0) : 60.0;
  const double scans = run.world == "env4" ? 1.5 : 2.4;
  const bool stops_early = run.profile == "default" && run.changed != "matcher";
  const double evaluations = stops_early ? std::min(run.num_evaluations, kEarly) : run.num_evaluations;
  return scans * (rays * evaluations + 3e5);  // the rest of a scan's work costs about as much as 3e5 rays
}

}  // namespace crsm
