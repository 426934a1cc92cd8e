#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// A number as one writes it: the fewest digits that tell it from others, and no exponent.
std::string FormatNumber(double number);
std::string FormatNumber(int number);
std::string FormatNumber(std::uint64_t number);

}  // namespace crsm
