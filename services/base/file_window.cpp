#include "services/base/file_window.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "common/logs/regular_file.hpp"

namespace crsm {
namespace {

constexpr std::size_t kWindowBytes = std::size_t{1} << 18;

}  // namespace

FileWindow::FileWindow(const std::string& path)
    : path_(path),
      descriptor_(OpenRegularFile(path, O_RDONLY)),
      size_(static_cast<std::uint64_t>(std::max<off_t>(0, lseek(descriptor_, 0, SEEK_END)))) {}

FileWindow::~FileWindow() { close(descriptor_); }

std::string_view FileWindow::At(std::uint64_t offset, std::size_t count) {
  if (offset >= size_) return {};
  count = static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - offset));
  if (offset < buffer_at_ || offset + count > buffer_at_ + buffer_.size()) {
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(std::max(count, kWindowBytes), size_ - offset)));
    buffer_at_ = offset;
    for (std::size_t done = 0; done < buffer_.size();) {
      const ssize_t num =
          pread(descriptor_, buffer_.data() + done, buffer_.size() - done, static_cast<off_t>(offset + done));
      if (num < 0 && errno == EINTR) continue;
      if (num < 0) {
        throw std::runtime_error(
            fmt::format("cannot read {} from byte {} on: {}", path_, offset + done, std::strerror(errno)));
      }
      if (num == 0) buffer_.resize(done);  // it was cut off meanwhile
      done += static_cast<std::size_t>(num);
    }
  }
  const auto begin = static_cast<std::size_t>(offset - buffer_at_);
  return std::string_view(buffer_).substr(std::min(begin, buffer_.size()), count);
}

}  // namespace crsm
