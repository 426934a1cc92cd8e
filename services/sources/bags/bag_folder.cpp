#include "services/sources/bags/bag_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>

#include "common/logs/regular_file.hpp"
#include "common/math/parse_number.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";

/// Of files that are compressed as a whole; what is in them tells how.
constexpr std::array<std::string_view, 6> kEndings{".bz2", ".gz", ".lz4", ".xz", ".zst", ".zstd"};

fs::path WithoutCompression(const fs::path& file) {
  const bool is_packed = std::ranges::count(kEndings, file.extension().string()) > 0;
  return is_packed ? file.parent_path() / file.stem() : file;
}

bool IsStorage(const fs::path& file) {
  const fs::path ending = WithoutCompression(file).extension();
  return ending == ".db3" || ending == ".mcap";
}

/// The entries of the list `relative_file_paths`, which stand below it, a line each.
std::vector<fs::path> ReadMetadata(const fs::path& folder) {
  constexpr std::string_view kBlanksAndQuotes = " \t\r\"'";
  if (!fs::exists(folder / kMetadata)) return {};
  std::istringstream file(ReadWholeFile(folder / kMetadata));
  std::vector<fs::path> paths;
  bool in_list = false;
  for (std::string line; std::getline(file, line);) {
    const std::size_t begin = line.find_first_not_of(' ');
    const bool is_entry = begin != std::string::npos && line[begin] == '-';
    if (in_list && !is_entry) break;
    if (in_list) {
      const std::size_t name = line.find_first_not_of(kBlanksAndQuotes, begin + 1);
      const std::size_t last = line.find_last_not_of(kBlanksAndQuotes);
      if (name == std::string::npos || last < name) continue;
      // Old recorders named the folder too.
      paths.push_back(folder / fs::path(line.substr(name, last - name + 1)).filename());
    }
    in_list = in_list || line.find("relative_file_paths:") != std::string::npos;
  }
  return paths;
}

/// "run_12.db3" is the 12th of "run"; nothing if there is no number.
std::optional<std::pair<std::string, int>> SplitName(const fs::path& file) {
  const std::string stem = WithoutCompression(file).stem().string();
  const std::size_t line = stem.rfind('_');
  if (line == std::string::npos) return std::nullopt;
  const auto number = ParseNumber<int>(std::string_view(stem).substr(line + 1));
  if (!number) return std::nullopt;
  return std::pair(stem.substr(0, line) + WithoutCompression(file).extension().string(), *number);
}

/// By the names of the files.
std::vector<fs::path> GuessFiles(const fs::path& folder) {
  std::map<std::string, std::map<int, fs::path>> recordings;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!IsStorage(entry.path())) continue;
    const auto name = SplitName(entry.path()).value_or(std::pair(entry.path().filename().string(), 0));
    recordings[name.first][name.second] = entry.path();
  }
  if (recordings.size() > 1) {
    throw std::runtime_error(fmt::format("{} has {} recordings and no {}: give the file of one recording",
                                         folder.string(), recordings.size(), kMetadata));
  }
  std::vector<fs::path> paths;
  for (const auto& [name, files] : recordings) {
    for (const auto& [number, path] : files) paths.push_back(path);
  }
  return paths;
}

/// The file that is meant: what compresses a recording, or unpacks it, seldom tells metadata.yaml.
fs::path FindFile(const fs::path& named) {
  if (fs::exists(named)) return named;
  if (const fs::path plain = WithoutCompression(named); fs::exists(plain)) return plain;
  for (const std::string_view ending : kEndings) {
    if (const fs::path packed = named.string() + std::string(ending); fs::exists(packed)) return packed;
  }
  return named;
}

}  // namespace

bool IsBagFolder(const std::string& path) {
  std::error_code error;
  if (fs::exists(fs::path(path) / kMetadata, error)) return true;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    if (IsStorage(entry->path())) return true;
  }
  return false;
}

BagFolder::BagFolder(const std::string& path, WantTopic want) : want_(std::move(want)) {
  const fs::path folder(path);
  std::vector<fs::path> paths = ReadMetadata(folder);
  if (paths.empty()) paths = GuessFiles(folder);
  if (paths.empty()) throw std::runtime_error(fmt::format("{} has no .db3 or .mcap file of rosbag2", path));
  for (const fs::path& named : paths) {
    const fs::path file = FindFile(named);
    if (!fs::exists(file)) {
      throw std::runtime_error(
          fmt::format("{} is missing, but {} names it", file.string(), (folder / kMetadata).string()));
    }
    // The last one of a recording that was killed.
    if (fs::file_size(file) == 0) {
      damage_.truncated = true;
    } else {
      paths_.push_back(file.string());
    }
  }
}

std::optional<std::vector<BagTopic>> BagFolder::ListedTopics() {
  std::vector<BagTopic> topics;
  for (const std::string& path : paths_) {
    const auto listed = OpenBagFile(path, [](const BagTopic&) { return false; })->ListedTopics();
    if (!listed) return std::nullopt;
    topics.insert(topics.end(), listed->begin(), listed->end());
  }
  return topics;
}

std::optional<BagMessage> BagFolder::Next() {
  while (true) {
    if (file_) {
      if (auto message = file_->Next()) return message;
      damage_ = damage();
      file_.reset();
    }
    if (next_ == paths_.size()) return std::nullopt;
    file_ = OpenBagFile(paths_[next_++], want_);
  }
}

double BagFolder::Progress() const {
  const double before = static_cast<double>(next_) - (file_ ? 1.0 - file_->Progress() : 0.0);
  return paths_.empty() ? 1.0 : before / static_cast<double>(paths_.size());
}

BagDamage BagFolder::damage() const {
  const BagDamage of_file = file_ ? file_->damage() : BagDamage();
  return {damage_.num_bad_chunks + of_file.num_bad_chunks, damage_.truncated || of_file.truncated};
}

}  // namespace crsm
