#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/bus_role.hpp"
#include "services/diagnosis/changes_over.hpp"
#include "services/run_stack/child.hpp"
#include "services/run_stack/results_folder.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {

inline constexpr const char* kLive = "live";  ///< in the place of a source: a laser driver feeds the bus

/// A process that publishes pose and map for the programs of others.
struct Output {
  const char* name;  ///< as --outputs has it
  const char* program;
  const char* what;
  ProgramFlags (*flags)();
};
inline constexpr Output kOutputs[]{{"mbot", "mbot_publisher",
                                    "SLAM_POSE and SLAM_MAP for mbots of the University of Michigan",
                                    &FlagsOfMbotPublisher}};

/// A process in whose place another one may be, its role on the bus, and what that one has to do.
struct Replaceable {
  const char* name;
  const char* role;  ///< empty for none
  const char* contract;
};
inline constexpr Replaceable kReplaceable[]{
    {"ray_selector", kSelectorRole, "answer each scan on LASER with CRITICAL_RAYS"},
    {"rrhc_matcher", kMatcherRole, "match CRITICAL_RAYS to the map of MAP_DELTA, and answer with SCAN_MATCH"},
    {"loop_closer", kLoopCloserRole, "answer each KEYFRAME with POSE_GRAPH"},
    {"map_exporter", "", "write the results, or there are none"},
};

/// What run_stack is told beside the flags that all programs share.
struct StackOptions {
  std::string source;                ///< a log, a simulated world, a laser, or kLive
  std::vector<std::string> sources;  ///< the same, of each robot
  int num_robots = 0;                ///< 0: one robot, without a common map
  EarlierResults earlier;
  bool strict = false;
  ChangesOver changes_over;
  bool view = false;                 ///< with map_viewer
  std::vector<std::string> outputs;  ///< names of kOutputs
  std::vector<std::string> without;  ///< processes of kReplaceable that another one stands in for

  bool has_publisher() const { return source != kLive; }
  /// Scans come at their own pace, of a laser that is ours or of somebody else's driver.
  bool is_live() const;
  bool IsWithout(const std::string& name) const {
    return std::find(without.begin(), without.end(), name) != without.end();
  }
};

/// A process of the stack.
struct PlannedService {
  std::string name;
  Command command;
  std::vector<std::string> when_resuming = {};        ///< more arguments, where it goes on with a journal, ...
  std::vector<std::string> when_resuming_first = {};  ///< ... of an earlier run, ...
  std::vector<std::string> when_new = {};             ///< ... and where it does not
  bool is_needed = true;                              ///< the run fails if this process does
};

/// What is to be started, and how.
struct StackPlan {
  std::vector<PlannedService> services;      ///< in the order in which they start
  std::vector<PlannedService> replaced;      ///< by processes of others, StackOptions::without
  std::optional<PlannedService> publisher;   ///< none where somebody else's driver feeds the bus
  bool live = false;                         ///< the end is when somebody asks for it
  bool resume = false;                       ///< with the journal that is in the folder already
  std::uintmax_t earlier_journal_bytes = 0;  ///< of which a map is made before all else
};

/// Of this command line's flags each process gets those that belong to it.
StackPlan PlanStack(const CommandLine& command_line, const StackOptions& options, const ResultsFolder& folder);

/// The viewer of this stack, which is planned apart: it starts before it is known how the others are to be started.
PlannedService PlanViewer(const CommandLine& command_line, const StackOptions& options, const ResultsFolder& folder);

/// Where the programs are: CRSM_BIN_DIR in the environment, or where this one is.
std::filesystem::path FindPrograms();

/// run_stack's own flags, all those of its processes but the ones that it sets itself.
ProgramFlags FlagsOfStack();

}  // namespace crsm
