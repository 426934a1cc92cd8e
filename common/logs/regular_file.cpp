#include "common/logs/regular_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace crsm {
namespace {

std::string ReadAll(int descriptor, std::size_t most_bytes) {
  std::string text;
  while (true) {
    const std::size_t begin = text.size();
    text.resize(begin + (std::size_t{1} << 16));
    const ssize_t num = read(descriptor, text.data() + begin, text.size() - begin);
    text.resize(begin + static_cast<std::size_t>(std::max<ssize_t>(num, 0)));
    if (num < 0 && errno == EINTR) continue;
    if (num < 0) throw std::runtime_error(std::strerror(errno));
    if (num == 0) return text;
    if (text.size() > most_bytes) throw std::runtime_error(fmt::format("is larger than {} bytes", most_bytes));
  }
}

}  // namespace

int OpenRegularFile(const std::filesystem::path& path, int flags, mode_t mode) {
  const int descriptor = open(path.c_str(), flags | O_NONBLOCK | O_CLOEXEC, mode);
  struct stat status {};
  if (descriptor >= 0 && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) return descriptor;
  const int error = descriptor < 0 ? errno : ENXIO;
  if (descriptor >= 0) close(descriptor);
  throw std::runtime_error(fmt::format("cannot {} {}: {}", (flags & O_ACCMODE) == O_RDONLY ? "read" : "write",
                                       path.string(), error == ENXIO ? "is no regular file" : std::strerror(error)));
}

std::string ReadWholeFile(const std::filesystem::path& path, std::size_t most_bytes) {
  const int descriptor = OpenRegularFile(path, O_RDONLY);
  try {
    std::string text = ReadAll(descriptor, most_bytes);
    close(descriptor);
    return text;
  } catch (const std::runtime_error& error) {
    close(descriptor);
    throw std::runtime_error(fmt::format("cannot read {}: {}", path.string(), error.what()));
  }
}

}  // namespace crsm
