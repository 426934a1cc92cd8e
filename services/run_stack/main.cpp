// run_stack: the whole system on a log, a simulated world or a live laser. Starts six processes on one LCM bus,
// watches them, starts again those that die, and ends them so that the map of all that was seen is on the disk.

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/math/parse_number.hpp"
#include "common/scan/valid_rays.hpp"
#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/base/viewer_token.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/bus_role.hpp"
#include "services/journal/earlier_scans.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/run_stack/fleet_run.hpp"
#include "services/run_stack/outcome.hpp"
#include "services/run_stack/results_folder.hpp"
#include "services/run_stack/signals.hpp"
#include "services/run_stack/stack_plan.hpp"
#include "services/run_stack/stack_viewer.hpp"
#include "services/run_stack/supervisor.hpp"
#include "services/settings/command_line.hpp"
#include "services/settings/help.hpp"
#include "services/sources/devices/live_laser.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/sources/study_laser.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter =
    "run_stack restarts a service that dies, and the service continues where it stopped. With --rate max no scan is "
    "lost. Ctrl-C ends the run early and writes the map so far; a second Ctrl-C kills all processes. The folder --out "
    "gets map.png, map.yaml, overview.png, trajectory.tum, summary.json, the log/ of each service, and the journal/ "
    "from which the map can be rebuilt.";

void AddOwnFlags(CommandLine& command_line, StackOptions& options, std::string& num_robots) {
  command_line.AddWord(
      "SOURCE", options.sources,
      DescribeSources() +
          ";\nlive: scans from another program on the bus, such as a laser driver or lcm-logplayer, until Ctrl-C");
  command_line.AddOption(
      "--robots", num_robots,
      "map N robots at a time, each by itself, and all on one common map; SOURCE is one for each, or "
      "one for all",
      {kOptionsHeading, "N"});
  AddFlags(command_line, options.earlier);
  command_line.AddFlag("--strict", options.strict, "fail if the map is not to be trusted");
  options.changes_over.AddFlag(command_line);
  command_line.AddFlag("--view", options.view,
                       "show the growing map in a browser, and the finished one until Ctrl-C; prints the address");
  std::vector<std::string> outputs;
  std::string help = "also publish pose and map for other programs";
  for (const Output& output : kOutputs) {
    outputs.emplace_back(output.name);
    help += fmt::format("; {}: {}", output.name, output.what);
  }
  command_line.AddOption("--outputs", options.outputs, help, {kProcessHeading, "", outputs});
  std::vector<std::string> replaceable;
  for (const Replaceable& process : kReplaceable) replaceable.emplace_back(process.name);
  command_line.AddOption("--without", options.without, "do not start this process; another process replaces it",
                         {kProcessHeading, "", replaceable});
  command_line.AddFooter(kFooter);
}

/// Flags that cannot be meant together, and those that are missing.
void CheckUsage(const CommandLine& command_line, const StackOptions& options) {
  const Settings& settings = command_line.settings();
  CheckEarlierResults(options.earlier, options.source, settings);
  for (const char* flag : {"rate", "resend_s"}) {
    if (options.is_live() && command_line.WasGiven(flag)) {
      throw UsageError(fmt::format("{}: applies to logs only; remove it for live scans", FlagOf(flag)));
    }
  }
  options.changes_over.Check(settings);
  if (options.changes_over.was_given() && options.IsWithout("map_exporter")) {
    throw UsageError("--changes-over: needs the results of map_exporter; remove --without map_exporter");
  }
  if (options.strict && options.IsWithout("map_exporter")) {
    throw UsageError("--strict: needs the verdict of map_exporter; remove --without map_exporter");
  }
}

/// As a shell takes it.
std::string Quote(const std::string& word) {
  const auto IsPlain = [](unsigned char c) {
    return std::isalnum(c) || std::string_view("-_./:=,+").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), IsPlain)) return word;
  std::string quoted = "'";
  for (const char c : word) c == '\'' ? quoted += "'\\''" : quoted += c;
  return quoted + "'";
}

