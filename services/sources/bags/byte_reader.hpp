#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace crsm {

static_assert(std::endian::native == std::endian::little, "numbers are read as they lie in memory");

/// Takes numbers and texts from bytes, one after the other. The first that is not there makes `ok` false for good, so
/// that a record is read straight through and judged at its end.
class ByteReader {
 public:
  struct Layout {
    bool aligned = false;     ///< each number at a multiple of its size, as in CDR
    bool big_endian = false;  ///< the highest byte first
  };
  explicit ByteReader(std::string_view bytes) : ByteReader(bytes, Layout{}) {}
  ByteReader(std::string_view bytes, Layout layout) : bytes_(bytes), layout_(layout) {}

  bool ok() const { return ok_; }
  std::size_t left() const { return bytes_.size() - at_; }
  std::size_t at() const { return at_; }

  /// 0 if it is not there.
  template <class Number>
  Number Read() {
    if (layout_.aligned) Take((sizeof(Number) - at_ % sizeof(Number)) % sizeof(Number));
    char raw[sizeof(Number)] = {};
    const std::string_view bytes = Take(sizeof(Number));
    std::copy(bytes.begin(), bytes.end(), raw);
    if (layout_.big_endian) std::reverse(raw, raw + sizeof(Number));
    Number number{};
    std::memcpy(&number, raw, sizeof(Number));
    return number;
  }

  /// So many bytes; none if they are not all there.
  std::string_view Take(std::uint64_t size) {
    ok_ = ok_ && size <= left();
    if (!ok_) return {};
    at_ += static_cast<std::size_t>(size);
    return bytes_.substr(at_ - static_cast<std::size_t>(size), static_cast<std::size_t>(size));
  }

  /// Bytes behind their number.
  template <class Size = std::uint32_t>
  std::string_view Text() {
    const auto size = Read<Size>();
    return Take(size);
  }

 private:
  std::string_view bytes_;
  Layout layout_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace crsm
