#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace crsm {

/// The number that the whole of a text is; nothing if it is none, or beyond its type.
template <class Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace crsm
