#include "common/metrics/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "common/logs/gzip_file.hpp"
#include "common/math/parse_number.hpp"

namespace crsm {

namespace {

constexpr double kMaxNumber = 4.5e9;  // seconds: at 2^52 us a double still tells microseconds apart
constexpr std::string_view kBlanks = " \t\r";

/// True if the text is exactly eight numbers in range.
bool ParseNumbers(std::string_view text, std::array<double, 8>& numbers) {
  for (double& number : numbers) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
    const auto read = ParseNumber<double>(word);
    if (!read || !(std::abs(*read) <= kMaxNumber)) return false;  // NaN too
    number = *read;
    text.remove_prefix(word.size());
  }
  return text.find_first_not_of(kBlanks) == std::string_view::npos;
}

}  // namespace

std::vector<NumberRow> ReadNumberRows(const std::string& path, const char* columns) {
  GzipFile file(path);
  std::vector<NumberRow> rows;
  std::int64_t line_number = 0;
  while (const auto line = file.ReadLine()) {
    if (file.truncated()) break;
    ++line_number;
    const std::size_t first = line->text.find_first_not_of(kBlanks);
    const bool blank = first == std::string_view::npos || line->text[first] == '#';
    if (blank && !line->too_long) continue;
    NumberRow row{line_number, {}};
    if (!ParseNumbers(line->text, row.numbers)) {
      throw std::runtime_error(
          fmt::format("{}:{}: must be the eight numbers {}, each within +-4.5e9", path, line_number, columns));
    }
    rows.push_back(row);
  }
  if (file.truncated()) throw std::runtime_error(fmt::format("{}: the compressed file is cut short or damaged", path));
  return rows;
}

std::int64_t ToUtime(double t_s) { return std::llround(t_s * 1e6); }

Trajectory ReadTrajectory(const std::string& path) {
  Trajectory trajectory;
  for (const auto& [line, numbers] : ReadNumberRows(path, "t x y z qx qy qz qw")) {
    const auto& [t_s, x_m, y_m, z_m, qx, qy, qz, qw] = numbers;
    const double norm = std::sqrt(qx * qx + qy * qy + qz * qz + qw * qw);
    if (!(std::abs(norm - 1.0) <= 1e-3)) {  // files with four decimals are common
      throw std::runtime_error(fmt::format("{}:{}: the quaternion's length is {:.6g}, must be 1", path, line, norm));
    }
    const double yaw_rad = std::atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz);
    trajectory.push_back({ToUtime(t_s), {x_m, y_m, yaw_rad}});
  }
  return trajectory;
}

}  // namespace crsm
