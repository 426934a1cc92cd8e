// slam_offline: a log or a simulated world -> map and trajectory, in one process without messages. The oracle that the
// five processes are tested against.

#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <unordered_set>

#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "common/slam.hpp"
#include "services/runtime/path_lock.hpp"
#include "services/runtime/progress.hpp"
#include "services/runtime/service.hpp"
#include "services/runtime/usage_error.hpp"
#include "services/runtime/version.hpp"
#include "services/sources/journal.hpp"
#include "services/sources/open_laser_source.hpp"

namespace crsm {
namespace {

/// What a run has come to so far.
struct Run {
  explicit Run(const Parameters& parameters) : slam(parameters) {}

  void Restore(const CriticalRays* scan, const ScanMatch& match) {
    slam.Integrate(scan, match);
    matches.push_back(match);
    if (scan) last_scan = *scan;
  }

  Slam slam;
  std::vector<ScanMatch> matches;
  CriticalRays last_scan;
};

/// Makes the map of an earlier run, where there is one to begin with, and opens the journal of this one.
std::unique_ptr<Journal> Begin(const CommandLine& command_line, const std::string& resume, Run& run) {
  const Settings& settings = command_line.settings();
  const JournalSubject subject{run.slam.map().geometry().cell_size_m(), !settings.localize.empty()};
  const auto Restore = [&](const CriticalRays* scan, const ScanMatch& match) { run.Restore(scan, match); };
  if (!resume.empty()) {
    if (subject.finished_map) {
      throw UsageError("--resume goes on with a map and --localize leaves it as it is: one of them, please");
    }
    TakeOverJournal(resume, settings.out);
    auto journal = std::make_unique<Journal>(JournalFolder(settings.out), subject, Restore);
    Say(fmt::format("{}: went on from {} scans in {}", command_line.program(), run.matches.size(), resume));
    return journal;
  }
  if (subject.finished_map) {
    std::error_code error;
    if (std::filesystem::equivalent(settings.localize, settings.out, error)) {
      throw UsageError(fmt::format("--localize {}: its map stays as it is: choose another --out", settings.localize));
    }
    ReadJournal(JournalFolder(settings.localize), {subject.cell_size_m, false}, Restore);
    if (run.slam.map().empty()) {
      throw std::runtime_error(fmt::format("--localize {}: its map is empty", settings.localize));
    }
    Say(fmt::format("{}: a finished map of {} scans from {}", command_line.program(), run.matches.size(),
                    settings.localize));
    run.slam.FinishMap();
    run.matches.clear();
  }
  RemoveJournal(settings.out);
  return std::make_unique<Journal>(JournalFolder(settings.out), subject);
}

void MapLog(const CommandLine& command_line, const std::string& name, const std::string& resume) {
  const Settings& settings = command_line.settings();
  const Parameters& parameters = command_line.parameters();
  const auto source = OpenLaserSource(name, {parameters.match.seed, settings.laser_channel});
  PrepareFolder(settings.out);
  const PathLock lock("--out", settings.out);

  Run run(parameters);
  Results results;
  const std::unique_ptr<Journal> journal = Begin(command_line, resume, run);
  std::unordered_set<std::int64_t> mapped_utimes;
  for (const ScanMatch& match : run.matches) mapped_utimes.insert(match.utime);
  std::int64_t num_repeated = 0;
  Latency latency;
  Progress progress(command_line.program());
  while (auto scan = source->Next()) {
    if (StopRequested()) break;
    if (mapped_utimes.insert(scan->utime).second) {
      const auto start = Clock::now();
      Slam::Step step = run.slam.Process(*scan, source->Odometry());
      latency.Record(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
      journal->Append(step.drawn ? &step.scan : nullptr, step.match);
      run.matches.push_back(step.match);
      run.last_scan = std::move(step.scan);
    } else {
      ++num_repeated;
    }
    if (const auto T_map_laser = source->TruePose()) results.truth.push_back({scan->utime, *T_map_laser});
    progress.Show(source->Progress(), latency.num_recorded());
  }
  progress.Finish(latency.num_recorded());

  results.grid = run.slam.map().ToDenseGrid();
  results.matches = run.matches;
  results.last_scan = run.last_scan;
  Summary summary = Summarize(results.matches, results.grid);
  summary.version = kVersion;
  summary.parameters = ListParameters(parameters);
  summary.map_version = run.slam.map_version();
  summary.counts = source->Counts();
  summary.counts["utime_repeated"] += num_repeated;
  summary.counts["scan_cut"] = run.slam.num_scans_cut();
  if (num_repeated > 0) {
    Say(fmt::format("{}: {} scans were in the map already and are not mapped twice (utime_repeated)",
                    command_line.program(), num_repeated));
  }
  if (run.slam.num_scans_cut() > 0) Say(fmt::format("{}: {}", command_line.program(), kMapIsFull));
  summary.timings["slam_offline"] = {latency.Percentile(0.5), latency.Percentile(0.95), latency.Percentile(0.99),
                                     latency.max_ms()};
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
                                 {"lcm_url", "channel_prefix", "out", "laser_channel", "localize", "start"});
  std::string name;
  command_line.app().add_option("SOURCE", name, crsm::DescribeSources())->required();
  std::string resume;
  command_line.app()
      .add_option("--resume", resume, "folder of an earlier run (its --out, or this one's): go on with its map")
      ->type_name("DIR");
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] { crsm::MapLog(command_line, name, resume); });
}