/// What must be there for the stack to work, and with which flags ours would: some come from a study of the log.
void SayWhatIsMissing(const std::vector<PlannedService>& replaced) {
  for (const Replaceable& process : kReplaceable) {
    const auto ours = std::ranges::find(replaced, process.name, &PlannedService::name);
    if (ours == replaced.end()) continue;
    std::string words;
    for (const std::string& word : ours->command.arguments) words += ' ' + Quote(word);
    Say(fmt::format("run_stack: without {0}: another process must {1}; ours would be started as: {0}{2}", process.name,
                    process.contract, words));
  }
}

/// Whether there is anything to map, before anything is begun or changed.
void CheckInputs(const CommandLine& command_line, const StackOptions& options) {
  const Settings& settings = command_line.settings();
  if (!options.is_live()) {
    const auto source = OpenLaserSource(options.source, SourceOptionsOf(command_line));
    if (!source->Next()) ThrowNoScans(options.source, *source);
  }
  for (const std::string& earlier : {options.earlier.resume, settings.localize}) {
    if (earlier.empty()) continue;
    FindJournal(earlier);
    CheckAreOfOneMap(earlier);
  }
}

/// The processes know a scan by its time: where the map that goes on has other scans of these times, they would take
/// those for them.
void CheckTimesAreNew(const CommandLine& command_line, const StackOptions& options) {
  constexpr std::int64_t kEnough = 20;  // scans that are those of the map
  const std::string& resume = options.earlier.resume;
  if (options.is_live() || resume.empty()) return;
  EarlierScans earlier = ReadEarlierScans(FindJournal(resume));
  SourceOptions as_mapped = SourceOptionsOf(command_line);
  as_mapped.messages.mirrored = FindMirrored(options.source, command_line);
  const auto source = OpenLaserSource(options.source, as_mapped);
  while (const auto scan = source->Next()) {
    earlier.Has(scan->utime, FindValidRays(*scan, command_line.parameters().scan));
    if (earlier.is_another_drive()) {
      throw std::runtime_error(fmt::format(
          "{}: the map of {} has other scans of the same times, as of a simulated clock that begins at 0: "
          "slam_offline {} --resume {} --out {} maps them, at times of their own",
          options.source, resume, Quote(options.source), Quote(resume), Quote(command_line.settings().out)));
    }
    if (scan->utime > earlier.newest_utime() || earlier.num_same() >= kEnough) return;
  }
}

/// A laser that is ours is asked how long it takes for a sweep, unless somebody has said that, or a map that goes on
/// was made with another. Waits for the laser.
void AskLaser(const StackOptions& options, CommandLine& command_line) {
  constexpr int kSteadyAfter = 5;  // scans: a motor may have come up to speed a moment ago
  const auto device = ParseDevice(options.source);
  if (!device) return;
  LiveLaser laser(*device, [&](const std::string& line) {
    Say(fmt::format("{}: {}: {}", command_line.program(), options.source, line));
  });
  for (int i = 0; i < kSteadyAfter; ++i) {
    if (!laser.Next()) throw std::runtime_error("ended before the laser sent enough scans");
  }
  command_line.SetUnlessSaid("sweep_s", fmt::format("{:.3f}", std::min(laser.sweep_s(), 1.0)));
  command_line.SetUnlessSaid("beam_times", "true");  // where scans have them they are better than that
}

/// Said here in one line, where else the logs of several processes would. A publisher that is not ours may feed a
/// stack that is live.
void CheckRolesAreFree(const BusAddress& address, const StackOptions& options) {
  for (const std::string role : {kMapOwnerRole, kMatcherRole, kSelectorRole, kLoopCloserRole, kPublisherRole}) {
    if (!options.has_publisher() && role == kPublisherRole) continue;
    const bool is_anothers = std::any_of(
        std::begin(kReplaceable), std::end(kReplaceable),
        [&](const Replaceable& process) { return role == process.role && options.IsWithout(process.name); });
    if (is_anothers) continue;
    if (const auto holder = FindRoleHolder(address, role)) {
      throw std::runtime_error(DescribeTakenRole(address, role, *holder));
    }
  }
}

