// slam_offline: a log or a simulated world -> map and trajectory, in one process without messages. The oracle that the
// five processes are tested against.

#include <fmt/core.h>

#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "common/slam.hpp"
#include "services/runtime/progress.hpp"
#include "services/runtime/service.hpp"
#include "services/runtime/version.hpp"
#include "services/sources/open_laser_source.hpp"

namespace crsm {
namespace {

void MapLog(const CommandLine& command_line, const std::string& name) {
  const Settings& settings = command_line.settings();
  const Parameters& parameters = command_line.parameters();
  const auto source = OpenLaserSource(name, {parameters.match.seed, settings.laser_channel});
  PrepareFolder(settings.out);

  Slam slam(parameters);
  Results results;
  Latency latency;
  Progress progress(command_line.program());
  while (auto scan = source->Next()) {
    if (StopRequested()) break;
    const auto start = Clock::now();
    slam.Process(*scan, source->Odometry());
    latency.Record(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    if (const auto T_map_laser = source->TruePose()) results.truth.push_back({scan->utime, *T_map_laser});
    results.last_scan = std::move(*scan);
    progress.Show(source->Progress(), latency.num_recorded());
  }
  progress.Finish(latency.num_recorded());

  results.grid = slam.map().ToDenseGrid(slam.geometry().cell_size_m());
  results.matches = slam.history();
  results.scan_parameters = parameters.scan;
  Summary summary = Summarize(results.matches, results.grid);
  summary.version = kVersion;
  summary.parameters = ListParameters(parameters);
  summary.map_version = static_cast<std::int64_t>(slam.history().size());
  summary.counts = source->Counts();
  summary.counts["scan_cut"] = slam.num_scans_cut();
  if (slam.num_scans_cut() > 0) Say(fmt::format("{}: {}", command_line.program(), kMapIsFull));
  summary.timings["slam_offline"] = {latency.Percentile(0.5), latency.Percentile(0.99), latency.max_ms()};
  results.summary_json = FormatSummary(summary);
  WriteResults(settings.out, results);
  fmt::print("{} scans, {} lost, map of {:.0f} m2 in {}\n", summary.scans, summary.lost, summary.explored_area_m2,
             settings.out);
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  using enum crsm::ParameterGroup;
  crsm::CommandLine command_line("slam_offline", "Maps a log or a simulated world in one process.",
                                 {kSeed, kOdometry, kScan, kSelection, kMatch, kUpdate},
                                 {"lcm_url", "channel_prefix", "out", "laser_channel"});
  std::string name;
  command_line.app().add_option("SOURCE", name, "CARMEN log or LCM log, gzip or not; sim:NAME or sim:FILE")->required();
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::MapLog(command_line, name); });
}
