#include "tests/experiments/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace crsm {

bool Plan::Has(const std::string& experiment) const {
  return std::find(experiments.begin(), experiments.end(), experiment) != experiments.end();
}

std::string NameOf(const Run& run) {
  return fmt::format("{}_{}_{}_{}_{}_{}", run.source, run.profile, run.method, run.num_evaluations, run.update,
                     run.seed);
}

std::vector<std::string> FlagsOf(const Run& run) {
  const bool simulated = run.source.starts_with("env");
  const std::string preset = !simulated ? "sick" : run.source == "env4" ? "urg-04lx" : "paper";
  std::vector<std::string> flags = {"--profile", run.profile, "--preset", preset};
  const auto Add = [&](const std::string& flag, const std::string& value) {
    flags.push_back(flag);
    flags.push_back(value);
  };
  Add("--method", run.method);
  Add("--num-evaluations", std::to_string(run.num_evaluations));
  Add("--seed", std::to_string(run.seed));
  if (run.source == "env4") Add("--cell-size-m", "0.02");  // the paper's, as in the other environments
  if (run.update != "both") Add("--occupied-density", "1");
  if (run.update == "none") flags.push_back("--no-sparseness-intensity");
  return flags;
}

std::vector<Run> ListRuns(const Plan& plan) {
  std::map<std::string, Run> runs;
  const auto Add = [&](Run run) {
    for (const std::string& profile : kProfiles) {
      for (int seed = 1; seed <= plan.num_seeds; ++seed) {
        run.profile = profile;
        run.seed = seed;
        runs.emplace(NameOf(run), run);
      }
    }
  };
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
  for (const std::string& log : kRadishLogs) {
    if (plan.Has("radish")) Add({log, "", "segments", standard});
  }
  std::vector<Run> list;
  for (const auto& [name, run] : runs) list.push_back(run);
  std::stable_sort(list.begin(), list.end(), [](const Run& a, const Run& b) { return CostOf(a) > CostOf(b); });
  return list;
}

double CostOf(const Run& run) {
  const double rays = run.method == "all" ? (run.source == "env4" ? 600.0 : 270.0) : 60.0;
  const double scans = run.source == "intel" ? 13.6 : run.source == "fr079" ? 4.9 : run.source == "env4" ? 1.5 : 2.4;
  return scans * (rays * run.num_evaluations + 1e5);  // the rest of a scan's work costs about as much as 1e5 rays
}

}  // namespace crsm
