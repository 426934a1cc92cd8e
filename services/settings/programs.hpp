#pragma once

#include <string>
#include <vector>

#include "common/parameters.hpp"
#include "services/settings/settings.hpp"

namespace crsm {

/// Which parameters and settings are flags of a program, and what the settings are without a flag.
struct ProgramFlags {
  std::vector<ParameterGroup> groups;  ///< of the parameters
  std::vector<std::string> settings;   ///< names
  Settings defaults = {};
};

// The programs of a stack: one list for themselves and for run_stack, which hands each what belongs to it.
ProgramFlags FlagsOfPublisher();
ProgramFlags FlagsOfSelector();
ProgramFlags FlagsOfMatcher();
ProgramFlags FlagsOfUpdater();
ProgramFlags FlagsOfLoopCloser();
ProgramFlags FlagsOfExporter();
ProgramFlags FlagsOfViewer();
ProgramFlags FlagsOfMbotPublisher();

/// Of the common map of several stacks.
ProgramFlags FlagsOfFleetMapper();
ProgramFlags FlagsOfFleetRelay();

}  // namespace crsm
