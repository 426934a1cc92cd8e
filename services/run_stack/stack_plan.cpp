#include "services/run_stack/stack_plan.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>

#include "common/results/run_origin.hpp"
#include "services/base/viewer_token.hpp"
#include "services/sources/devices/live_laser.hpp"
#include "services/wire/channels.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// What run_stack says to its processes itself, whatever it was told.
bool IsSetByStack(const std::string& setting) {
  constexpr std::array<std::string_view, 8> kSetByStack{"out",     "rate",   "position",    "lockstep",
                                                        "journal", "resume", "new_session", "made_from"};
  return std::find(kSetByStack.begin(), kSetByStack.end(), setting) != kSetByStack.end();
}

std::vector<ProgramFlags> FlagsOfAll() {
  std::vector<ProgramFlags> all{FlagsOfPublisher(),  FlagsOfSelector(), FlagsOfMatcher(), FlagsOfUpdater(),
                                FlagsOfLoopCloser(), FlagsOfExporter(), FlagsOfViewer()};
  for (const Output& output : kOutputs) all.push_back(output.flags());
  return all;
}

class Planner {
 public:
  Planner(const CommandLine& command_line, const ResultsFolder& folder)
      : command_line_(command_line), folder_(folder) {}

  /// own: what run_stack itself tells the process, before what its user did.
  PlannedService Plan(const std::string& name, ProgramFlags flags, std::vector<std::string> own) const {
    std::erase_if(flags.settings, IsSetByStack);
    const std::vector<std::string> words = command_line_.WordsFor(flags);
    own.insert(own.end(), words.begin(), words.end());
    return {name, {FindPrograms() / name, std::move(own), folder_.log_folder() / (name + ".log")}};
  }

 private:
  const CommandLine& command_line_;
  const ResultsFolder& folder_;
};

/// A publisher of ours reads a log's --laser-channel and --laser-frame, and publishes on LASER, whose scans name no
/// frame, and are turned round already where they were mirror images.
PlannedService PlanSelector(const Planner& planner, const StackOptions& options, const Settings& settings) {
  ProgramFlags flags = FlagsOfSelector();
  std::vector<std::string> own;
  if (options.has_publisher()) {
    std::erase(flags.settings, "mirrored");
    if (settings.mirrored) own.emplace_back("--no-mirrored");  // whatever a configuration file says
  }
  if (options.is_live()) return planner.Plan("ray_selector", flags, std::move(own));
  own.insert(own.end(), {"--laser-channel", kLaserChannel});
  if (!settings.laser_frame.empty())
    own.insert(own.end(), {"--laser-frame", ""});  // whatever a configuration file says
  std::erase(flags.settings, "laser_channel");
  std::erase(flags.settings, "laser_frame");
  return planner.Plan("ray_selector", flags, std::move(own));
}

/// A publisher of ours reads a log's --odometry-topic, and publishes on ODOMETRY.
PlannedService PlanMatcher(const Planner& planner, const StackOptions& options, const std::string& odometry_topic,
                           std::vector<std::string> own) {
  ProgramFlags flags = FlagsOfMatcher();
  if (!options.is_live() && !odometry_topic.empty()) {
    std::erase(flags.settings, "odometry_topic");
    own.insert(own.end(), {"--odometry-topic", kOdometryChannel});
  }
  return planner.Plan("rrhc_matcher", flags, std::move(own));
}

/// Where the robot stands at its start is of the first process only: one that is started again goes on.
PlannedService PlanUpdater(const Planner& planner, const std::string& start, const std::vector<std::string>& own) {
  ProgramFlags flags = FlagsOfUpdater();
  std::erase(flags.settings, "start");
  PlannedService updater = planner.Plan("map_updater", flags, own);
  updater.when_resuming = {"--resume"};
  updater.when_resuming_first = {"--new-session"};
  if (!start.empty()) updater.when_resuming_first.insert(updater.when_resuming_first.end(), {"--start", start});
  return updater;
}

/// Whether each scan goes through a process on its way to a pose and into the map.
bool IsOnScansWay(const PlannedService& service) {
  constexpr std::array<std::string_view, 3> kOnTheWay{"ray_selector", "rrhc_matcher", "map_updater"};
  return std::count(kOnTheWay.begin(), kOnTheWay.end(), service.name) > 0;
}

/// In lockstep each scan goes from one of these to the next, and no two of them work at a time. On one core the next
/// one finds in the caches what the last one wrote, and no core has to be woken for it: a third less processor time,
/// and no fewer scans a second (scripts/bench stack). The core is the one that the kernel has found free for this
/// process.
void ShareCore(StackPlan& plan) {
  const int core = sched_getcpu();
  if (core < 0) return;
  for (PlannedService& service : plan.services) {
    if (IsOnScansWay(service)) service.command.core = core;
  }
  if (plan.publisher) plan.publisher->command.core = core;
}

/// Live, a pose that comes late is of no use, and pictures of the map can wait.
void SetPriorities(StackPlan& plan) {
  for (PlannedService& service : plan.services) {
    service.command.priority = IsOnScansWay(service) ? Priority::kFirst : Priority::kLast;
  }
  if (plan.publisher) plan.publisher->command.priority = Priority::kFirst;
}

