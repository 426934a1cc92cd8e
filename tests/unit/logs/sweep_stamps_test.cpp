#include "common/logs/sweep_stamps.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

/// Of ten scans a second, each of which is recorded so long after its stamp, and so much later if its number is odd.
SweepStamps StampsOf(std::int64_t lag_us, std::int64_t jitter_us = 0, int num_scans = 20) {
  SweepStamps stamps;
  for (int i = 0; i < num_scans; ++i) {
    const std::int64_t stamp = 1'700'000'000'000'000 + 100'000 * i;
    stamps.Study(stamp, stamp + lag_us + i % 2 * jitter_us);
  }
  return stamps;
}

constexpr double kSweep_s = 0.1;

}  // namespace

TEST_CASE("stamps are of the first beam if scans are recorded a sweep later, whichever way round it goes") {
  for (const double sweep_s : {kSweep_s, -kSweep_s}) {
    CHECK(StampsOf(103'000).AreOfFirstBeam(sweep_s));
    CHECK(StampsOf(92'000, 30'000).AreOfFirstBeam(sweep_s));
    CHECK_FALSE(StampsOf(3'000).AreOfFirstBeam(sweep_s));
    CHECK_FALSE(StampsOf(0).AreOfFirstBeam(sweep_s));
    CHECK_FALSE(StampsOf(50'000, 60'000).AreOfFirstBeam(sweep_s));  // of the middle one, say
  }
}

TEST_CASE("the clock of another machine, few scans, and scans that take no time prove nothing of stamps") {
  CHECK_FALSE(StampsOf(200'000).AreOfFirstBeam(kSweep_s));
  CHECK_FALSE(StampsOf(-100'000).AreOfFirstBeam(kSweep_s));
  CHECK_FALSE(StampsOf(-1'700'000'000'000'000).AreOfFirstBeam(kSweep_s));
  CHECK_FALSE(StampsOf(103'000, 0, 9).AreOfFirstBeam(kSweep_s));
  CHECK(StampsOf(103'000, 0, 10).AreOfFirstBeam(kSweep_s));
  CHECK_FALSE(SweepStamps().AreOfFirstBeam(kSweep_s));
  CHECK_FALSE(StampsOf(0).AreOfFirstBeam(0.0));
}

}  // namespace crsm
