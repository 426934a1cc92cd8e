#include "common/results/run_origin.hpp"

#include <array>
#include <ctime>

namespace crsm {

std::string JoinOrigins(const std::string& earlier, const std::string& now) {
  constexpr std::size_t kLongest = 400;  // a caption has room for as many letters
  constexpr const char* kThen = "; then ";
  if (earlier.empty()) return now;
  if (earlier == now || earlier.ends_with(kThen + now)) return earlier;  // more of one log
  std::string joined = earlier + kThen + now;
  if (joined.size() > kLongest) joined = "..." + joined.substr(joined.size() - kLongest);
  return joined;
}

std::string FormatUtc(std::int64_t utime) {
  constexpr std::int64_t k1990_s = 631'152'000;
  constexpr std::int64_t k10000_s = 253'402'300'800;
  const auto time_s = static_cast<std::time_t>(utime / 1'000'000);
  std::tm utc{};
  if (time_s < k1990_s || time_s >= k10000_s || !gmtime_r(&time_s, &utc)) return "";
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc)};
}

}  // namespace crsm
