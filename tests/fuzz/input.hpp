#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crsm {

// How the bytes that a fuzzer makes up become what the code under test reads.

using Bytes = std::vector<std::uint8_t>;

/// Several messages as one input, one after the other, each behind its size (2 bytes, high byte first).
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::uint8_t> input) : left_(input) {}

  /// The next message, cut short where the input ends; nothing at its end.
  std::optional<std::span<const std::uint8_t>> Next() {
    if (left_.size() < 2) return std::nullopt;
    const std::size_t size = std::min<std::size_t>(left_[0] * 256u + left_[1], left_.size() - 2);
    const auto message = left_.subspan(2, size);
    left_ = left_.subspan(2 + size);
    return message;
  }

 private:
  std::span<const std::uint8_t> left_;
};

/// The same the other way round. A message may have 65535 bytes.
inline void AppendMessage(Bytes& input, const Bytes& message) {
  input.push_back(static_cast<std::uint8_t>(message.size() >> 8));
  input.push_back(static_cast<std::uint8_t>(message.size() & 0xff));
  input.insert(input.end(), message.begin(), message.end());
}

/// A file in memory, for code that reads files.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::uint8_t> content) : descriptor_(memfd_create("fuzz", 0)) {
    if (write(descriptor_, content.data(), content.size()) != static_cast<ssize_t>(content.size())) std::abort();
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace crsm
