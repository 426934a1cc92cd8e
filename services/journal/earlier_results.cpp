#include "services/journal/earlier_results.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "services/base/process.hpp"
#include "services/base/usage_error.hpp"
#include "services/journal/journal.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// Everything that a run leaves in its folder.
constexpr std::array kResults{"map.png",   "map.pgm",      "map.yaml", "overview.png", "trajectory.tum", "truth.tum",
                              "graph.g2o", "summary.json", "journal",  "log",          "pieces"};

/// Those of them that a run writes over.
constexpr std::array kWrittenAnew{"map.png", "map.pgm", "map.yaml", "overview.png", "graph.g2o", "summary.json"};

bool HasContent(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return error ? fs::exists(fs::symlink_status(file, error)) : size > 0;  // what is no file is not ours
}

/// A run that saw no scan leaves nothing that is worth keeping: no poses, and one unexplored cell. Without a trajectory
/// such files are not of a run: somebody's own map.
bool HoldsResults(const fs::path& out) {
  if (HasContent(JournalPath(JournalFolder(out))) || HasContent(out / "trajectory.tum")) return true;
  std::error_code error;
  if (fs::exists(out / "trajectory.tum", error)) return false;
  return std::ranges::any_of(kWrittenAnew, [&](const char* name) { return HasContent(out / name); });
}

/// The first of earlier.1, earlier.2 ... that is not there. Below the folder itself: beside it there may be another
/// disk, or no right to write.
fs::path FindPlaceAside(const fs::path& out) {
  for (int number = 1;; ++number) {
    fs::path place = out / fmt::format("earlier.{}", number);
    if (!fs::exists(fs::symlink_status(place))) return place;
  }
}

void MoveAside(const std::string& program, const fs::path& out) {
  const fs::path place = FindPlaceAside(out);
  fs::create_directory(place);
  for (const char* name : kResults) {
    if (fs::exists(fs::symlink_status(out / name))) fs::rename(out / name, place / name);
  }
  Say(fmt::format("{}: the earlier results in {} are now in {}", program, out.string(), place.string()));
}

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
  if (earlier.resume.empty() || !AreSame(earlier.resume, out)) {
    if (!HoldsResults(out)) {
      RemoveJournal(out);  // which is empty
    } else if (earlier.force) {
      MoveAside(program, out);
    } else {
      throw std::runtime_error(
          fmt::format("--out {}: holds the results of an earlier run: --resume {} continues its map, --force moves "
                      "them to {}, or choose another folder",
                      out.string(), out.string(), FindPlaceAside(out).string()));
    }
  }
  if (!earlier.resume.empty()) TakeOverJournal(earlier.resume, out);
}

fs::path FindJournal(const fs::path& results) {
  fs::path journal = JournalPath(JournalFolder(results));
  if (!fs::exists(journal)) throw std::runtime_error(fmt::format("there is no file {}", journal.string()));
  return journal;
}

}  // namespace crsm
