#include "common/scan/utime_unit.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kNow_us = 1'700'000'000'000'000;  // in 2023

std::string NameOfUnit(std::int64_t utime, double step) {
  const auto unit = FindWrongUnit(utime, step);
  return unit ? unit->name : "";
}

bool IsCertain(std::int64_t utime, double step) { return FindWrongUnit(utime, step).value().is_since_1970; }

}  // namespace

TEST_CASE("utimes since 1970 show their unit for certain, where a laser's pace agrees") {
  for (const double rate_hz : {1.0, 5.5, 10.0, 40.0, 100.0}) {
    CAPTURE(rate_hz);
    CHECK(NameOfUnit(kNow_us, 1e6 / rate_hz).empty());
    CHECK(NameOfUnit(kNow_us / 1'000'000, 1.0 / rate_hz) == "seconds");
    CHECK(NameOfUnit(kNow_us / 1'000, 1e3 / rate_hz) == "milliseconds");
    CHECK(NameOfUnit(kNow_us * 1'000, 1e9 / rate_hz) == "nanoseconds");
    CHECK(IsCertain(kNow_us / 1'000'000, 1.0 / rate_hz));
    CHECK(IsCertain(kNow_us / 1'000, 1e3 / rate_hz));
    CHECK(IsCertain(kNow_us * 1'000, 1e9 / rate_hz));
  }
  CHECK(NameOfUnit(kNow_us, 60e6).empty());  // microseconds, of a log with a scan a minute
}

TEST_CASE("utimes since a start show their unit by the pace of the scans, and not for certain") {
  for (const std::int64_t utime : {std::int64_t{0}, std::int64_t{123'456}, std::int64_t{2'000'000'000}}) {
    CAPTURE(utime);
    CHECK(NameOfUnit(utime, 100e3).empty());  // 10 Hz
    CHECK(NameOfUnit(utime, 2e3).empty());    // 500 Hz
    CHECK(NameOfUnit(utime, 3e6).empty());    // a sparse log
    CHECK(NameOfUnit(utime, 100.0) == "milliseconds");
    CHECK(NameOfUnit(utime, 100e6) == "nanoseconds");
    CHECK_FALSE(IsCertain(utime, 100.0));
    CHECK_FALSE(IsCertain(utime, 100e6));
  }
  CHECK(NameOfUnit(5, 1.0) == "seconds");  // or a count
}

TEST_CASE("of a clock that stands, goes back or makes no sense no unit is told") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double step : {0.0, -100.0, kNan, kInfinity, 1e-9, 1e18}) {
    CAPTURE(step);
    for (const std::int64_t utime : {std::int64_t{-5}, std::int64_t{0}, std::numeric_limits<std::int64_t>::min(),
                                     std::numeric_limits<std::int64_t>::max()}) {
      CHECK(NameOfUnit(utime, step).empty());
    }
  }
  CHECK(NameOfUnit(kNow_us / 1'000'000, 0.0).empty());
}

TEST_CASE("a time since 1970 becomes microseconds, and any other stays") {
  const UtimeUnit seconds = *FindWrongUnit(1'700'000'000, 0.1);
  const UtimeUnit milliseconds = *FindWrongUnit(1'700'000'000'123, 100.0);
  const UtimeUnit nanoseconds = *FindWrongUnit(1'700'000'000'123'456'789, 1e8);
  CHECK(ToMicroseconds(1'700'000'001, seconds) == 1'700'000'001'000'000);
  CHECK(ToMicroseconds(1'700'000'000'123, milliseconds) == 1'700'000'000'123'000);
  CHECK(ToMicroseconds(1'700'000'000'123'456'789, nanoseconds) == 1'700'000'000'123'456);
  for (const std::int64_t other : {std::int64_t{0}, std::int64_t{-1}, kNow_us, std::numeric_limits<std::int64_t>::min(),
                                   std::numeric_limits<std::int64_t>::max()}) {
    CHECK(ToMicroseconds(other, seconds) == other);
    CHECK(ToMicroseconds(other, milliseconds) == other);
    CHECK(ToMicroseconds(other, nanoseconds) == other);
  }
}

TEST_CASE("a time since another start becomes microseconds, unless it is too large for them") {
  const UtimeUnit milliseconds = *FindWrongUnit(5'000, 100.0);
  const UtimeUnit nanoseconds = *FindWrongUnit(5'000'000'000, 1e8);
  CHECK(ToMicroseconds(5'100, milliseconds) == 5'100'000);
  CHECK(ToMicroseconds(-1, milliseconds) == -1'000);
  CHECK(ToMicroseconds(5'000'000'123, nanoseconds) == 5'000'000);
  for (const std::int64_t huge : {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    CHECK(ToMicroseconds(huge, milliseconds) == huge);
  }
}

TEST_CASE("what is wrong with a unit is said in one line, with what it does and the mend") {
  const auto Describe = [](std::int64_t utime, double step) {
    return DescribeWrongUnit(*FindWrongUnit(utime, step), utime, step);
  };
  CHECK(Describe(1'700'000'000'123, 100.0) ==
        "utime is in milliseconds, as 1700000000123 shows: times are 1,000 times too small, and speeds are wrong: the "
        "driver must set utime in microseconds");
  CHECK(Describe(7, 1e8) ==
        "utime goes up by 1e+08 a scan, as if it were in nanoseconds: times are 1,000 times too large, and speeds are "
        "wrong: the driver must set utime in microseconds");
  CHECK(Describe(1'700'000'000, 0.1).find("times are 1,000,000 times too small") != std::string::npos);
}

}  // namespace crsm
