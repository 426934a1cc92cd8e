#include "common/logs/unique_utimes.hpp"

#include <limits>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

}  // namespace

TEST_CASE("within a drive each utime is its own, and is taken once, whatever steps back by accident") {
  UniqueUtimes utimes;
  CHECK(utimes.Add(9 * kSecond_us) == 9 * kSecond_us);
  CHECK(utimes.Add(kSecond_us) == kSecond_us);  // back by 8 s
  CHECK_FALSE(utimes.Add(kSecond_us));
  CHECK_FALSE(utimes.Add(9 * kSecond_us));
  CHECK(utimes.size() == 2);
}

TEST_CASE("a scan of a later drive gets the next free microsecond, and is taken once") {
  UniqueUtimes utimes;
  for (const std::int64_t utime : {5, 6, 8}) CHECK(utimes.Add(utime) == utime);
  utimes.BeginDrive();
  CHECK(utimes.Add(5) == 7);
  CHECK_FALSE(utimes.Add(5));
  CHECK_FALSE(utimes.Add(7));
  CHECK(utimes.Add(8) == 9);
  CHECK(utimes.Add(4) == 4);
  utimes.BeginDrive();
  CHECK(utimes.Add(4) == 10);
  CHECK(utimes.size() == 7);
}

TEST_CASE("a clock that steps back by more than 8 s begins a drive") {
  UniqueUtimes utimes;
  utimes.Add(0);
  utimes.Add(9 * kSecond_us);
  CHECK(utimes.Add(0) == 1);
}

TEST_CASE("where very many utimes in a row are taken, and at the largest one, a scan gets none") {
  constexpr std::int64_t kLargest = std::numeric_limits<std::int64_t>::max();
  UniqueUtimes utimes;
  for (std::int64_t utime = 0; utime < 2000; ++utime) utimes.Add(utime);
  utimes.Add(kLargest);
  utimes.BeginDrive();
  CHECK_FALSE(utimes.Add(10));
  CHECK(utimes.Add(1999) == 2000);
  CHECK_FALSE(utimes.Add(kLargest));
}

}  // namespace crsm
