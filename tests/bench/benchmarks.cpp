#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "bench/workloads.hpp"

namespace crsm::bench {
namespace {

/// A drive on which every scan explores tiles, from so many on: the mean is to be the same for all, and the longest
/// scan no pause.
void ScanByTilesExplored(benchmark::State& state) {
  Site site(2000);
  while (site.Explore() < static_cast<std::size_t>(state.range(0))) {
  }
  double max_ms = 0.0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(site.Match(80));
    benchmark::DoNotOptimize(site.Explore());
    const auto end = std::chrono::steady_clock::now();
    max_ms = std::max(max_ms, std::chrono::duration<double, std::milli>(end - start).count());
  }
  state.counters["max_ms"] = max_ms;
}
BENCHMARK(ScanByTilesExplored)->DenseRange(1000, 5000, 1000)->Iterations(150);

}  // namespace
}  // namespace crsm::bench

int main(int argc, char** argv) {
  for (const crsm::bench::Workload& workload : crsm::bench::MakeWorkloads()) {
    benchmark::RegisterBenchmark(workload.name.c_str(), [run = workload.run](benchmark::State& state) {
      for (auto _ : state) run();
    });
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
