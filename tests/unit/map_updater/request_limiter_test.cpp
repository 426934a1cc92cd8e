#include "services/map_updater/request_limiter.hpp"

#include "catch.hpp"
#include "services/map_updater/request_limiter.cpp"  // in no library: it is map_updater's own

using namespace crsm;
using namespace std::chrono_literals;

namespace {

Sender Port(std::uint16_t port) { return {0x0100007f, port}; }

/// How many of the requests of an asker that asks `per_second` times for `seconds` are admitted.
int CountAdmitted(RequestLimiter& limiter, const Sender& sender, int per_second, int seconds,
                  RequestLimiter::Clock::time_point start = {}) {
  int num = 0;
  for (int i = 0; i < per_second * seconds; ++i) num += limiter.Admit(sender, 7, start + i * 1s / per_second);
  return num;
}

}  // namespace

TEST_CASE("a replica that asks for one page after the other is answered each time") {
  RequestLimiter limiter;
  CHECK(CountAdmitted(limiter, Port(1), 400, 1) == 400);
  CHECK(CountAdmitted(limiter, Port(2), 200, 20) == 4000);
}

TEST_CASE("who asks 5,000 times a second is answered 200 times, whatever requester it says that it is") {
  RequestLimiter limiter;
  int num = 0;
  for (int i = 0; i < 50000; ++i) num += limiter.Admit(Port(1), i, RequestLimiter::Clock::time_point{} + i * 200us);
  CHECK(num >= 2390);
  CHECK(num <= 2410);
}

TEST_CASE("who asks too often takes nothing from another") {
  RequestLimiter limiter;
  for (int ms = 0; ms < 10000; ++ms) {
    const RequestLimiter::Clock::time_point now{std::chrono::milliseconds(ms)};
    for (int i = 0; i < 5; ++i) limiter.Admit(Port(1), 7, now);
    if (ms % 10 == 0) CHECK(limiter.Admit(Port(2), 7, now));
  }
}

TEST_CASE("askers together are limited: of a hundred, eight are answered, until they have been silent for a while") {
  RequestLimiter limiter;
  const RequestLimiter::Clock::time_point start{1h};
  int num = 0;
  for (std::uint16_t port = 1; port <= 100; ++port) num += limiter.Admit(Port(port), 7, start);
  CHECK(num == 8);
  CHECK_FALSE(limiter.Admit(Port(200), 7, start + 9s));
  CHECK(limiter.Admit(Port(200), 7, start + 11s));
}

TEST_CASE("where senders are not known, requesters are told apart") {
  RequestLimiter limiter;
  int num = 0;
  for (int i = 0; i < 1000; ++i) num += limiter.Admit({}, 1, {});
  CHECK(num == 400);
  CHECK(limiter.Admit({}, 2, {}));
}
