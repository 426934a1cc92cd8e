#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace crsm {

/// A number as one writes it: the fewest digits that tell it from others, and no exponent.
std::string FormatNumber(double number);
std::string FormatNumber(int number);
std::string FormatNumber(std::uint64_t number);

/// "1 scan", "2 scans". noun: of one, and with an s of several.
std::string FormatCount(std::int64_t num, std::string_view noun);

}  // namespace crsm
