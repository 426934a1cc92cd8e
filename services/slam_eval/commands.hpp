#pragma once

#include "services/settings/commands.hpp"

namespace crsm {

/// Each adds one command of slam_eval, which throws std::exception if it fails.
void AddExportCommand(Commands& commands);
void AddMapCommand(Commands& commands);
void AddPlanCommand(Commands& commands);
void AddRelationsCommand(Commands& commands);
void AddSummaryCommand(Commands& commands);
void AddTrajectoryCommand(Commands& commands);
void AddWorldCommand(Commands& commands);

}  // namespace crsm
