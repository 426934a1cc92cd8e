#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// A number as one writes it: the fewest digits that tell it from others, and no exponent.
std::string FormatNumber(double number);
std::string FormatNumber(int number);
std::string FormatNumber(std::uint64_t number);

/// A number with so many digits behind its point.
std::string FormatFixed(double number, int num_digits);

}  // namespace crsm
