#include "common/math/beam_angles.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace crsm {

SinCos LookUpSinCos(double angle_rad) {
  struct Entry {
    double angle_rad = std::numeric_limits<double>::quiet_NaN();
    SinCos value{};
  };
  constexpr unsigned kBits = 9;
  constexpr std::uint64_t kMix = 0x9e3779b97f4a7c15;  // 2^64 / golden ratio: neighbouring angles come to lie apart
  thread_local std::array<Entry, std::size_t{1} << kBits> table;
  Entry& entry = table[(std::bit_cast<std::uint64_t>(angle_rad) * kMix) >> (64 - kBits)];
  if (entry.angle_rad != angle_rad) entry = {angle_rad, ComputeSinCos(angle_rad)};
  return entry.value;
}

}  // namespace crsm
