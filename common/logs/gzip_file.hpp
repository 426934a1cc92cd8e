#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

struct gzFile_s;

namespace crsm {

/// Reads a file from front to back, plain or compressed by gzip: which of the two is found from its content.
class GzipFile {
 public:
  static constexpr std::size_t kMaxLineBytes = std::size_t{1} << 20;

  struct Line {
    std::string_view text;  ///< without the end of the line; valid until the next call
    bool too_long = false;  ///< more than kMaxLineBytes: `text` is empty, the line was skipped
  };

  /// Throws std::runtime_error if the file cannot be opened.
  explicit GzipFile(const std::string& path);

  /// What follows from the current place on: at least `size` bytes, fewer only at the end of the file. Valid until the
  /// next call. Memory follows what the file holds, not `size`. Throws std::runtime_error if the file cannot be read.
  std::string_view Peek(std::size_t size);

  /// Moves on by `size` bytes that Peek has shown.
  void Skip(std::size_t size) { begin_ += size; }

  /// The next line; the last one may lack its line end. Nothing at the end of the file. A byte order mark before the
  /// first line is none of it. Throws as Peek.
  std::optional<Line> ReadLine();

  /// How much of the file has been taken, [0, 1], by its size on the disk.
  double Progress() const;

  /// True once the compressed stream has turned out to be cut short or damaged; what was whole has been read.
  bool truncated() const { return truncated_; }

  /// Whether gzip has compressed it; known once Peek has shown something.
  bool is_compressed() const;

  const std::string& path() const { return path_; }

 private:
  void FillBuffer();

  std::string path_;
  std::unique_ptr<gzFile_s, int (*)(gzFile_s*)> file_;
  std::uintmax_t file_bytes_ = 0;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  ///< of what has not been taken yet, in buffer_
  std::size_t end_ = 0;    ///< of what has been read
  std::uint64_t read_bytes_ = 0;
  bool is_within_ = false;  ///< a line has been read
  bool at_end_ = false;
  bool truncated_ = false;
};

}  // namespace crsm
