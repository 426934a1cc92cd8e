#include "services/journal/move_aside.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "common/logs/map_picture.hpp"
#include "common/results/map_edits.hpp"
#include "common/results/mark_files.hpp"
#include "services/journal/journal.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// Everything that a run leaves in its folder.
constexpr std::array kResults{"map.png",   "map.pgm",    "map.yaml",     "overview.png", "trajectory.tum",
                              "truth.tum", "graph.g2o",  "summary.json", "journal",      "log",
                              "pieces",    "changes.csv"};  // and those of marks and edits

/// Those of them that a run writes over.
constexpr std::array kWrittenAnew{"map.png",   "map.pgm",      "map.yaml",   "overview.png",
                                  "graph.g2o", "summary.json", "changes.csv"};

bool HasContent(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return error ? fs::exists(fs::symlink_status(file, error)) : size > 0;  // what is no file is not ours
}

}  // namespace

bool HoldsResults(const fs::path& out) {
  if (HasContent(JournalPath(JournalFolder(out))) || HasContent(out / "trajectory.tum")) return true;
  std::error_code error;
  if (fs::exists(out / "trajectory.tum", error)) return false;
  return std::ranges::any_of(kWrittenAnew, [&](const char* name) { return HasContent(out / name); });
}

fs::path FindPlaceAside(const fs::path& out) {
  for (int number = 1;; ++number) {
    fs::path place = out / fmt::format("earlier.{}", number);
    if (!fs::exists(fs::symlink_status(place))) return place;
  }
}

fs::path MoveAside(const fs::path& out) {
  fs::path place = FindPlaceAside(out);
  fs::create_directory(place);
  const auto Move = [&](const char* name) {
    if (fs::exists(fs::symlink_status(out / name))) fs::rename(out / name, place / name);
  };
  std::ranges::for_each(kResults, Move);
  std::ranges::for_each(kMarkFiles, Move);
  std::ranges::for_each(kEditedFiles, Move);
  Move(kEditsFile);
  if (const std::string picture = FindPicture(place); picture != kMapPicture && fs::exists(out / picture)) {
    fs::rename(out / picture, place / picture);
  }
  return place;
}

}  // namespace crsm
