#include "services/run_stack/fleet_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <filesystem>

#include "services/base/process.hpp"
#include "services/base/say.hpp"
#include "services/base/usage_error.hpp"
#include "services/bus/bus.hpp"
#include "services/bus/bus_role.hpp"
#include "services/run_stack/member.hpp"
#include "services/run_stack/outcome.hpp"
#include "services/run_stack/results_folder.hpp"
#include "services/run_stack/signals.hpp"
#include "services/wire/channels.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kReadyWithin = 60s;
constexpr auto kCaughtUpWithin = std::chrono::minutes(10);
constexpr auto kEndsWithin = 60s;

class FleetRun {
 public:
  FleetRun(const CommandLine& command_line, const StackOptions& options)
      : command_line_(command_line),
        options_(options),
        prefix_(command_line.settings().channel_prefix),
        folder_(command_line.settings().out, options.earlier),
        bus_(command_line.settings().lcm_url, FleetPrefix(), counters_) {
    bus_.Subscribe<service_status_t>(ServiceStatusChannel("fleet_mapper"),
                                     [this](const service_status_t& status) { Hear(status); });
    members_.push_back({PlanMapper()});
    members_.push_back({Plan("map_exporter", FlagsOfExporter(), {"channel_prefix", "out", "made_from"},
                             {"--channel-prefix", FleetPrefix(), "--out", folder_.path().string(), "--made-from",
                              command_line.DescribeRun(options.sources)})});
    if (options.view) members_.push_back({PlanViewer()});
  }

  int Run() {
    for (Member& member : members_) member.Start();
    if (!AwaitReady(members_)) return EXIT_FAILURE;
    for (int i = 0; i < options_.num_robots; ++i) robots_.emplace_back(PlanRobot(i));
    Say(fmt::format("run_stack: {} robots: what each says is in {}", options_.num_robots,
                    (folder_.log_folder() / "robot1.log").string()));
    AwaitRobots();
    CatchUp();
    Stop(members_[1]);  // gets what the mapper has
    for (Member& member : members_) Stop(member);
    if (num_failed_ > 0) Say(fmt::format("run_stack: {} of {} robots failed", num_failed_, options_.num_robots));
    const int exit_code = ReportOutcome(folder_.path(), options_.strict);
    return num_failed_ > 0 ? EXIT_FAILURE : exit_code;
  }

 private:
  std::string FleetPrefix() const { return prefix_ + "fleet/"; }
  std::string RobotPrefix(int robot) const { return fmt::format("{}robot{}/", prefix_, robot + 1); }
  fs::path FolderOf(int robot) const { return folder_.path() / fmt::format("robot{}", robot + 1); }

  PlannedService Plan(const std::string& name, ProgramFlags flags, const std::vector<std::string>& set_here,
                      std::vector<std::string> own) const {
    std::erase_if(flags.settings,
                  [&](const std::string& setting) { return std::ranges::count(set_here, setting) > 0; });
    const std::vector<std::string> words = command_line_.WordsFor(flags);
    own.insert(own.end(), words.begin(), words.end());
    PlannedService plan{name, {FindPrograms() / name, std::move(own), folder_.log_folder() / (name + ".log")}};
    plan.command.priority = Priority::kLast;  // no robot waits for it
    return plan;
  }

  PlannedService PlanMapper() const {
    std::vector<std::string> own{"--channel-prefix", FleetPrefix(), "--journal", folder_.journal_folder().string(),
                                 "--robots"};
    for (int i = 0; i < options_.num_robots; ++i) own.push_back(RobotPrefix(i));
    PlannedService plan = Plan("fleet_mapper", FlagsOfFleetMapper(), {"channel_prefix", "journal", "resume"}, own);
    plan.when_resuming = {"--resume"};
    return plan;
  }

  PlannedService PlanViewer() const {
    std::vector<std::string> own{"--http", command_line_.settings().http, "--robots", FleetPrefix()};
    for (int i = 0; i < options_.num_robots; ++i) own.push_back(RobotPrefix(i));
    PlannedService plan = Plan("map_viewer", FlagsOfViewer(), {"channel_prefix", "http"}, own);
    plan.command.log.clear();  // it says where the page is
    return plan;
  }

  Command PlanRobot(int robot) const {
    ProgramFlags flags = FlagsOfStack();
    std::erase_if(flags.settings, [](const std::string& setting) {
      return setting == "channel_prefix" || setting == "out" || setting == "http";
    });
    std::vector<std::string> words{options_.sources[static_cast<std::size_t>(robot) % options_.sources.size()],
                                   "--channel-prefix", RobotPrefix(robot), "--out", FolderOf(robot).string()};
    const std::vector<std::string> more = command_line_.WordsFor(flags);
    words.insert(words.end(), more.begin(), more.end());
    if (options_.earlier.force) words.emplace_back("--force");
    // A world that several robots are in has other noise for each.
    if (!command_line_.WasGiven("seed")) words.insert(words.end(), {"--seed", std::to_string(robot + 1)});
    return {FindPrograms() / "run_stack", words, folder_.log_folder() / fmt::format("robot{}.log", robot + 1)};
  }

  /// Those that answer for a robot that has ended, from its journal.
  std::vector<PlannedService> PlanAnswers(int robot) const {
    const std::string journal = (FolderOf(robot) / "journal").string();
    std::vector<PlannedService> plans{
        Plan("map_updater", FlagsOfUpdater(),
             {"channel_prefix", "journal", "resume", "lockstep", "new_session", "start"},
             {"--channel-prefix", RobotPrefix(robot), "--journal", journal, "--resume"}),
        Plan("loop_closer", FlagsOfLoopCloser(), {"channel_prefix", "out"}, {"--channel-prefix", RobotPrefix(robot)})};
    for (PlannedService& plan : plans)
      plan.command.log = folder_.log_folder() / fmt::format("{}_robot{}.log", plan.name, robot + 1);
    return plans;
  }

