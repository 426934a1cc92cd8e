#pragma once

#include <unistd.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"

namespace crsm {

/// A file with the given content, gone at the end of the test.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& content) {
    static int number = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("crsm_scratch_" + std::to_string(getpid()) + "_" + std::to_string(number++));
    std::ofstream(path_, std::ios::binary) << content;
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile() { std::filesystem::remove(path_); }

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// What gzip makes of `content`.
inline std::string Compress(const std::string& content) {
  const ScratchFile file("");
  gzFile out = gzopen(file.path().c_str(), "wb");
  gzwrite(out, content.data(), static_cast<unsigned>(content.size()));
  gzclose(out);
  std::ifstream in(file.path(), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::vector<LaserScan> ReadAll(LaserSource& source) {
  std::vector<LaserScan> scans;
  while (auto scan = source.Next()) scans.push_back(*scan);
  return scans;
}

inline std::int64_t CountOf(const LaserSource& source, const std::string& name) {
  const auto counts = source.Counts();
  const auto found = counts.find(name);
  return found == counts.end() ? 0 : found->second;
}

/// The message of the std::runtime_error that `call` throws; empty if it throws none.
template <class Call>
std::string ErrorOf(Call call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace crsm
