#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// The text of a made-up campus as ParseWorld reads it, each time the same: 30 halls on an uneven grid of 200 m by
/// 140 m, joined by bare corridors of 20 m to 48 m with niches and doors, and a drive of at least `length_m` from hall
/// to hall, mostly to where it has been least. The laser is a SICK LMS of 30 m at five scans a second and 1 m/s.
///
/// Each `number` is another campus.
std::string DrawCampus(double length_m, std::uint64_t number);

}  // namespace crsm
