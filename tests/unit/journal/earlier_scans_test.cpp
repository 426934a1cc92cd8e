#include "services/journal/earlier_scans.hpp"

#include "journal/journal_folder.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

/// What a robot sees that drives along a room, `from_m` ahead of its start.
ValidRays See(double from_m, std::int64_t second) {
  return RaysOf(ScanRoom({from_m + 0.05 * static_cast<double>(second), 0.0, 0.0}, second, 60)).rays;
}

/// A drive of 20 s that begins at `begin_us`, of whose scans every third one was drawn.
void AddDrive(double from_m, std::int64_t begin_us, EarlierScans& map) {
  for (std::int64_t second = 0; second < 20; ++second) {
    const CriticalRays scan{begin_us + second * kSecond_us, See(from_m, second), {}};
    ScanMatch match = Match(scan.utime);
    match.utime = scan.utime;
    map.Add(second % 3 == 0 ? &scan : nullptr, match);
  }
}

/// How many scans of such a drive, whose clock begins at 0, the map has.
int CountKnown(double from_m, EarlierScans& map, float error_m = 0.0f) {
  map.BeginLog();
  int num_known = 0;
  for (std::int64_t second = 0; second < 20; ++second) {
    ValidRays rays = See(from_m, second);
    for (float& range_m : rays.range_m) range_m += error_m;
    num_known += map.Has(second * kSecond_us, rays) ? 1 : 0;
  }
  return num_known;
}

}  // namespace

TEST_CASE("the scans of a log that is in the map are known, also where another program has rounded them") {
  EarlierScans map;
  AddDrive(0.0, 0, map);
  CHECK(CountKnown(0.0, map) == 20);
  CHECK(map.num_same() == 7);
  CHECK(CountKnown(0.0, map, 0.005f) == 20);
  CHECK_FALSE(map.is_another_drive());
  CHECK(map.newest_utime() == 19 * kSecond_us);
}

TEST_CASE(
    "a log with other scans at the times of the map is another drive, and known as soon as it is in the map too") {
  EarlierScans map;
  CHECK(CountKnown(0.0, map) == 0);
  AddDrive(0.0, 0, map);
  CHECK(CountKnown(0.7, map) == 0);
  CHECK(map.is_another_drive());
  AddDrive(0.7, 1, map);  // as it was mapped: a microsecond later
  CHECK(CountKnown(0.7, map) == 20);
  CHECK(map.is_another_drive());
  CHECK(CountKnown(0.0, map) == 20);
  CHECK_FALSE(map.is_another_drive());
  CHECK(CountKnown(1.4, map) == 0);
}

TEST_CASE("scans that were not drawn are known by their times alone") {
  EarlierScans map;
  map.Add(nullptr, Match(5));
  CHECK(map.Has(5, See(0.0, 0)));
  CHECK_FALSE(map.Has(6, See(0.0, 0)));
  CHECK_FALSE(map.is_another_drive());
}

}  // namespace crsm
