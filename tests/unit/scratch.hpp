#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace crsm {

/// A path that no other test has.
inline std::filesystem::path ScratchPath() {
  static int number = 0;
  return std::filesystem::temp_directory_path() /
         ("crsm_scratch_" + std::to_string(getpid()) + "_" + std::to_string(number++));
}

/// A file with the given content, gone at the end of the test.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& content) { std::ofstream(path_, std::ios::binary) << content; }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile() { std::filesystem::remove(path_); }

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_ = ScratchPath();
};

/// A folder, gone with all that is in it at the end of the test.
class ScratchFolder {
 public:
  ScratchFolder() { std::filesystem::create_directory(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() { std::filesystem::remove_all(path_); }

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  void Write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
  }

 private:
  std::filesystem::path path_ = ScratchPath();
};

/// What a file holds.
inline std::string BytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The message of the std::exception that `call` throws; empty if it throws none.
template <class Call>
std::string ErrorOf(Call call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace crsm
