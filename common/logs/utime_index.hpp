#pragma once

#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace crsm {

/// Which utimes have come, and as which: exact for any number of them, in memory that hardly grows. They lie in the
/// order of their arrival in a temporary file without a name, 8 bytes each, which is gone with its process. Of each
/// 1,024 only the least and the largest are in memory: a utime beyond all of them is new without a look at the file, as
/// nearly every utime of a log is, and another one costs a read of the blocks that may have it.
class UtimeIndex {
 public:
  /// Throws std::runtime_error if no temporary file can be made; it stands in $TMPDIR, or /tmp.
  UtimeIndex();

  /// Throws std::runtime_error if the file cannot be written.
  void Add(std::int64_t utime);

  /// How many were added before this one, the first time if it was added more than once; nothing if it never was.
  /// Throws std::runtime_error if the file cannot be read.
  std::optional<std::int64_t> Find(std::int64_t utime) const;

  /// How many were added.
  std::int64_t size() const;

 private:
  struct Range {
    std::int64_t least = 0;
    std::int64_t largest = 0;
  };

  std::size_t num_written() const;  ///< blocks
  void WriteBlock(std::size_t block) const;
  std::vector<std::int64_t> ReadBlock(std::size_t block) const;

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::vector<Range> ranges_;       ///< of each block, the one that is not full yet included
  std::vector<std::int64_t> last_;  ///< the block that is not full yet; the others are in the file
  std::int64_t largest_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace crsm
