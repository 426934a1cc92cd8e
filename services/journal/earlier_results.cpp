#include "services/journal/earlier_results.hpp"

#include <fmt/core.h>

#include <stdexcept>

#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/move_aside.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

bool AreSame(const fs::path& one, const fs::path& other) {
  std::error_code error;
  return fs::equivalent(one, other, error);
}

}  // namespace

void AddFlags(CommandLine& command_line, EarlierResults& earlier) {
  command_line.AddOption(
      "--resume", earlier.resume,
      "continue the map of an earlier run, whose --out may be this run's too; scans that are in the map already are "
      "skipped",
      {kEarlierRunsHeading, "DIR"});
  command_line.AddFlag("--force", earlier.force, "move the results of an earlier run in --out to a folder below it",
                       kEarlierRunsHeading);
}

void CheckEarlierResults(const EarlierResults& earlier, const std::string& source, const Settings& settings) {
  if (settings.out.empty()) throw UsageError("--out is missing: give the folder for the results");
  const bool resume = !earlier.resume.empty();
  if (!settings.start.empty() && settings.localize.empty() && !resume) {
    throw UsageError("--start: needs a finished map: add --localize DIR, or a map to continue: --resume DIR");
  }
  if (resume && !settings.localize.empty()) {
    throw UsageError("--resume extends a map and --localize does not change it: give only one of them");
  }
  if (!settings.localize.empty() && AreSame(settings.localize, settings.out)) {
    throw UsageError(
        fmt::format("--localize {}: this folder must stay as it is: choose another --out", settings.localize));
  }
  if (resume && earlier.force) {
    throw UsageError("--resume extends a map and --force begins a new one: give only one of them");
  }
  if (!resume && AreSame(source, JournalPath(JournalFolder(settings.out)))) {
    throw UsageError(
        fmt::format("--out {}: the log to read is the journal in this folder: choose another folder", settings.out));
  }
}

void MakeRoom(const std::string& program, const fs::path& out, const EarlierResults& earlier) {
  RemoveHalfJournal(out);
  if (earlier.resume.empty() || !AreSame(earlier.resume, out)) {
    if (!HoldsResults(out)) {
      RemoveJournal(out);  // which is empty
    } else if (earlier.force) {
      const fs::path place = MoveAside(out);
      Say(fmt::format("{}: the earlier results in {} are now in {}", program, out.string(), place.string()));
    } else {
      throw std::runtime_error(
          fmt::format("--out {}: holds the results of an earlier run: --resume {} continues its map, --force moves "
                      "them to {}, or choose another folder",
                      out.string(), out.string(), FindPlaceAside(out).string()));
    }
  }
  if (earlier.resume.empty()) return;
  const EndsAtOnce ends_at_once(
      fmt::format("{}: stopped before the map of {} was made again: nothing was written", program, earlier.resume));
  TakeOverJournal(earlier.resume, out);
}

fs::path FindJournal(const fs::path& results) {
  fs::path journal = JournalPath(JournalFolder(results));
  if (!fs::exists(journal)) throw std::runtime_error(fmt::format("there is no file {}", journal.string()));
  return journal;
}

}  // namespace crsm