bool IsInLockstep(const StackOptions& options, const Settings& settings) {
  return !options.is_live() && settings.rate == "max";
}

std::vector<std::string> operator+(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace

bool StackOptions::is_live() const { return !has_publisher() || ParseDevice(source); }

StackPlan PlanStack(const CommandLine& command_line, const StackOptions& options, const ResultsFolder& folder) {
  const Settings& settings = command_line.settings();
  const Planner planner(command_line, folder);
  const bool in_lockstep = IsInLockstep(options, settings);
  // A configuration file may say what is right for services that run alone.
  std::vector<std::string> lockstep;
  if (in_lockstep) {
    lockstep = {"--lockstep"};
  } else if (settings.lockstep) {
    lockstep = {"--no-lockstep"};
  }
  const std::vector<std::string> journal{"--journal", folder.journal_folder().string()};

  const std::string made_from = JoinOrigins(folder.earlier_made_from(), command_line.DescribeRun({options.source}));

  StackPlan plan;
  PlannedService updater = PlanUpdater(planner, settings.start, lockstep + journal);
  if (settings.resume) updater.when_new = {"--no-resume"};
  plan.services = {
      std::move(updater), PlanMatcher(planner, options, settings.odometry ? settings.odometry_topic : "", lockstep),
      PlanSelector(planner, options, settings),
      planner.Plan("map_exporter", FlagsOfExporter(), {"--out", folder.path().string(), "--made-from", made_from})};
  if (command_line.parameters().loops.loops && settings.localize.empty()) {
    plan.services.push_back(planner.Plan("loop_closer", FlagsOfLoopCloser(), {"--out", folder.path().string()}));
  }
  const auto replaced = std::stable_partition(plan.services.begin(), plan.services.end(),
                                              [&](const auto& service) { return !options.IsWithout(service.name); });
  plan.replaced.assign(std::move_iterator(replaced), std::move_iterator(plan.services.end()));
  plan.services.erase(replaced, plan.services.end());
  for (const Output& output : kOutputs) {
    if (std::count(options.outputs.begin(), options.outputs.end(), output.name) > 0)
      plan.services.push_back(planner.Plan(output.program, output.flags(), {}));
  }
  plan.live = options.is_live();
  if (options.has_publisher()) {
    const std::string position = (folder.log_folder() / "laser_publisher.position").string();
    std::vector<std::string> own{options.source};
    if (!plan.live) own = own + std::vector<std::string>{"--rate", settings.rate, "--position", position};
    ProgramFlags flags = FlagsOfPublisher();
    if (plan.live) {  // a laser has no odometry: what is on the bus is another driver's
      std::erase(flags.settings, "odometry");
      std::erase(flags.settings, "odometry_topic");
    }
    plan.publisher = planner.Plan("laser_publisher", flags, own);
    plan.publisher->command.log.clear();  // it shows how far it is
    fs::remove(position);
  }
  if (in_lockstep) {
    ShareCore(plan);
  } else {
    SetPriorities(plan);
  }
  plan.resume = !options.earlier.resume.empty();
  if (plan.resume) plan.earlier_journal_bytes += fs::file_size(FindJournal(options.earlier.resume));
  if (!settings.localize.empty()) plan.earlier_journal_bytes += fs::file_size(FindJournal(settings.localize));
  return plan;
}

PlannedService PlanViewer(const CommandLine& command_line, const StackOptions& options, const ResultsFolder& folder) {
  const Settings& settings = command_line.settings();
  ProgramFlags flags = FlagsOfViewer();
  std::erase(flags.settings, "http");
  PlannedService viewer = Planner(command_line, folder).Plan("map_viewer", flags, {});
  viewer.command.arguments.insert(viewer.command.arguments.end(), {"--http", settings.http});
  viewer.is_needed = false;
  if (isatty(STDERR_FILENO)) viewer.when_new = {"--qr-code"};  // its own stderr is a log
  // One token for all viewers that are started in this run, so that pages and links stay valid.
  viewer.command.environment[kViewerTokenVariable] = ReadViewerToken().value_or(DrawViewerToken());
  if (!IsInLockstep(options, settings)) viewer.command.priority = Priority::kLast;
  return viewer;
}

fs::path FindPrograms() {
  const char* folder = std::getenv("CRSM_BIN_DIR");
  return folder && *folder ? fs::path(folder) : fs::read_symlink("/proc/self/exe").parent_path();
}

ProgramFlags FlagsOfStack() {
  ProgramFlags all{{}, {"out", "rate"}};
  all.defaults.rate = "max";
  const auto Add = [](auto& known, const auto& more) {
    for (const auto& item : more) {
      if (std::find(known.begin(), known.end(), item) == known.end()) known.push_back(item);
    }
  };
  for (ProgramFlags flags : FlagsOfAll()) {
    std::erase_if(flags.settings, IsSetByStack);
    Add(all.groups, flags.groups);
    Add(all.settings, flags.settings);
  }
  return all;
}

}  // namespace crsm
