#include "services/base/viewer_token.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

constexpr std::size_t kNumDigits = 32;

}  // namespace

std::string DrawViewerToken() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", device(), device(), device(), device());
}

bool IsViewerToken(std::string_view text) {
  return text.size() == kNumDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::optional<std::string> ReadViewerToken() {
  const char* text = std::getenv(kViewerTokenVariable);
  if (!text || !*text) return std::nullopt;
  if (!IsViewerToken(text)) {
    throw UsageError(
        fmt::format("{}: is not a token of {} hexadecimal digits in lower case", kViewerTokenVariable, kNumDigits));
  }
  return text;
}

}  // namespace crsm
