#include "tests/experiments/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace crsm {

bool Plan::Has(const std::string& experiment) const {
  return std::find(experiments.begin(), experiments.end(), experiment) != experiments.end();
}

std::string NameOf(const Run& run) {
  std::string name =
      fmt::format("{}_{}_{}_{}_{}_{}", run.source, run.profile, run.method, run.num_evaluations, run.update, run.seed);
  if (run.measured == Measured::kRightMap) name += "_right map";
  if (run.measured == Measured::kOwnMap) name += "_own map";
  if (!run.changed.empty()) name += "_" + run.changed;
  std::replace(name.begin(), name.end(), ' ', '-');
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
  const bool curves = plan.Has("fig21") || plan.Has("fig22") || plan.Has("fig23");
  for (const std::string number : {"1", "2", "3", "4"}) {
    const std::string world = "env" + number;
    if (number != "4") {
      for (const int evaluations : plan.evaluations) {
        if (curves || plan.Has("table" + number)) Add({world, "", "segments", evaluations});
      }
      if (plan.Has("fig24")) Add({world, "", "segments", standard});
    }
    for (const std::string& method : kSelectionMethods) {
      const bool errors = number != "4" && (plan.Has("table4") || plan.Has("table5"));
      if (errors || plan.Has("table6")) Add({world, "", method, standard});
    }
  }
  for (const std::string& update : kUpdates) {
    if (plan.Has("fig25")) Add({"env2", "", "segments", standard, update});
  }
  for (const std::string& world : kMapped) {
    if (plan.Has("matches")) {
      // From the last pose: how far the robot drove is for the search to find.
      AddSeeds({world, "", "segments", standard, "both", 1, "velocity model", Measured::kRightMap}, 1);
      AddSeeds({world, "", "segments", standard, "both", 1, "", Measured::kOwnMap}, 1);
    }
    if (!plan.Has("ablation")) continue;
    Add({world, "", "segments", standard});
    for (const std::string& change : kChanges) {
      AddSeeds({world, "", "segments", standard, "both", 1, change}, plan.num_ablation_seeds());
    }
  }
  for (const std::string& log : kRadishLogs) {
    if (plan.Has("radish")) Add({log, "", "segments", standard});
  }
  std::vector<Run> list;
  for (const auto& [name, run] : runs) list.push_back(run);
  std::stable_sort(list.begin(), list.end(), [](const Run& a, const Run& b) { return CostOf(a) > CostOf(b); });
  return list;
}

double CostOf(const Run& run) {
  constexpr int kEarly = 1000;  // evaluations after which a search that may stop has mostly stopped
  const double rays = run.method == "all" ? (run.source == "env4" ? 600.0 : 270.0) : 60.0;
  const double scans = run.source == "intel" ? 13.6 : run.source == "fr079" ? 4.9 : run.source == "env4" ? 1.5 : 2.4;
  const bool stops_early = run.profile == "default" && run.changed != "matcher";
  const double evaluations = stops_early ? std::min(run.num_evaluations, kEarly) : run.num_evaluations;
  return scans * (rays * evaluations + 3e5);  // the rest of a scan's work costs about as much as 3e5 rays
}

}  // namespace crsm
