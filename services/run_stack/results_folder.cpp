#include "services/run_stack/results_folder.hpp"

#include <fmt/core.h>

#include <array>
#include <stdexcept>

#include "services/runtime/service.hpp"
#include "services/sources/journal.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// Everything that a run leaves in its folder.
constexpr std::array kResults{"map.png",   "map.yaml",     "overview.png", "trajectory.tum",
                              "truth.tum", "summary.json", "journal",      "log"};

bool HasContent(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return error ? fs::exists(fs::symlink_status(file, error)) : size > 0;  // what is no file is not ours
}

/// A run that saw no scan leaves nothing that is worth keeping: no poses, and one unexplored cell.
bool HoldsResults(const fs::path& out) {
  std::error_code error;
  return HasContent(JournalPath(JournalFolder(out))) || HasContent(out / "trajectory.tum") ||
         (fs::exists(out / "map.png", error) && !fs::exists(out / "trajectory.tum", error));
}

/// The first of earlier.1, earlier.2 ... that is not there. Below the folder itself: beside it there may be another
/// disk, or no right to write.
fs::path FindPlaceAside(const fs::path& out) {
  for (int number = 1;; ++number) {
    fs::path place = out / fmt::format("earlier.{}", number);
    if (!fs::exists(fs::symlink_status(place))) return place;
  }
}

void MoveAside(const fs::path& out) {
  const fs::path place = FindPlaceAside(out);
  fs::create_directory(place);
  for (const char* name : kResults) {
    if (fs::exists(fs::symlink_status(out / name))) fs::rename(out / name, place / name);
  }
  Say(fmt::format("run_stack: the earlier results in {} are now in {}", out.string(), place.string()));
}

void MakeRoom(const fs::path& out, const EarlierResults& earlier) {
  std::error_code error;
  if (!earlier.resume.empty() && fs::equivalent(earlier.resume, out, error)) return;
  if (!HoldsResults(out)) return RemoveJournal(out);  // which is empty
  if (earlier.force) return MoveAside(out);
  throw std::runtime_error(
      fmt::format("--out {}: holds the results of an earlier run: --resume {} goes on with its map, --force moves them "
                  "to {}, or choose another folder",
                  out.string(), out.string(), FindPlaceAside(out).string()));
}

}  // namespace

ResultsFolder::ResultsFolder(const fs::path& out, const EarlierResults& earlier) : out_(out) {
  PrepareFolder(out_.string());
  const PathLock out_lock("--out", out_);  // for the time being: map_exporter will want it
  std::error_code error;
  if (fs::exists(log_folder(), error)) log_lock_.emplace("--out", log_folder());
  MakeRoom(out_, earlier);
  if (!earlier.resume.empty()) TakeOverJournal(earlier.resume, out_);
  fs::create_directories(log_folder(), error);
  if (error) throw std::runtime_error(fmt::format("--out {}: cannot be written: {}", out_.string(), error.message()));
  log_lock_.reset();
  log_lock_.emplace("--out", log_folder());
  fs::remove(summary(), error);  // so that none of an earlier run is taken for one of this
}

std::optional<std::uintmax_t> ResultsFolder::JournalBytes() const {
  std::error_code error;
  const auto size = fs::file_size(JournalPath(journal_folder()), error);
  return error ? std::nullopt : std::optional(size);
}

bool ResultsFolder::IsInPlace() {
  const bool has_journal = JournalBytes().has_value();
  had_journal_ = had_journal_ || has_journal;
  return log_lock_->IsInPlace() && has_journal == had_journal_;
}

fs::path FindJournal(const fs::path& results) {
  fs::path journal = JournalPath(JournalFolder(results));
  if (!fs::exists(journal)) throw std::runtime_error(fmt::format("there is no file {}", journal.string()));
  return journal;
}

}  // namespace crsm
