#pragma once

#include <CLI/CLI.hpp>

namespace crsm {

/// Each adds one command of slam_eval, which runs within `app.parse` and throws std::exception if it fails.
void AddRelationsCommand(CLI::App& app);

}  // namespace crsm
