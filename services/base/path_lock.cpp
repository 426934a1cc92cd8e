#include "services/base/path_lock.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "services/base/process_info.hpp"

namespace crsm {
namespace {

/// Who holds a lock on a file, by the kernel's list of all locks, whose lines are like
/// "1: FLOCK  ADVISORY  WRITE 4711 fe:01:123456 0 EOF".
std::string FindLockHolder(const struct stat& file) {
  const std::string wanted = fmt::format("{:02x}:{:02x}:{}", major(file.st_dev), minor(file.st_dev), file.st_ino);
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, advisory, access, place;
    pid_t pid = 0;
    if (words >> number >> kind >> advisory >> access >> pid >> place && kind == "FLOCK" && place == wanted) {
      return DescribeProcess(pid);
    }
  }
  return "another process";
}

}  // namespace

PathLock::PathLock(const std::string& flag, const std::filesystem::path& path) : path_(path) {
  do {
    Take(flag);
  } while (!IsInPlace());  // another process had it, and has put another file in its place
}

void PathLock::Take(const std::string& flag) {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a FIFO would let us wait
  struct stat file {};
  std::string reason;
  if (descriptor_ < 0 || fstat(descriptor_, &file) != 0) {
    reason = fmt::format("cannot be read: {}", std::strerror(errno));
  } else if (!S_ISDIR(file.st_mode) && !S_ISREG(file.st_mode)) {
    reason = "is neither a folder nor a file";
  } else if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    reason = fmt::format("{} writes there; stop it, or choose another path", FindLockHolder(file));
  }
  if (reason.empty()) return;
  if (descriptor_ >= 0) close(descriptor_);
  throw std::runtime_error(fmt::format("{} {}: {}", flag, path_.string(), reason));
}

PathLock::~PathLock() { close(descriptor_); }

bool PathLock::IsInPlace() const {
  struct stat locked {};
  struct stat found {};
  return fstat(descriptor_, &locked) == 0 && stat(path_.c_str(), &found) == 0 && locked.st_dev == found.st_dev &&
         locked.st_ino == found.st_ino;
}

}  // namespace crsm