  void Hear(const service_status_t& status) {
    for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
      if (status.counter_name[i] == "robots_behind")
        num_caught_up_ = status.counter_value[i] == 0 ? num_caught_up_ + 1 : 0;
    }
  }

  bool AwaitReady(std::deque<Member>& members) {
    const auto give_up = Clock::now() + kReadyWithin;
    // A viewer says itself where its page is.
    const auto IsReady = [](const Member& member) { return member.plan.command.log.empty() || member.IsReady(); };
    while (!std::ranges::all_of(members, IsReady)) {
      signals_.Wait(20ms);
      for (Member& member : members) {
        if (!member.HasEnded() && Clock::now() < give_up) continue;
        SayLastLines(member.plan.command.log);
        Say(fmt::format("run_stack: {} did not start", member.plan.name));
        return false;
      }
      if (signals_.num_interrupts() > 0) return false;
    }
    return true;
  }

  /// Until all have ended, by themselves or because somebody asks for it. What makes the common map is started again
  /// where it dies.
  void AwaitRobots() {
    int num_heeded = 0;
    std::vector<bool> has_ended(robots_.size());
    while (std::ranges::count(has_ended, false) > 0) {
      signals_.Wait(100ms);
      if (signals_.num_interrupts() > num_heeded) {
        num_heeded = signals_.num_interrupts();
        for (Child& robot : robots_) robot.Signal(SIGINT);
      }
      for (std::size_t i = 0; i < robots_.size(); ++i) {
        if (has_ended[i] || robots_[i].IsRunning()) continue;
        has_ended[i] = true;
        if (robots_[i].EndedWell()) continue;
        ++num_failed_;
        SayLastLines(folder_.log_folder() / fmt::format("robot{}.log", i + 1));
        Say(fmt::format("run_stack: robot{} ended with {}", i + 1, robots_[i].DescribeEnd()));
      }
      ReviveAll();
    }
  }

  void ReviveAll() {
    for (Member& member : members_) {
      if (!member.HasEnded()) continue;
      Say(fmt::format("run_stack: {} ended with {}, and is started again", member.plan.name,
                      member.child->DescribeEnd()));
      SayLastLines(member.plan.command.log);
      signals_.Wait(500ms);
      member.Start(member.plan.when_resuming);
    }
  }

  /// What the common map lacks of robots that have ended is told from their journals.
  void CatchUp() {
    std::deque<Member> answering;
    for (int i = 0; i < options_.num_robots; ++i) {
      if (!fs::exists(FolderOf(i) / "journal" / "journal.lcm")) continue;
      for (PlannedService& plan : PlanAnswers(i)) answering.push_back({std::move(plan)});
    }
    for (Member& member : answering) member.Start();
    const int num_heeded = signals_.num_interrupts();
    if (AwaitReady(answering)) {
      constexpr int kInARow = 4;  // statuses, one a second: by then the newest keyframe of each is heard
      const auto give_up = Clock::now() + kCaughtUpWithin;
      num_caught_up_ = 0;
      while (num_caught_up_ < kInARow && Clock::now() < give_up && signals_.num_interrupts() == num_heeded) {
        bus_.Wait(20);
        signals_.Wait(1ms);
        ReviveAll();
      }
      if (num_caught_up_ < kInARow) Say("run_stack: not all keyframes of all robots are on the common map");
    }
    for (Member& member : answering) Stop(member);
  }

  void Stop(Member& member) {
    if (!member.IsRunning()) return;
    member.child->Signal(SIGINT);
    const auto give_up = Clock::now() + kEndsWithin;
    while (member.IsRunning() && Clock::now() < give_up) signals_.Wait(20ms);
    if (!member.IsRunning()) return;
    Say(fmt::format("run_stack: {} does not end, and is killed", member.plan.name));
    member.child->Signal(SIGKILL);
  }

  const CommandLine& command_line_;
  const StackOptions& options_;
  std::string prefix_;
  ResultsFolder folder_;
  Counters counters_;
  Bus bus_;
  Signals signals_;
  std::deque<Member> members_;  ///< of the common map
  std::deque<Child> robots_;
  int num_failed_ = 0;
  int num_caught_up_ = 0;  ///< statuses in a row in which the common map lacked nothing
};

void CheckFleet(const CommandLine& command_line, const StackOptions& options) {
  const Settings& settings = command_line.settings();
  if (options.num_robots < 2 || options.num_robots > 64) {
    throw UsageError(fmt::format("--robots {}: must be 2 to 64", options.num_robots));
  }
  if (options.sources.size() != 1 && std::ssize(options.sources) != options.num_robots) {
    throw UsageError(fmt::format("--robots {}: takes one SOURCE for all robots, or one for each, and not {}",
                                 options.num_robots, options.sources.size()));
  }
  if (!options.earlier.resume.empty() || !settings.localize.empty()) {
    throw UsageError("--robots: begins new maps; remove --resume and --localize");
  }
  if (!command_line.parameters().loops.loops) throw UsageError("--robots: are joined by loops; remove --no-loops");
  if (!options.without.empty()) throw UsageError("--without: is of one robot; remove it, or start each robot alone");
  for (const std::string& source : options.sources) CheckEarlierResults(options.earlier, source, settings);
}

}  // namespace

int RunFleet(const CommandLine& command_line, const StackOptions& options) {
  CheckFleet(command_line, options);
  CheckBus(command_line.settings().lcm_url);
  CatchSignals();
  return FleetRun(command_line, options).Run();
}

}  // namespace crsm
