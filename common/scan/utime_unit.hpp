#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace crsm {

/// A unit in which a driver may count where microseconds are meant.
struct UtimeUnit {
  const char* name = "";            ///< "milliseconds"
  std::int64_t num_per_second = 0;  ///< 1 or more
  bool is_since_1970 = false;       ///< utimes are moments of 2001 to 2096 in it: no other unit can be meant
};

/// Which utimes show what their unit is.
struct UtimeUnitConstants {
  // Between two scans. Lasers give 1 to 100 scans a second, sparse logs one in some seconds.
  double shortest_s = 0.002;
  double longest_s = 20.0;
  // The same where nothing but the pace tells of the unit.
  double shortest_usual_s = 0.005;
  double longest_usual_s = 5.0;
};

/// Whether a laser may give a scan every so many microseconds.
bool IsPaceOfLaser(double step_us, const UtimeUnitConstants& constants = {});

/// The unit of a laser's utimes where it is not microseconds; nothing where it may be, or where none fits.
///
/// utime: of one of its scans. step: from one scan to the next, the mean of many, in the same unit.
std::optional<UtimeUnit> FindWrongUnit(std::int64_t utime, double step, const UtimeUnitConstants& constants = {});

/// A utime in microseconds. One that cannot be in the unit stays as it is: where the unit was found from moments of
/// 2001 to 2096 any other, and what is too large for microseconds.
std::int64_t ToMicroseconds(std::int64_t utime, const UtimeUnit& unit);

/// What utimes in a unit are as microseconds: "1,000 times too small".
std::string DescribeFactor(const UtimeUnit& unit);

/// What is wrong with utimes in a unit that FindWrongUnit has found, for people: "utime is in milliseconds, ...".
std::string DescribeWrongUnit(const UtimeUnit& unit, std::int64_t utime, double step);

}  // namespace crsm
