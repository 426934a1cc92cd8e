#include "services/base/backoff.hpp"

#include "catch.hpp"

using namespace crsm;
using namespace std::chrono_literals;

namespace {

const Backoff::Clock::time_point kStart{1h};

/// After how many milliseconds it was due, looked at once a millisecond.
std::vector<int> DueTimes(Backoff& backoff, int until_ms) {
  std::vector<int> times;
  for (int ms = 0; ms <= until_ms; ++ms) {
    if (backoff.Due(kStart + std::chrono::milliseconds(ms))) times.push_back(ms);
  }
  return times;
}

}  // namespace

TEST_CASE("what is not answered is sent again after pauses that double up to the longest") {
  Backoff backoff(50ms, 300ms);
  backoff.Restart(kStart);
  CHECK(DueTimes(backoff, 1300) == std::vector<int>{50, 150, 350, 650, 950, 1250});
}

TEST_CASE("something new is sent at once, and its pauses are short again") {
  Backoff backoff(50ms, 10s);
  CHECK(DueTimes(backoff, 1000) == std::vector<int>{0, 50, 150, 350, 750});
  backoff.RestartAtOnce();
  CHECK(DueTimes(backoff, 200) == std::vector<int>{0, 50, 150});
}

TEST_CASE("a first pause beyond the longest stays as it is") {
  Backoff backoff(400ms, 100ms);
  backoff.Restart(kStart);
  CHECK(DueTimes(backoff, 1300) == std::vector<int>{400, 800, 1200});
}
