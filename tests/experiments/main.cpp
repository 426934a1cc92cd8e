// Which of the paper's conclusions hold in its worlds, by all cores: scripts/experiments runs it.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <mutex>
#include <thread>

#include "tests/experiments/findings.hpp"
#include "tests/run_on_threads.hpp"

namespace crsm {
namespace {

/// The figures of a run that say how it went.
std::string Describe(const Outcome& outcome) {
  std::string text;
  const auto Add = [&](const char* name, double value, int decimals, const char* unit) {
    if (!std::isnan(value)) text += fmt::format("{} {:.{}f}{}, ", name, value, decimals, unit);
  };
  Add("OMSE", outcome.omse_px2, 2, " px2");
  Add("CMSE", outcome.cmse_px2, 2, " px2");
  Add("ATE", outcome.ate_mean_m, 3, " m");
  Add("search missed", outcome.missed, 2, "");
  Add("map misled", outcome.misled, 2, "");
  Add("ms a scan", outcome.cpu_ms, 1, "");
  return text;
}

Outcomes RunAll(const Plan& plan, int num_threads) {
  const std::vector<Run> runs = ListRuns(plan);
  double cost_left = 0.0;
  for (const Run& run : runs) cost_left += CostOf(run);
  fmt::print(stderr, "experiments: {} runs to do, {} threads\n", runs.size(), num_threads);

  Outcomes outcomes;
  const auto start = std::chrono::steady_clock::now();
  double cost_done = 0.0;
  std::mutex mutex;
  const auto RunOne = [&](std::size_t i) {
    const Run& run = runs[i];
    const Outcome outcome = Measure(run);
    const std::lock_guard lock(mutex);
    outcomes[NameOf(run)] = outcome;
    cost_done += CostOf(run);
    cost_left -= CostOf(run);
    const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    fmt::print(stderr, "[{:3}/{}] {}: {}about {:.0f} min left\n", outcomes.size(), runs.size(), NameOf(run),
               Describe(outcome), elapsed_s / cost_done * cost_left / 60.0);
  };
  RunOnThreads(runs.size(), num_threads, RunOne, [&](std::size_t i) { return NameOf(runs[i]); });
  return outcomes;
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::Plan plan;
  std::filesystem::path out = "out/experiments";
  int num_threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool quick = false;
  CLI::App app("The paper's figures beside ours.", "experiments");
  app.add_option("--out", out, "folder for results.md")->capture_default_str();
  app.add_option("--seeds", plan.num_seeds, "runs of each kind")->capture_default_str()->check(CLI::Range(1, 99));
  app.add_option("--threads", num_threads, "runs at a time")->capture_default_str()->check(CLI::Range(1, 256));
  app.add_flag("--quick", quick, "one seed and at most 1000 evaluations: shows that all works");
  CLI11_PARSE(app, argc, argv);
  if (quick) {
    plan.num_seeds = 1;
    plan.evaluations = {100, 500, 1000};
    plan.standard_evaluations = 1000;
  }
  try {
    std::filesystem::create_directories(out);
    const std::string text = crsm::WriteFindings(plan, crsm::RunAll(plan, num_threads));
    std::ofstream file(out / "results.md");
    if (!(file << text && file.flush())) throw std::runtime_error(fmt::format("cannot write {}", out.string()));
    fmt::print("{}\n", (out / "results.md").string());
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "experiments: {}\n", error.what());
    return 1;
  }
}
