#include <fmt/format.h>

#include <cstdio>
#include <numeric>
#include <thread>

#include "accuracy/gate.hpp"
#include "accuracy/run.hpp"
#include "catch.hpp"
#include "run_on_threads.hpp"

namespace crsm {
namespace {

/// Maps a drive with loops, prints a line of the table, and returns what it came to.
Outcome CloseLoops(const Drive& drive, int seed) {
  const Outcome outcome = Map(drive, ShippedParameters(drive.preset, static_cast<std::uint64_t>(seed), drive.flags));
  fmt::print(
      "{:<10} seed {:>3}  loops {:>2}, of which the worst is off by {:.3f} m  worst {:.3f} m  rmse {:.3f} m, aligned "
      "{:.3f} m\n",
      drive.source, seed, outcome.graph.loops().size(), outcome.worst_loop_m, outcome.worst_m, outcome.error_m,
      outcome.aligned_m);
  std::fflush(stdout);
  return outcome;
}

}  // namespace

TEST_CASE("a round about a block that is bent is closed, and every loop is right") {
  for (int seed = 1; seed <= NumSeeds(4); ++seed) {
    const Outcome outcome = CloseLoops({"sim:block", "sick"}, seed);
    CHECK(outcome.graph.loops().size() >= 2);
    CHECK(outcome.worst_loop_m < kRightLoop_m);
  }
}

// Of the seeds 1 to 12 the mean is 0.056 m, the worst 0.073 m. With walls that are believed bit by bit, or joined to
// doors that stand back, each match is a little too far back, and the mean of these four is 0.067 m and more.
TEST_CASE("a drive of 3 km through a campus comes out as long as it was") {
  const int num_seeds = NumSeeds(4);
  double sum_m = 0.0;
  for (int seed = 1; seed <= num_seeds; ++seed) {
    const Outcome outcome = CloseLoops({"sim:campus:3000:4", "sick"}, seed);
    CHECK(outcome.worst_loop_m < kRightLoop_m);
    sum_m += outcome.aligned_m;
  }
  CHECK(sum_m / num_seeds < 0.065);
}

TEST_CASE("in buildings that are alike to themselves no wrong loop is closed") {
  for (const std::string world : {"sim:twins", "sim:rooms", "sim:symmetric"}) {
    for (int seed = 1; seed <= NumSeeds(2); ++seed) {
      CHECK(CloseLoops({world, "sick"}, seed).worst_loop_m < kRightLoop_m);
      // Bent by some metres, what is alike comes to lie nearer to each other.
      CHECK(CloseLoops({world, "sick", "", {}, {"--angle-scale", "1.01"}}, seed).worst_loop_m < kRightLoop_m);
    }
  }
}

namespace {

/// A row of the table: runs of one kind, with loops or without.
struct Kind {
  std::string title;
  std::string source;  ///< with {} for the seed: a campus of its own for each
  bool loops = true;
  double end_share = 0.2;  ///< of a drive: its first and its last part, whose costs are compared
  std::vector<Outcome> runs = {};
};

template <class Figure>
std::vector<double> Each(const std::vector<Outcome>& runs, Figure figure) {
  std::vector<double> values;
  for (const Outcome& run : runs) values.push_back(static_cast<double>(figure(run)));
  return values;
}

double Most(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

/// What it costs to match and draw a scan in the last part of a drive, as a multiple of that in the first.
double ComputeSlowdown(const Outcome& run, double end_share) {
  const auto part = static_cast<std::ptrdiff_t>(end_share * static_cast<double>(run.cpu_s.size()));
  const double first_s = std::accumulate(run.cpu_s.begin(), run.cpu_s.begin() + part, 0.0);
  return std::accumulate(run.cpu_s.end() - part, run.cpu_s.end(), 0.0) / first_s;
}

}  // namespace

// scripts/experiments loops runs it. Errors are the root mean square of the distance from the true path, once the whole
// path is aligned with it. A loop is wrong if it is off by kRightLoop_m. The cost of a scan is that in the last
// kilometre of a campus, or fifth of another drive, as a multiple of that in the first; loops are searched beside.
TEST_CASE("prints a table of drives with loops and without", "[.loops]") {
  std::vector<Kind> kinds;
  for (const bool loops : {true, false}) {
    for (const int length_m : {10000, 3000}) {
      kinds.push_back({fmt::format("campus, {} km", length_m / 1000), fmt::format("sim:campus:{}:{{}}", length_m),
                       loops, 1000.0 / length_m});
    }
    for (const std::string world : {"block", "twins", "symmetric", "rooms"}) {
      kinds.push_back({"`sim:" + world + "`", "sim:" + world, loops});
    }
  }
  const auto num_seeds = static_cast<std::size_t>(NumSeeds(5));
  for (Kind& kind : kinds) kind.runs.resize(num_seeds);
  RunOnThreads(
      kinds.size() * num_seeds, static_cast<int>(std::max(1u, std::thread::hardware_concurrency())),
      [&](std::size_t i) {
        Kind& kind = kinds[i / num_seeds];
        const std::uint64_t seed = i % num_seeds + 1;
        const std::vector<std::string> flags =
            kind.loops ? std::vector<std::string>{} : std::vector<std::string>{"--no-loops"};
        kind.runs[i % num_seeds] =
            Map({fmt::format(fmt::runtime(kind.source), seed)}, ShippedParameters("sick", seed, flags));
      },
      [&](std::size_t i) { return kinds[i / num_seeds].title; });
  fmt::print("| drive | loops | runs | error, median [m] | worst | loops closed, median | wrong | cost of a scan |\n");
  for (const auto& [title, source, loops, end_share, runs] : kinds) {
    const std::vector<double> errors_m = Each(runs, [](const Outcome& run) { return run.aligned_m; });
    const std::vector<double> loops_m = Each(runs, [](const Outcome& run) { return run.worst_loop_m; });
    fmt::print("| {} | {} | {} | {:.3f} | {:.3f} | {:g} | {} | {:.2f} |\n", title, loops ? "yes" : "no", runs.size(),
               Median(errors_m), Most(errors_m),
               Median(Each(runs, [](const Outcome& run) { return run.graph.loops().size(); })),
               std::count_if(loops_m.begin(), loops_m.end(), [](double off_m) { return off_m >= kRightLoop_m; }),
               Median(Each(runs, [&, share = end_share](const Outcome& run) { return ComputeSlowdown(run, share); })));
  }
}

}  // namespace crsm
