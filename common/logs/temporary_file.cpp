#include "common/logs/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
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

TemporaryFile::TemporaryFile() : write_at_(kPendingBytes) {
  std::string path = Folder() + "/crsm_XXXXXX";
  descriptor_ = mkostemp(path.data(), O_CLOEXEC);
  if (descriptor_ < 0) Fail("cannot be made");
  unlink(path.c_str());
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      written_(std::exchange(other.written_, 0)),
      pending_(std::move(other.pending_)),
      write_at_(other.write_at_) {}

TemporaryFile& TemporaryFile::operator=(TemporaryFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(written_, other.written_);
  std::swap(pending_, other.pending_);
  std::swap(write_at_, other.write_at_);
  return *this;
}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void TemporaryFile::Append(std::span<const std::uint8_t> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  if (pending_.size() >= write_at_) Write();
}

void TemporaryFile::Flush() {
  Write();
  if (!pending_.empty()) Fail("cannot be written");
}

void TemporaryFile::Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const {
  if (offset + bytes.size() > size()) throw std::runtime_error("a temporary file was read beyond its end");
  while (!bytes.empty() && offset < written_) {
    const auto wanted = std::min<std::uint64_t>(bytes.size(), written_ - offset);
    const ssize_t num = pread(descriptor_, bytes.data(), wanted, static_cast<off_t>(offset));
    if (num < 0 && errno == EINTR) continue;
    if (num <= 0) Fail("cannot be read");
    bytes = bytes.subspan(static_cast<std::size_t>(num));
    offset += static_cast<std::uint64_t>(num);
  }
  if (bytes.empty()) return;
  const auto from = pending_.begin() + static_cast<std::ptrdiff_t>(offset - written_);
  std::copy_n(from, bytes.size(), bytes.begin());
}

/// Writes what is pending. What the disk does not take stays, and is tried again when as much once more has come.
void TemporaryFile::Write() {
  std::size_t done = 0;
  while (done < pending_.size()) {
    const ssize_t num =
        pwrite(descriptor_, pending_.data() + done, pending_.size() - done, static_cast<off_t>(written_ + done));
    if (num < 0 && errno == EINTR) continue;
    if (num <= 0) break;
    done += static_cast<std::size_t>(num);
  }
  written_ += done;
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(done));
  write_at_ = pending_.size() + kPendingBytes;
}

}  // namespace crsm
