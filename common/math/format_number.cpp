#include "common/math/format_number.hpp"

#include <array>
#include <charconv>

namespace crsm {
namespace {

template <class Number, class... How>
std::string Format(Number number, How... how) {
  std::array<char, 400> text;  // the longest double has 309 digits before its point
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number, how...).ptr};
}

}  // namespace

std::string FormatNumber(double number) { return Format(number, std::chars_format::fixed); }
std::string FormatNumber(int number) { return Format(number); }
std::string FormatNumber(std::uint64_t number) { return Format(number); }

std::string FormatCount(std::int64_t num, std::string_view noun) {
  return std::to_string(num) + " " + std::string(noun) + (num == 1 ? "" : "s");
}

}  // namespace crsm
