#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace crsm {

/// The middle one of some values, of an even number the upper one; 0 without any.
inline double FindMedian(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace crsm
