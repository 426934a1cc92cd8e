#include "common/scan/utime_unit.hpp"

#include <fmt/format.h>

#include <array>
#include <limits>

namespace crsm {
namespace {

constexpr std::int64_t kMicroseconds = 1'000'000;  // in a second
constexpr std::array<UtimeUnit, 3> kOthers{{{"seconds", 1}, {"milliseconds", 1'000}, {"nanoseconds", 1'000'000'000}}};

constexpr std::int64_t kEarliest_s = 1'000'000'000;  // 2001
constexpr std::int64_t kLatest_s = 4'000'000'000;    // 2096

bool IsSince1970(std::int64_t utime, std::int64_t num_per_second) {
  const std::int64_t seconds = utime / num_per_second;
  return seconds >= kEarliest_s && seconds < kLatest_s;
}

/// No clock counts microseconds beyond 2096, whatever the pace.
bool MayBeMicroseconds(std::int64_t utime, double step, const UtimeUnitConstants& constants) {
  if (IsSince1970(utime, kMicroseconds)) return true;
  return IsPaceOfLaser(step, constants) && utime < kLatest_s * kMicroseconds;
}

}  // namespace

bool IsPaceOfLaser(double step_us, const UtimeUnitConstants& constants) {
  const double step_s = step_us / static_cast<double>(kMicroseconds);
  return step_s >= constants.shortest_s && step_s <= constants.longest_s;
}

std::optional<UtimeUnit> FindWrongUnit(std::int64_t utime, double step, const UtimeUnitConstants& constants) {
  if (!(step > 0.0) || MayBeMicroseconds(utime, step, constants)) return std::nullopt;
  for (UtimeUnit unit : kOthers) {
    unit.is_since_1970 = IsSince1970(utime, unit.num_per_second);
    if (unit.is_since_1970 && step <= constants.longest_s * static_cast<double>(unit.num_per_second)) return unit;
  }
  for (const UtimeUnit& unit : kOthers) {
    const double in_unit_s = step / static_cast<double>(unit.num_per_second);
    if (in_unit_s >= constants.shortest_usual_s && in_unit_s < constants.longest_usual_s) return unit;
  }
  return std::nullopt;
}

std::int64_t ToMicroseconds(std::int64_t utime, const UtimeUnit& unit) {
  if (unit.is_since_1970 && !IsSince1970(utime, unit.num_per_second)) return utime;
  if (unit.num_per_second > kMicroseconds) return utime / (unit.num_per_second / kMicroseconds);
  const std::int64_t factor = kMicroseconds / unit.num_per_second;
  const std::int64_t largest = std::numeric_limits<std::int64_t>::max() / factor;
  return utime >= -largest && utime <= largest ? utime * factor : utime;
}

std::string DescribeFactor(const UtimeUnit& unit) {
  if (unit.num_per_second > kMicroseconds) return "1,000 times too large";
  return unit.num_per_second == 1 ? "1,000,000 times too small" : "1,000 times too small";
}

std::string DescribeWrongUnit(const UtimeUnit& unit, std::int64_t utime, double step) {
  const std::string why = unit.is_since_1970
                              ? fmt::format("utime is in {}, as {} shows", unit.name, utime)
                              : fmt::format("utime goes up by {:.4g} a scan, as if it were in {}", step, unit.name);
  return fmt::format("{}: times are {}, and speeds are wrong: the driver must set utime in microseconds", why,
                     DescribeFactor(unit));
}

}  // namespace crsm
