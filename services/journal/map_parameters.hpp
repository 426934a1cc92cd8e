#pragma once

#include <filesystem>

#include "services/journal/journal.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {

/// Takes over the parameters of the map whose journal is in `folder`, if there is one in it. Throws UsageError that
/// names the flag, preset or line of a file that says something else, std::runtime_error as ReadHead.
void AdoptMapParameters(const std::filesystem::path& folder, CommandLine& command_line);

/// The parameters of the map whose journal is in `folder`; the others are the defaults. Throws as ReadHead.
Parameters ReadMapParameters(const std::filesystem::path& folder);

/// AdoptMapParameters of the earlier run, the --out of which `resume` or --localize names, if one of them does.
void AdoptEarlierMapParameters(const std::string& resume, CommandLine& command_line);

/// For a process whose scans are made by others, which cannot see the journal: these are to be told the same parameters
/// of the laser. Throws UsageError with the flags for all of them if this one was told others than the journal's.
void CheckLaserParameters(const std::filesystem::path& folder, const CommandLine& command_line);

}  // namespace crsm
