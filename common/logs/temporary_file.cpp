#include "common/logs/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace crsm {
namespace {

constexpr std::size_t kPendingBytes = std::size_t{1} << 14;

std::string Folder() {
  const char* folder = std::getenv("TMPDIR");
  return folder && *folder ? folder : "/var/tmp";
}

[[noreturn]] void Fail(const char* what) {
  throw std::runtime_error(
      fmt::format("a temporary file in {} {}: {}; TMPDIR names another folder", Folder(), what, std::strerror(errno)));
}

}  // namespace

TemporaryFile::TemporaryFile() {
  std::string path = Folder() + "/crsm_XXXXXX";
  descriptor_ = mkostemp(path.data(), O_CLOEXEC);
  if (descriptor_ < 0) Fail("cannot be made");
  unlink(path.c_str());
  pending_.reserve(kPendingBytes);
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      written_(std::exchange(other.written_, 0)),
      pending_(std::move(other.pending_)) {}

TemporaryFile& TemporaryFile::operator=(TemporaryFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(written_, other.written_);
  std::swap(pending_, other.pending_);
  return *this;
}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void TemporaryFile::Append(std::span<const std::uint8_t> bytes) {
  if (pending_.size() + bytes.size() > kPendingBytes) Flush();
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
}

void TemporaryFile::Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const {
  if (offset + bytes.size() > size()) throw std::runtime_error("a temporary file was read beyond its end");
  if (offset + bytes.size() > written_) Flush();
  while (!bytes.empty()) {
    const ssize_t num = pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (num < 0 && errno == EINTR) continue;
    if (num <= 0) Fail("cannot be read");
    bytes = bytes.subspan(static_cast<std::size_t>(num));
    offset += static_cast<std::uint64_t>(num);
  }
}

void TemporaryFile::Flush() const {
  std::span<const std::uint8_t> left = pending_;
  while (!left.empty()) {
    const ssize_t num = pwrite(descriptor_, left.data(), left.size(), static_cast<off_t>(written_));
    if (num < 0 && errno == EINTR) continue;
    if (num < 0) {
      pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(left.size()));
      Fail("cannot be written");
    }
    left = left.subspan(static_cast<std::size_t>(num));
    written_ += static_cast<std::uint64_t>(num);
  }
  pending_.clear();
}

}  // namespace crsm
