#include "common/logs/replacement.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "common/logs/map_picture.hpp"

namespace crsm {

bool WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Replacement::~Replacement() {
  for (const std::string& name : names_) unlink(Temporary(name).c_str());
}

void Replacement::Write(const std::string& name, std::string_view bytes) {
  Write(name, [bytes](const Sink& sink) { sink(bytes); });
}

void Replacement::Write(const std::string& name, const std::function<void(const Sink&)>& produce) {
  names_.push_back(name);
  const int descriptor =
      open(Temporary(name).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  if (descriptor < 0) Fail(name, errno);
  int error = 0;
  produce([&](std::string_view bytes) {
    if (error == 0 && !WriteAll(descriptor, bytes)) error = errno;
    return error == 0;
  });
  if (error == 0 && fsync(descriptor) != 0) error = errno;
  close(descriptor);
  if (error != 0) Fail(name, error);
}

bool Replacement::Has(const std::string& name) const { return std::ranges::find(names_, name) != names_.end(); }

void Replacement::RemoveOthers(std::span<const char* const> names) const {
  for (const char* name : names) {
    std::error_code error;
    if (!Has(name)) std::filesystem::remove(dir_ / name, error);
    if (error) throw std::runtime_error(fmt::format("cannot remove {}: {}", (dir_ / name).string(), error.message()));
  }
}

void Replacement::Rename() {
  for (const std::string& name : names_) {
    if (rename(Temporary(name).c_str(), (dir_ / name).c_str()) != 0) Fail(name, errno);
  }
  names_.clear();
}

/// Bears the process id, so that two processes with the same folder never mix their bytes.
std::filesystem::path Replacement::Temporary(const std::string& name) const {
  return dir_ / fmt::format(".{}.{}.tmp", name, getpid());
}

void RemoveLeftovers(const std::filesystem::path& dir) {
  constexpr std::array<std::string_view, 9> kResults{"map",     "overview", "trajectory", "truth", "graph",
                                                     "summary", "marks",    "keepout",    "slow"};
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(dir, error)) {
    const std::string name = entry.path().filename().string();
    char result[16];
    int writer = 0;
    int length = 0;
    const bool is_ours =
        std::sscanf(name.c_str(), ".%15[a-z].%*[a-z2].%9d.tmp%n", result, &writer, &length) == 2 ||
        std::sscanf(name.c_str(), ".%15[a-z].%*[0-9].%*[a-z].%9d.tmp%n", result, &writer, &length) == 2;
    if (!is_ours) continue;
    if (std::cmp_not_equal(length, name.size()) || writer < 1) continue;
    if (std::ranges::find(kResults, result) == kResults.end()) continue;
    if (kill(writer, 0) != 0 && errno == ESRCH) std::filesystem::remove(entry.path(), error);
  }
  RemoveOldPictures(dir);
}

void Replacement::Fail(const std::string& name, int error) const {
  throw std::runtime_error(fmt::format("cannot write {}: {}", (dir_ / name).string(), std::strerror(error)));
}

}  // namespace crsm
