#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crsm {

/// A file that is only written at its end and read anywhere: for what grows with the number of scans and is not to stay
/// in memory. It has no name and goes with the process; it lies in $TMPDIR, or in /var/tmp, which unlike /tmp is no
/// memory. While the disk is full what is appended waits in memory.
class TemporaryFile {
 public:
  /// Throws std::runtime_error, one line, if no file can be made.
  TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&& other) noexcept;
  ~TemporaryFile();

  void Append(std::span<const std::uint8_t> bytes);

  /// All that was appended is in the file afterwards. Throws std::runtime_error if the disk does not take it.
  void Flush();

  /// Under which this process can open the file, for what takes no less than a path.
  std::string path() const { return kFolder + std::to_string(descriptor_); }

  /// Whether a path is that of such a file. It has no name elsewhere, to which some libraries would follow it.
  static bool IsPath(const std::string& path) { return path.starts_with(kFolder); }

  /// Fills `bytes` with those from `offset` on. Throws std::runtime_error if they were not appended, or if the disk
  /// does not give them back.
  void Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const;

  std::uint64_t size() const { return written_ + pending_.size(); }

 private:
  static constexpr const char* kFolder = "/proc/self/fd/";

  void Write();

  int descriptor_ = -1;
  std::uint64_t written_ = 0;          ///< bytes that are in the file
  std::vector<std::uint8_t> pending_;  ///< behind them
  std::size_t write_at_ = 0;           ///< bytes pending: then they are to be written
};

}  // namespace crsm
