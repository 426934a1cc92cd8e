#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/math/format_number.hpp"
#include "common/math/parse_number.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// A value as somebody wrote it: on a command line, where all is text, or in a file, where its type shows.
struct WrittenValue {
  enum class Kind { kFlag, kNumber, kBoolean, kString, kOther } kind;
  std::string text;
};

/// "a, b, c".
template <class Names>
std::string JoinNames(const Names& names) {
  std::string joined;
  for (const auto& name : names) joined.append(joined.empty() ? "" : ", ").append(name);
  return joined;
}

/// Gives one key a value, as a visitor of VisitParameters. Throws std::runtime_error that names the key and says what
/// would be right.
class ValueSetter {
 public:
  ValueSetter(std::string key, WrittenValue value) : key_(std::move(key)), value_(std::move(value)) {}

  template <class... Rest>
  void operator()(const ParameterInfo& info, Rest&&... rest) {
    (*this)(info.key, info.help, std::forward<Rest>(rest)...);
  }
  template <class... Rest>
  void operator()(const char* key, const char*, Rest&&... rest) {
    keys_.emplace_back(key);
    if (key_ == key) Set(std::forward<Rest>(rest)...);
  }

  /// Whether one of those that were visited has the key.
  bool found() const { return found_; }

  /// All that were visited.
  const std::vector<std::string>& keys() const { return keys_; }

 private:
  using Kind = WrittenValue::Kind;

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void Set(Number& number, Number low, Number high) {
    const std::optional<Number> parsed = ParseNumber<Number>(value_.text);
    if (!Is(Kind::kNumber) || !parsed || !(*parsed >= low && *parsed <= high)) Refuse(RangeText(low, high));
    number = *parsed;
  }
  void Set(bool& flag) {
    if (!Is(Kind::kBoolean) || (value_.text != "true" && value_.text != "false")) Refuse("true or false");
    flag = value_.text == "true";
  }
  void Set(std::string& text) {
    if (!Is(Kind::kString)) Refuse("a string in quotes");
    text = value_.text;
  }
  template <class Enum, std::size_t N>
  void Set(Enum& choice, const std::array<std::string_view, N>& names) {
    const auto name = std::find(names.begin(), names.end(), value_.text);
    if (!Is(Kind::kString) || name == names.end()) Refuse("one of " + JoinNames(names));
    choice = static_cast<Enum>(name - names.begin());
  }

  template <class Number>
  static std::string RangeText(Number low, Number high) {
    if constexpr (std::is_same_v<Number, std::uint64_t>) {
      if (high == ~std::uint64_t{0}) return "a whole number from 0";
    }
    const std::string kind = std::is_integral_v<Number> ? "a whole number" : "a number";
    return kind + " from " + FormatNumber(low) + " to " + FormatNumber(high);
  }

  bool Is(Kind kind) {
    found_ = true;
    return value_.kind == Kind::kFlag || value_.kind == kind;
  }
  [[noreturn]] void Refuse(const std::string& expected) const {
    throw std::runtime_error(key_ + ": '" + value_.text + "' is not " + expected);
  }

  std::string key_;
  WrittenValue value_;
  bool found_ = false;
  std::vector<std::string> keys_;
};

}  // namespace crsm
