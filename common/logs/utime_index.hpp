#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/logs/temporary_file.hpp"

namespace crsm {

/// The utimes of all scans so far, in their order of arrival, on the disk: tells a scan that comes again. In memory is
/// only, for each thousand of them, the least and the largest.
class UtimeIndex {
 public:
  void Add(std::int64_t utime);

  /// How many came before it, the first time if it came more than once; nothing if it never came. A utime beyond all so
  /// far is new without a look at the disk. Throws std::runtime_error as TemporaryFile does.
  std::optional<std::int64_t> Find(std::int64_t utime) const;

  /// The least utime that came and is larger; the largest number if there is none. Throws likewise.
  std::int64_t FindNext(std::int64_t utime) const;

  /// The largest utime that came and is not larger; nothing if there is none. Throws likewise.
  std::optional<std::int64_t> FindLast(std::int64_t utime) const;

  std::int64_t size() const { return size_; }

 private:
  /// Of a thousand, from the disk.
  std::vector<std::int64_t> ReadBlock(std::size_t number) const;

  struct Block {
    std::int64_t least;
    std::int64_t largest;
  };

  TemporaryFile file_;
  std::vector<Block> blocks_;
  std::int64_t largest_ = 0;
  std::int64_t size_ = 0;
};

}  // namespace crsm
