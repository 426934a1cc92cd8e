#include "services/settings/settings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "common/math/parse_number.hpp"
#include "services/base/usage_error.hpp"
#include "services/wire/channels.hpp"

namespace crsm {

double ParseRate(const std::string& text) {
  constexpr double kAsFastAsMapped = 0.0;
  constexpr double kFastest = 1e6;
  if (text == "max") return kAsFastAsMapped;
  const auto rate = ParseNumber<double>(text);
  if (!rate || !(*rate > 0.0 && *rate <= kFastest)) {
    throw UsageError(fmt::format("--rate: '{}' is neither max nor a number above 0", text));
  }
  return *rate;
}

void CheckPrefix(const std::string& channel_prefix) {
  const std::size_t longest = kLongestChannel - ServiceStatusChannel("laser_publisher").size();
  if (channel_prefix.size() <= longest) return;
  throw UsageError(
      fmt::format("--channel-prefix {}: has {} characters, must have at most {}: the channels with it must "
                  "fit into the {} characters of LCM's",
                  channel_prefix, channel_prefix.size(), longest, kLongestChannel));
}

std::optional<Pose2> ParseStart(const std::string& text) {
  constexpr double kFarthest = 1e6;
  if (text.empty()) return std::nullopt;
  std::vector<double> numbers;
  std::stringstream parts(text + ",");
  for (std::string part; std::getline(parts, part, ',');) {
    const auto number = ParseNumber<double>(part);
    if (number && std::abs(*number) <= kFarthest) numbers.push_back(*number);  // false for NaN
  }
  if (numbers.size() != 3 || std::count(text.begin(), text.end(), ',') != 2) {
    throw UsageError(fmt::format("--start: '{}' is not X,Y,YAW [m, m, rad], as in 3.5,-2,1.57", text));
  }
  return Pose2{numbers[0], numbers[1], WrapAngle(numbers[2])};
}

}  // namespace crsm
