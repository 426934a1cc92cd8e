#pragma once

#include <cstdint>
#include <span>

namespace crsm {

/// The bytes of a file that a client is sent piece by piece.
class Download {
 public:
  virtual ~Download() = default;
  virtual std::uint64_t size() const = 0;
  /// Fills `bytes` with those from `offset` on. Throws std::runtime_error if they are not there any more.
  virtual void Read(std::uint64_t offset, std::span<std::uint8_t> bytes) const = 0;
};

}  // namespace crsm
