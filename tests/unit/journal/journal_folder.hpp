#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "services/journal/journal.hpp"
#include "synthetic_scans.hpp"

namespace crsm {

namespace fs = std::filesystem;

inline const JournalSubject kMapping{false, {{"cell_size_m", "0.05"}, {"join_hits", "true"}}};

/// A folder, gone at the end of the test.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("crsm_journal_" + std::to_string(getpid()))) { fs::remove_all(path_); }
  ~Folder() { fs::remove_all(path_); }
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

inline CriticalRays Scan(std::int64_t utime) { return RaysOf(ScanRoom({}, utime, 10)); }
inline ScanMatch Match(std::int64_t utime) {
  return {utime, {0.1 * static_cast<double>(utime), 0.0, 0.0}, 0.5, 1, 1, 0, MatchState::kOk};
}

inline std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void Write(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

}  // namespace crsm
