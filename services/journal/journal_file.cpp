#include "services/journal/journal_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "common/logs/regular_file.hpp"

namespace crsm {

JournalFile::JournalFile(const std::string& path, std::uint64_t size)
    : path_(path), descriptor_(OpenRegularFile(path, O_WRONLY | O_CREAT)), size_(size) {
  if (ftruncate(descriptor_, static_cast<off_t>(size)) != 0) {
    const int error = errno;
    close(descriptor_);
    Fail(error);
  }
  SyncFolder(std::filesystem::path(path).parent_path().string());
  syncing_ = std::thread([this] { KeepSynced(); });
}

JournalFile::~JournalFile() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  syncing_.join();
  close(descriptor_);
}

void JournalFile::Append(std::string_view bytes) {
  if (sync_error_ != 0) Fail(sync_error_);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t num = pwrite(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(size_ + done));
    if (num < 0 && errno == EINTR) continue;
    if (num <= 0) {
      const int error = num == 0 ? ENOSPC : errno;
      // What was half written would be cut off by who reads it, too.
      [[maybe_unused]] const int ignored = ftruncate(descriptor_, static_cast<off_t>(size_));
      Fail(error);
    }
    done += static_cast<std::size_t>(num);
  }
  size_ += bytes.size();
}

void JournalFile::Sync() {
  SyncThrough();
  if (sync_error_ != 0) Fail(sync_error_);
}

void JournalFile::SyncThrough() {
  const std::uint64_t size = size_;
  if (size == synced_bytes_) return;
  if (fdatasync(descriptor_) != 0) {
    sync_error_ = errno;
  } else {
    synced_bytes_ = size;
  }
}

void JournalFile::KeepSynced() {
  constexpr auto kPeriod = std::chrono::milliseconds(500);
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kPeriod, [this] { return ended_; })) {
    lock.unlock();
    SyncThrough();
    lock.lock();
  }
}

void JournalFile::Fail(int error) const {
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", path_, std::strerror(error)));
}

void SyncFolder(const std::string& folder) {
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // one that may be written, but not listed
  fsync(descriptor);
  close(descriptor);
}

}  // namespace crsm
