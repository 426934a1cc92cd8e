#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace crsm {

/// Bytes that are read anywhere: of a file, or of a part of one.
class ByteRange {
 public:
  virtual ~ByteRange() = default;
  virtual std::uint64_t size() const = 0;

  /// `count` bytes from `offset` on, fewer at the end; valid until the next call.
  virtual std::string_view At(std::uint64_t offset, std::size_t count) = 0;
};

/// A file as a whole, of which a part at a time is in memory. A disk that does not give it back is an error in one
/// line, not the end of the process as with a file that is mapped into memory.
class FileWindow : public ByteRange {
 public:
  /// Throws std::runtime_error if the file cannot be opened.
  explicit FileWindow(const std::string& path);
  ~FileWindow() override;
  FileWindow(const FileWindow&) = delete;

  std::uint64_t size() const override { return size_; }

  /// Throws std::runtime_error that names the place if the bytes cannot be read.
  std::string_view At(std::uint64_t offset, std::size_t count) override;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::string buffer_;
  std::uint64_t buffer_at_ = 0;  ///< where in the file the buffer begins
};

}  // namespace crsm
