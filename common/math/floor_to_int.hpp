#pragma once

namespace crsm {

/// Of a value within the integers. std::floor is a function call on the x86-64 that every machine has.
inline int FloorToInt(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

}  // namespace crsm
