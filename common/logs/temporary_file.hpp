#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crsm {

/// A file that is only written at its end and read anywhere: for what grows with the number of scans and is not to stay
/// in memory. It has no name and goes with the process; it lies in $TMPDIR, or in /var/tmp, which unlike /tmp is no
/// memory.
///
/// All methods throw std::runtime_error, one line, if the disk does not do as it is told.
class TemporaryFile {
 public:
  TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&& other) noexcept;
  ~TemporaryFile();

  void Append(std::span<const std::uint8_t> bytes);

  /// Fills `bytes` with those from `offset` on, all of which must have been appended.
  void Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const;

  std::uint64_t size() const { return written_ + pending_.size(); }

 private:
  void Flush() const;

  int descriptor_ = -1;
  mutable std::uint64_t written_ = 0;
  mutable std::vector<std::uint8_t> pending_;  ///< appended and not written yet
};

}  // namespace crsm
