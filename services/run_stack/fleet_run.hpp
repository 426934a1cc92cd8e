#pragma once

#include "services/run_stack/stack_plan.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {

/// Several robots on one bus: a run_stack of its own for each, under robot1/, robot2/, ..., and under fleet/ the mapper
/// of the common map and its exporter. --out has the common map, and below it the folder of each robot. Robots that are
/// recordings or simulated may be mapped faster than the common map grows: what it lacks at their end is told from
/// their journals. Returns the exit code.
int RunFleet(const CommandLine& command_line, const StackOptions& options);

}  // namespace crsm
