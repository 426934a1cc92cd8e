#pragma once

#include <bit>
#include <cstring>
#include <string>

namespace crsm {

static_assert(std::endian::native == std::endian::little, "numbers are sent and written as they lie in memory");

/// Adds the bytes of a number, the lowest first.
template <class Number>
void Append(std::string& bytes, Number number) {
  const auto at = bytes.size();
  bytes.resize(at + sizeof(number));
  std::memcpy(bytes.data() + at, &number, sizeof(number));
}

}  // namespace crsm
