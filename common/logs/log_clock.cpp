#include "common/logs/log_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/scan/same_scan.hpp"

namespace crsm {

void LogClock::Readings::Add(std::int64_t utime) {
  if (first) {
    ++num_steps;
    num_standing += utime == last ? 1 : 0;
  } else {
    first = utime;
  }
  last = utime;
}

double LogClock::Readings::MeanStep() const {
  if (num_steps == 0) return 0.0;
  return (static_cast<double>(last) - static_cast<double>(*first)) / num_steps;
}

void LogClock::Study(const LaserScan& scan, std::optional<std::int64_t> recorded_utime) {
  if (HasStudiedEnough() || (last_studied_ && IsSameScan(*last_studied_, scan))) return;
  ++num_studied_;
  stamps_.Add(scan.utime);
  if (recorded_utime) recorded_.Add(*recorded_utime);
  last_studied_ = scan;
}

bool LogClock::StampsStand() const {
  return stamps_.num_standing >= constants_.enough_standing &&
         stamps_.num_standing > constants_.standing_share * stamps_.num_steps;
}

bool LogClock::RecorderIsBelieved() const {
  return recorded_.num_steps == stamps_.num_steps && IsPaceOfLaser(recorded_.MeanStep()) &&
         recorded_.num_standing <= constants_.recorded_standing * recorded_.num_steps;
}

/// Whether stamps in a unit go on as the clock of the recorder does.
bool LogClock::IsPaceOfRecorder(const UtimeUnit& unit) const {
  if (!RecorderIsBelieved()) return false;
  const double step_us = 1e6 * stamps_.MeanStep() / static_cast<double>(unit.num_per_second);
  return std::abs(step_us - recorded_.MeanStep()) <= constants_.pace_difference * recorded_.MeanStep();
}

/// Only where it is certain.
std::optional<UtimeUnit> LogClock::OtherUnit() const {
  if (stamps_.num_steps < constants_.enough_standing) return std::nullopt;
  const auto unit = FindWrongUnit(stamps_.last, stamps_.MeanStep());
  return unit && (unit->is_since_1970 || IsPaceOfRecorder(*unit)) ? unit : std::nullopt;
}

LogClock::Time LogClock::WhichTime() const {
  const auto unit = OtherUnit();
  const bool is_coarse = StampsStand() || (unit && unit->num_per_second == 1);
  if (is_coarse && RecorderIsBelieved()) return Time::kRecorded;
  if (StampsStand()) return Time::kNumber;
  return unit ? Time::kStampInOtherUnit : Time::kStamp;
}

std::optional<std::int64_t> LogClock::TimeOf(const LaserScan& scan, std::optional<std::int64_t> recorded_utime) {
  const Time which = WhichTime();
  if (which == Time::kStamp) return scan.utime;
  if (which == Time::kStampInOtherUnit) return ToMicroseconds(scan.utime);
  if (last_ && IsSameScan(*last_, scan)) return std::nullopt;
  last_ = scan;
  if (which == Time::kRecorded) return recorded_utime.value_or(-1) < 0 ? std::nullopt : recorded_utime;
  constexpr std::int64_t kLatestStart = 9'000'000'000'000'000'000;
  return std::min(*stamps_.first, kLatestStart) + num_numbered_++ * constants_.period_us;
}

std::int64_t LogClock::ToMicroseconds(std::int64_t stamp) const {
  const auto unit = OtherUnit();
  return unit ? crsm::ToMicroseconds(stamp, *unit) : stamp;
}

std::string LogClock::Complaint(const std::string& stamp) const {
  const auto unit = OtherUnit();
  const std::string why = unit ? fmt::format("{} is in {}", stamp, unit->name)
                               : fmt::format("{} of the first {} scans have the {} of the scan before",
                                             stamps_.num_standing, num_studied_, stamp);
  switch (WhichTime()) {
    case Time::kStamp:
      return "";
    case Time::kStampInOtherUnit:
      return why + ": it is corrected";
    case Time::kRecorded:
      return why + ": the times at which the scans were recorded are used instead";
    case Time::kNumber:
      return fmt::format(
          "{}: the scans are numbered instead, as if one came every {:.3g} s: times and speeds are not the true ones",
          why, 1e-6 * static_cast<double>(constants_.period_us));
  }
  return "";
}

}  // namespace crsm
