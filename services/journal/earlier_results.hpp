#pragma once

#include <filesystem>
#include <string>

#include "services/settings/command_line.hpp"

namespace crsm {

/// What becomes of results that are in a folder already, for the programs that make maps.
struct EarlierResults {
  std::string resume;  ///< folder of the run whose map goes on, --out itself or another; empty for none
  bool force = false;  ///< move them aside
};

/// The flags that say so: --resume and --force.
void AddFlags(CommandLine& command_line, EarlierResults& earlier);

/// Throws UsageError if there is no --out, or if these cannot be meant together with what else the user said: two maps
/// to begin with, a map that would be written over by who is to leave it as it is, or a `source` that is --out's own
/// journal.
void CheckEarlierResults(const EarlierResults& earlier, const std::string& source, const Settings& settings);

/// Makes room in `out` for the results of a run, and for its journal: that of the map which goes on is there then, or
/// none. Results of an earlier run stay as they are and where they are, unless they are resumed or, by --force, moved
/// into a folder below, which is said in the name of `program`. Throws std::runtime_error in one line if they are in
/// the way.
void MakeRoom(const std::string& program, const std::filesystem::path& out, const EarlierResults& earlier);

/// journal.lcm in the results of an earlier run. Throws std::runtime_error if there is none.
std::filesystem::path FindJournal(const std::filesystem::path& results);

}  // namespace crsm
