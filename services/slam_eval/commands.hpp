#pragma once

#include <CLI/CLI.hpp>

namespace crsm {

/// Each adds one command of slam_eval, which runs within `app.parse` and throws std::exception if it fails.
void AddMapCommand(CLI::App& app);
void AddRelationsCommand(CLI::App& app);
void AddSummaryCommand(CLI::App& app);
void AddTrajectoryCommand(CLI::App& app);
void AddWorldCommand(CLI::App& app);

}  // namespace crsm
