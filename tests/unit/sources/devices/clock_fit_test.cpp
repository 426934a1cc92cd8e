#include "services/sources/devices/clock_fit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "services/sources/devices/wrapping_clock.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kStart_us = 1'700'000'000'000'000;
constexpr std::int64_t kPeriod_us = 25'000;

/// How far the fitted times of scans are from the true ones [us]: those from the `first` on. The laser's clock is fast
/// by `drift`, arrivals are 1 ms late at least, and later by what `delay_us` says of each scan.
template <class Delay>
std::vector<double> FindErrors(int num_scans, int first, double drift, Delay delay_us) {
  ClockFit clock(1e-3);
  std::vector<double> errors_us;
  std::int64_t last_utime = 0;
  for (int i = 0; i < num_scans; ++i) {
    const std::int64_t true_us = i * kPeriod_us;
    const auto device_us = std::llround(static_cast<double>(true_us) * (1.0 + drift));
    const std::int64_t utime = clock.Fit(device_us, kStart_us + true_us + 1000 + delay_us(i));
    CHECK(utime > last_utime);
    last_utime = utime;
    if (i >= first) errors_us.push_back(static_cast<double>(utime - kStart_us - true_us - 1000));
  }
  return errors_us;
}

double Largest(const std::vector<double>& errors) {
  double largest = 0.0;
  for (const double error : errors) largest = std::max(largest, std::abs(error));
  return largest;
}

}  // namespace

TEST_CASE("a clock that agrees with the host's is stamped by the least delay") {
  CHECK(Largest(FindErrors(400, 0, 0.0, [](int) { return 0; })) < 1.0);
}

TEST_CASE("delays of every scan but a few are fitted away, with a clock that is 200 ppm fast or slow") {
  for (const double drift : {-2e-4, 0.0, 2e-4}) {
    Random random(1);
    // One scan in ten comes without delay, the others up to 20 ms late: from one of the former to the next a clock of
    // 1000 ppm, the worst that is allowed for, runs off by 0.25 ms.
    const auto Delay = [&](int i) { return i % 10 == 0 ? 0 : std::llround(random.Uniform(0.0, 20'000.0)); };
    CHECK(Largest(FindErrors(1000, 300, drift, Delay)) < 250.0);
  }
}

TEST_CASE("half a second in which the host does nothing moves no scan") {
  // What was measured meanwhile comes all at once at its end.
  const auto Delay = [](int i) { return i >= 500 && i < 520 ? (520 - i) * kPeriod_us : 0; };
  CHECK(Largest(FindErrors(1000, 300, 1e-4, Delay)) < 250.0);
}

TEST_CASE("times rise where the first scan came late, and where the laser's clock begins anew") {
  ClockFit clock(1e-3);
  const std::int64_t late = clock.Fit(0, kStart_us + 300'000);
  const std::int64_t second = clock.Fit(kPeriod_us, kStart_us + kPeriod_us);
  CHECK(late == kStart_us + 300'000);
  CHECK(second == late + kPeriod_us / 2);
  const std::int64_t reset = clock.Fit(7, kStart_us + 2'000'000);
  CHECK(reset == kStart_us + 2'000'000);
  clock.Restart();
  CHECK(clock.Fit(100'000'000, kStart_us + 2'500'000) == kStart_us + 2'500'000);
}

TEST_CASE("a stamp that is two hours wrong moves no scan by more than a period, neither its own nor those behind it") {
  for (const std::int64_t wrong_us : {std::int64_t{7'200'000'000}, std::int64_t{-7'200'000'000}}) {
    ClockFit clock(1e-3);
    for (int i = 0; i < 600; ++i) {
      const std::int64_t true_us = 10'000'000'000 + i * kPeriod_us;
      const std::int64_t utime = clock.Fit(true_us + (i == 300 ? wrong_us : 0), kStart_us + true_us + 1000);
      CHECK(std::abs(utime - kStart_us - true_us - 1000) < kPeriod_us);
    }
  }
}

TEST_CASE("a counter of few bits goes on over its end, and one that goes back was started anew") {
  WrappingClock clock(std::int64_t{1} << 24);
  CHECK(clock.Read((1 << 24) - 25).total == 0);
  CHECK(clock.Read((1 << 24) - 1).total == 24);
  const auto wrapped = clock.Read(24);
  CHECK(wrapped.total == 49);
  CHECK_FALSE(wrapped.restarted);
  CHECK(clock.Read(3).restarted);
  const auto next = clock.Read(28);
  CHECK(next.total == 49 + 25);
  CHECK_FALSE(next.restarted);
}

}  // namespace crsm
