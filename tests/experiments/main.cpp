// The paper's tables and figures, by all cores: scripts/experiments runs it.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <mutex>
#include <sstream>
#include <thread>

#include "tests/experiments/report.hpp"
#include "tests/run_on_threads.hpp"

namespace crsm {
namespace {

struct Options {
  Plan plan;
  std::filesystem::path out = "out/experiments";
  std::filesystem::path radish;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
};

/// The figures of a run that say how it went.
std::string Describe(const Outcome& outcome) {
  std::string text;
  const auto Add = [&](const char* name, double value, int decimals, const char* unit) {
    if (!std::isnan(value)) text += fmt::format("{} {:.{}f}{}, ", name, value, decimals, unit);
  };
  Add("OMSE", outcome.omse_px2, 2, " px2");
  Add("CMSE", outcome.cmse_px2, 2, " px2");
  Add("ATE", outcome.ate_mean_m, 3, " m");
  Add("relations error", outcome.relations_m, 3, " m");
  Add("search missed", outcome.missed, 2, "");
  Add("map misled", outcome.misled, 2, "");
  Add("ms a scan", outcome.cpu_ms, 1, "");
  return text;
}

/// runs.csv: a line a run, appended when it has ended, so that a run that is stopped goes on where it was.
class RunsFile {
 public:
  explicit RunsFile(const std::filesystem::path& path) : path_(path.string()) {
    std::string header = "run";
    Outcome columns;
    VisitFigures(columns, [&](const char* name, double) { header += fmt::format(",{}", name); });
    std::ifstream file(path_);
    std::string line;
    if (std::getline(file, line)) {
      if (line != header) throw std::runtime_error(fmt::format("{} has other columns; start over with --fresh", path_));
      bool ended = true;
      while (std::getline(file, line)) {
        Read(line);
        ended = !file.eof();
      }
      if (!ended) std::ofstream(path_, std::ios::app) << "\n";  // after a line that was cut short
    } else {
      std::ofstream(path_) << header << "\n";
    }
  }

  void Append(const std::string& name, const Outcome& outcome) {
    std::string line = name;
    VisitFigures(outcome,
                 [&](const char*, double value) { line += std::isnan(value) ? ",-" : fmt::format(",{}", value); });
    std::ofstream file(path_, std::ios::app);
    if (!(file << line << "\n" && file.flush())) throw std::runtime_error(fmt::format("cannot write {}", path_));
    outcomes_[name] = outcome;
  }

  const Outcomes& outcomes() const { return outcomes_; }

 private:
  /// A line that was cut short, by a full disk say, is a run that has not been.
  void Read(const std::string& line) {
    std::istringstream words(line);
    std::string name;
    std::getline(words, name, ',');
    Outcome outcome;
    bool whole = true;
    VisitFigures(outcome, [&](const char*, double& value) {
      std::string word;
      whole = whole && std::getline(words, word, ',') && !word.empty();
      if (whole) value = word == "-" ? NAN : std::strtod(word.c_str(), nullptr);
    });
    if (whole) outcomes_[name] = outcome;
  }

  std::string path_;
  Outcomes outcomes_;
};

void RunAll(const Options& options) {
  std::filesystem::create_directories(options.out);
  RunsFile runs_file(options.out / "runs.csv");
  std::vector<Run> runs;
  double cost_left = 0.0;
  for (const Run& run : ListRuns(options.plan)) {
    if (runs_file.outcomes().contains(NameOf(run))) continue;
    runs.push_back(run);
    cost_left += CostOf(run);
  }
  fmt::print(stderr, "experiments: {} runs to do, {} threads\n", runs.size(), options.threads);

  const auto start = std::chrono::steady_clock::now();
  double cost_done = 0.0;
  std::size_t num_done = 0;
  std::mutex mutex;
  const auto RunOne = [&](std::size_t i) {
    const Run& run = runs[i];
    // Of each kind of run but the ablation's the first seed's map is kept.
    const bool keep = run.seed == 1 && run.changed.empty() && run.measured == Measured::kRun;
    const auto folder = keep ? options.out / "maps" / NameOf(run) : std::filesystem::path();
    const Outcome outcome = Measure(run, options.radish, folder);
    const std::lock_guard lock(mutex);
    runs_file.Append(NameOf(run), outcome);
    cost_done += CostOf(run);
    cost_left -= CostOf(run);
    const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    fmt::print(stderr, "[{:3}/{}] {}: {}about {:.0f} min left\n", ++num_done, runs.size(), NameOf(run),
               Describe(outcome), elapsed_s / cost_done * cost_left / 60.0);
  };
  RunOnThreads(runs.size(), options.threads, RunOne, [&](std::size_t i) { return NameOf(runs[i]); });
  WriteReport(options.plan, runs_file.outcomes(), options.out);
  fmt::print("{}\n", (options.out / "results.md").string());
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::Options options;
  std::vector<std::string> names;
  bool quick = false;
  bool fresh = false;
  CLI::App app("The tables and figures of the paper, its figures beside ours.", "experiments");
  app.add_option("NAME", names, "of these only: " + fmt::format("{}", fmt::join(crsm::kExperiments, ", ")))
      ->check(CLI::IsMember(crsm::kExperiments));
  app.add_option("--out", options.out, "folder for the results")->capture_default_str();
  app.add_option("--radish", options.radish, "folder with intel.clf, fr079.clf (or .clf.gz) and their .relations");
  app.add_option("--seeds", options.plan.num_seeds, "runs of each kind")
      ->capture_default_str()
      ->check(CLI::Range(1, 99));
  app.add_option("--threads", options.threads, "runs at a time")->capture_default_str()->check(CLI::Range(1, 256));
  app.add_flag("--quick", quick, "one seed and at most 1000 evaluations: shows that all works");
  app.add_flag("--fresh", fresh, "forget earlier runs: needed when the algorithm has changed");
  CLI11_PARSE(app, argc, argv);
  if (!names.empty()) options.plan.experiments = names;
  if (quick) {
    options.plan.num_seeds = 1;
    options.plan.evaluations = {100, 500, 1000};
    options.plan.standard_evaluations = 1000;
  }
  try {
    if (options.radish.empty()) std::erase(options.plan.experiments, "radish");
    if (options.plan.experiments.empty()) throw std::runtime_error("radish needs --radish FOLDER with the logs");
    if (fresh) {
      std::filesystem::remove(options.out / "runs.csv");
      std::filesystem::remove_all(options.out / "maps");
    }
    crsm::RunAll(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "experiments: {}\n", error.what());
    return 1;
  }
}