/// The last words on a run that succeeded or not, and its exit code.
int ReportEnd(bool success, const ResultsFolder& folder, const StackOptions& options) {
  if (success) return ReportOutcome(folder.path(), options.strict, options.changes_over);
  if (fs::exists(folder.summary())) {
    Say(fmt::format("run_stack: failed; {} has what was mapped until then, and no verdict is given on that",
                    folder.path().string()));
  }
  return EXIT_FAILURE;
}

/// Whether there is something that map_viewer can show of a finished run.
bool HasScans(const ResultsFolder& folder) {
  try {
    return ReadHead(folder.journal_folder()).has_value();
  } catch (const std::runtime_error&) {
    return false;
  }
}

int RunStack(CommandLine& command_line, const StackOptions& options) {
  const BusAddress address{command_line.settings().lcm_url, command_line.settings().channel_prefix};
  CheckUsage(command_line, options);
  if (options.view) ReadViewerToken();  // throws where it is none
  CheckBus(address.lcm_url);
  CheckInputs(command_line, options);
  AdoptEarlierMapParameters(options.earlier.resume, command_line);  // so that all processes are told the same
  CheckTimesAreNew(command_line, options);
  if (!fs::exists(FindPrograms() / "map_updater")) {
    throw std::runtime_error(fmt::format("no programs in {}: run scripts/build, or set CRSM_BIN_DIR to their folder",
                                         FindPrograms().string()));
  }
  std::optional<BusRole> role(std::in_place, address, kStackRole);
  CheckRolesAreFree(address, options);
  CatchSignals();
  ResultsFolder folder(command_line.settings().out, options.earlier);
  std::optional<StackViewer> viewer;
  if (options.view) viewer.emplace(PlanViewer(command_line, options, folder));  // there before anything is waited for
  AskLaser(options, command_line);
  Signals signals;
  if (!options.is_live()) StudyLaser(options.source, command_line);
  StackPlan plan = PlanStack(command_line, options, folder);
  SayWhatIsMissing(plan.replaced);
  const bool success = Supervisor(std::move(plan), viewer ? &*viewer : nullptr, folder, signals).Run();
  role.reset();  // another stack may use the bus while this one only shows its map
  if (success && signals.num_interrupts() > 0 && !fs::exists(folder.summary()) && folder.JournalBytes()) {
    Say(fmt::format(
        "run_stack: no new results are written, and no verdict is given; --resume {} goes on from its journal",
        folder.path().string()));
  }
  const int exit_code = ReportErrors(command_line.program(), [&] { return ReportEnd(success, folder, options); });
  std::fflush(stdout);
  if (viewer && viewer->has_address() && !signals.is_terminated() && HasScans(folder)) {
    viewer->ShowFinished(folder.path(), signals);
  }
  return exit_code;
}

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line("run_stack",
                                 "Maps a log, a simulated world or the scans of a live laser. Runs six processes on "
                                 "one LCM bus, five with --no-loops.",
                                 crsm::FlagsOfStack());
  crsm::StackOptions options;
  std::string num_robots;
  crsm::AddOwnFlags(command_line, options, num_robots);
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::ReportErrors(command_line.program(), [&] {
    if (!num_robots.empty()) {
      options.num_robots = crsm::ParseNumber<int>(num_robots).value_or(0);
      return crsm::RunFleet(command_line, options);
    }
    if (options.sources.size() > 1) {
      throw crsm::UsageError(
          "several SOURCEs: are several robots: add --robots N; slam_offline maps drives of one robot");
    }
    options.source = options.sources.front();
    return crsm::RunStack(command_line, options);
  });
}
