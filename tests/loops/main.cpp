// Long drives with and without loops, and buildings that are alike to themselves, in which no wrong loop must be
// closed: scripts/experiments loops runs it.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <mutex>
#include <numeric>
#include <thread>

#include "accuracy/run.hpp"
#include "run_on_threads.hpp"

namespace crsm {
namespace {

/// A row of the table.
struct Kind {
  std::string title;
  bool loops = true;
  double end_share = 0.2;  ///< of a drive: its first and its last part, whose costs are compared
  std::vector<Outcome> runs = {};
};

struct Task {
  std::size_t kind = 0;
  Drive drive;
  int seed = 0;
};

struct Options {
  int num_seeds = 5;
  std::vector<double> lengths_m = {3000.0, 10000.0};
  std::filesystem::path out = "out/experiments";
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
};

/// The tasks, the longest first, and a kind for each row.
std::vector<Task> ListTasks(const Options& options, std::vector<Kind>& kinds) {
  std::vector<Task> tasks;
  const auto Add = [&](const std::string& title, bool loops, double end_share, const auto& SourceOf) {
    for (int seed = 1; seed <= options.num_seeds; ++seed) {
      Drive drive{SourceOf(seed), "sick"};
      if (!loops) drive.flags.push_back("--no-loops");
      tasks.push_back({kinds.size(), drive, seed});
    }
    kinds.push_back({title, loops, end_share});
  };
  std::vector<double> lengths_m = options.lengths_m;
  std::sort(lengths_m.rbegin(), lengths_m.rend());
  for (const double length_m : lengths_m) {
    for (const bool loops : {true, false}) {
      // A campus of its own for each seed.
      Add(fmt::format("campus, {:g} km", length_m / 1000.0), loops, std::min(1000.0 / length_m, 0.5),
          [&](int seed) { return fmt::format("sim:campus:{:g}:{}", length_m, seed); });
    }
  }
  for (const std::string world : {"block", "twins", "symmetric", "rooms"}) {
    for (const bool loops : {true, false}) Add(world, loops, 0.2, [&](int) { return "sim:" + world; });
  }
  return tasks;
}

/// The median of a figure over the runs, and the worst.
template <class Figure>
std::pair<double, double> Spread(const std::vector<Outcome>& runs, Figure figure) {
  std::vector<double> values;
  for (const Outcome& run : runs) values.push_back(figure(run));
  std::sort(values.begin(), values.end());
  return {0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]), values.back()};
}

/// What it costs to match and draw a scan in the last part of a drive, as a multiple of that in the first.
double ComputeSlowdown(const Outcome& run, double end_share) {
  const auto part = static_cast<std::ptrdiff_t>(end_share * static_cast<double>(run.cpu_s.size()));
  const double first_s = std::accumulate(run.cpu_s.begin(), run.cpu_s.begin() + part, 0.0);
  return std::accumulate(run.cpu_s.end() - part, run.cpu_s.end(), 0.0) / first_s;
}

std::string FormatPage(const std::vector<Kind>& kinds) {
  std::string page = fmt::format(
      "Root mean square of the distance from the true path, once the whole path is aligned with it, and as it is: from "
      "where it starts. A loop is wrong if it is off by {:g} m. The cost of a scan is what it takes to match and draw "
      "it in the last kilometre of a campus, or fifth of another drive, as a multiple of that in the first; loops are "
      "searched beside.\n\n"
      "| drive | loops | runs | error, median [m] | worst | not aligned, median | worst | loops closed, median | wrong "
      "| lost, worst [%] | cost of a scan |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
      kRightLoop_m);
  for (const Kind& kind : kinds) {
    const auto [error_m, worst_m] = Spread(kind.runs, [](const Outcome& run) { return run.aligned_m; });
    const auto [start_m, worst_start_m] = Spread(kind.runs, [](const Outcome& run) { return run.error_m; });
    const auto num_loops = Spread(kind.runs, [](const Outcome& run) { return run.num_loops; }).first;
    const auto lost = Spread(kind.runs, [](const Outcome& run) { return run.lost; }).second;
    const auto num_wrong = std::count_if(kind.runs.begin(), kind.runs.end(),
                                         [](const Outcome& run) { return run.worst_loop_m >= kRightLoop_m; });
    const auto slowdown = Spread(kind.runs, [&](const Outcome& run) { return ComputeSlowdown(run, kind.end_share); });
    page += fmt::format("| {} | {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {} | {} | {:.2f} | {:.2f} |\n",
                        kind.title, kind.loops ? "yes" : "no", kind.runs.size(), error_m, worst_m, start_m,
                        worst_start_m, num_loops, num_wrong, 100.0 * lost, slowdown.first);
  }
  return page;
}

void RunAll(const Options& options) {
  std::vector<Kind> kinds;
  const std::vector<Task> tasks = ListTasks(options, kinds);
  std::mutex mutex;
  std::size_t num_done = 0;
  const auto NameOf = [&](std::size_t i) { return fmt::format("{}, seed {}", tasks[i].drive.source, tasks[i].seed); };
  const auto RunTask = [&](std::size_t i) {
    const auto& [kind, drive, seed] = tasks[i];
    const Outcome outcome = Map(drive, ShippedParameters(drive.preset, static_cast<std::uint64_t>(seed), drive.flags));
    const std::lock_guard lock(mutex);
    fmt::print(stderr, "[{:3}/{}] {}, {}: {:.3f} m, {} loops\n", ++num_done, tasks.size(), NameOf(i),
               kinds[kind].loops ? "loops" : "no loops", outcome.aligned_m, outcome.num_loops);
    kinds[kind].runs.push_back(outcome);
  };
  RunOnThreads(tasks.size(), options.threads, RunTask, NameOf);

  std::filesystem::create_directories(options.out);
  const std::string path = (options.out / "loops.md").string();
  std::ofstream file(path);
  if (!(file << FormatPage(kinds) && file.flush())) throw std::runtime_error(fmt::format("cannot write {}", path));
  fmt::print("{}\n", path);
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::Options options;
  CLI::App app("Long drives with and without loops, and buildings that are alike to themselves.", "loop_experiments");
  app.add_option("--out", options.out, "folder for loops.md")->capture_default_str();
  app.add_option("--seeds", options.num_seeds, "runs of each kind")->capture_default_str()->check(CLI::Range(1, 99));
  app.add_option("--lengths-m", options.lengths_m, "of the drives through campuses [m]")
      ->capture_default_str()
      ->check(CLI::Range(100.0, 100'000.0));
  app.add_option("--threads", options.threads, "runs at a time")->capture_default_str()->check(CLI::Range(1, 256));
  CLI11_PARSE(app, argc, argv);
  try {
    crsm::RunAll(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "loop_experiments: {}\n", error.what());
    return 1;
  }
}
