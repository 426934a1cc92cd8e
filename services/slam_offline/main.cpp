// slam_offline: a log or a simulated world -> map and trajectory, in one process without messages. The oracle that the
// five processes are tested against.

#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <unordered_set>

#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "common/slam.hpp"
#include "services/runtime/progress.hpp"
#include "services/runtime/service.hpp"
#include "services/runtime/version.hpp"
#include "services/sources/journal.hpp"
#include "services/sources/open_laser_source.hpp"

namespace crsm {
namespace {

/// Makes the map of an earlier run, where there is one to begin with, and opens the journal of this one. The last scan
/// of the map goes to `last_scan`.
std::unique_ptr<Journal> Begin(const CommandLine& command_line, const std::string& log, const std::string& resume,
                               Slam& slam, LaserScan& last_scan) {
  const Settings& settings = command_line.settings();
  const JournalSubject subject{slam.geometry().cell_size_m(), !settings.localize.empty()};
  const auto Restore = [&](const LaserScan* scan, const ScanMatch& match) {
    slam.Restore(scan, match);
    if (scan) last_scan = *scan;
  };
  if (!resume.empty()) {
    if (subject.localization) {
      throw std::runtime_error("--resume goes on with a map and --localize leaves it as it is: one of them, please");
    }
    TakeOverJournal(resume, settings.out);
    auto journal = std::make_unique<Journal>(JournalFolder(settings.out), subject, Restore);
    Say(fmt::format("{}: went on from {} scans in {}", command_line.program(), slam.history().size(), resume));
    return journal;
  }
  if (subject.localization) {
    std::error_code error;
    if (std::filesystem::equivalent(settings.localize, settings.out, error)) {
      throw std::runtime_error(
          fmt::format("--localize {}: its map stays as it is: choose another --out", settings.localize));
    }
    ReadJournal(JournalFolder(settings.localize), {subject.cell_size_m, false}, Restore);
    if (slam.map().tiles().entries().empty()) {
      throw std::runtime_error(fmt::format("--localize {}: its map is empty", settings.localize));
    }
    Say(fmt::format("{}: a finished map of {} scans from {}", command_line.program(), slam.history().size(),
                    settings.localize));
    slam.Freeze();
  }
  RemoveJournal(settings.out, log);
  return std::make_unique<Journal>(JournalFolder(settings.out), subject);
}

void MapLog(const CommandLine& command_line, const std::string& name, const std::string& resume) {
  const Settings& settings = command_line.settings();
  const Parameters& parameters = command_line.parameters();
  const auto source = OpenLaserSource(name, {parameters.match.seed, settings.laser_channel});
  PrepareFolder(settings.out);

  Slam slam(parameters);
  Results results;
  const std::unique_ptr<Journal> journal = Begin(command_line, name, resume, slam, results.last_scan);
  std::unordered_set<std::int64_t> mapped_utimes;
  for (const ScanMatch& match : slam.history()) mapped_utimes.insert(match.utime);
  std::int64_t num_repeated = 0;
  Latency latency;
  Progress progress(command_line.program());
  while (auto scan = source->Next()) {
    if (StopRequested()) break;
    if (mapped_utimes.insert(scan->utime).second) {
      const auto start = Clock::now();
      const ScanMatch match = slam.Process(*scan, source->Odometry());
      latency.Record(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
      journal->Append(&*scan, match);
    } else {
      ++num_repeated;
    }
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
  summary.counts["utime_repeated"] += num_repeated;
  summary.counts["scan_cut"] = slam.num_scans_cut();
  if (num_repeated > 0) {
    Say(fmt::format("{}: {} scans were in the map already and are not mapped twice (utime_repeated)",
                    command_line.program(), num_repeated));
  }
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
