#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace crsm {

/// A file that grows at its end, and is written through to the disk twice a second by a thread of its own: who appends
/// waits for the operating system, but not for the disk.
class JournalFile {
 public:
  /// Cuts the file off at `size` bytes, or makes it, and goes on there. Throws std::runtime_error that names it.
  JournalFile(const std::string& path, std::uint64_t size);
  ~JournalFile();
  JournalFile(const JournalFile&) = delete;

  /// Hands bytes to the operating system: they survive the end of the process. All of them, or none and
  /// std::runtime_error; also if the disk did not take those before.
  void Append(std::string_view bytes);

  /// Writes through to the disk now. Throws as Append.
  void Sync();

  std::uint64_t size() const { return size_; }
  /// Of these it is known that they are on the disk; 0 until the thread has come by.
  std::uint64_t synced_bytes() const { return synced_bytes_; }

 private:
  void KeepSynced();
  void SyncThrough();
  [[noreturn]] void Fail(int error) const;

  std::string path_;
  int descriptor_ = -1;
  std::atomic<std::uint64_t> size_;
  std::atomic<std::uint64_t> synced_bytes_ = 0;
  std::atomic<int> sync_error_ = 0;  ///< errno
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::thread syncing_;
};

/// Writes what is in a folder through to the disk: that a file is there, and how it is called.
void SyncFolder(const std::string& folder);

}  // namespace crsm
