#include "services/base/line_limit.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace crsm {

std::optional<std::string> LineLimit::Pass(std::string line, Clock::time_point now) {
  left_ = std::min(kAtOnce, left_ + kPerSecond * std::chrono::duration<double>(now - last_).count());
  last_ = now;
  if (left_ < 1.0) {
    ++num_left_out_;
    return std::nullopt;
  }
  left_ -= 1.0;
  if (const auto num = std::exchange(num_left_out_, 0); num > 0) {
    line += fmt::format(" ({} such lines before it were left out)", num);
  }
  return line;
}

}  // namespace crsm
