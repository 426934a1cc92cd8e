#include "services/replica/request_limiter.hpp"

#include "catch.hpp"

using namespace crsm;
using namespace std::chrono_literals;

namespace {

Sender Port(std::uint16_t port) { return {0x0100007f, port}; }

constexpr std::uint16_t kMatcher = 999;

/// How many of the requests of an asker that asks `per_second` times for `seconds` are admitted.
int CountAdmitted(RequestLimiter& limiter, const Sender& sender, int per_second, int seconds,
                  RequestLimiter::Clock::time_point start = {}) {
  int num = 0;
  for (int i = 0; i < per_second * seconds; ++i) num += limiter.Admit(sender, 7, start + i * 1s / per_second);
  return num;
}

RequestLimiter MakeLimiter() {
  return RequestLimiter([](const Sender& sender) { return sender == Port(kMatcher); });
}

}  // namespace

TEST_CASE("a replica that asks for one page after the other is answered each time") {
  RequestLimiter limiter = MakeLimiter();
  CHECK(CountAdmitted(limiter, Port(1), 400, 1) == 400);
  CHECK(CountAdmitted(limiter, Port(2), 200, 20) == 4000);
}

TEST_CASE("who asks 5,000 times a second is answered 200 times, whatever requester it says that it is") {
  RequestLimiter limiter = MakeLimiter();
  int num = 0;
  for (int i = 0; i < 50000; ++i) num += limiter.Admit(Port(1), i, RequestLimiter::Clock::time_point{} + i * 200us);
  CHECK(num >= 2390);
  CHECK(num <= 2410);
}

TEST_CASE("who asks too often takes nothing from another") {
  RequestLimiter limiter = MakeLimiter();
  for (int ms = 0; ms < 10000; ++ms) {
    const RequestLimiter::Clock::time_point now{std::chrono::milliseconds(ms)};
    for (int i = 0; i < 5; ++i) limiter.Admit(Port(1), 7, now);
    if (ms % 10 == 0) CHECK(limiter.Admit(Port(2), 7, now));
  }
}

TEST_CASE("64 askers have equal parts of what eight may have; more wait until some have been silent for a while") {
  RequestLimiter limiter = MakeLimiter();
  const RequestLimiter::Clock::time_point start{1h};
  int num = 0;
  for (std::uint16_t port = 1; port <= 100; ++port) num += limiter.Admit(Port(port), 7, start);
  CHECK(num == 64);
  for (const std::uint16_t port : {std::uint16_t{1}, std::uint16_t{64}}) {
    const int answers = CountAdmitted(limiter, Port(port), 400, 4, start);  // the clock moves on three times
    CHECK(answers >= 49 + 3 * 25);
    CHECK(answers <= 50 + 3 * 25);
  }
  CHECK_FALSE(limiter.Admit(Port(200), 7, start + 9s));
  CHECK(limiter.Admit(Port(200), 7, start + 13s));
}

TEST_CASE("what mapping waits for is answered as ever, however many ask, and as soon as it is known") {
  RequestLimiter limiter = MakeLimiter();
  const RequestLimiter::Clock::time_point start{1h};
  for (std::uint16_t port = 1; port <= 100; ++port) limiter.Admit(Port(port), 7, start);
  CHECK(CountAdmitted(limiter, Port(kMatcher), 400, 4, start + 1s) == 1000);

  bool known = false;
  RequestLimiter late([&](const Sender&) { return known; });
  for (std::uint16_t port = 1; port <= 64; ++port) late.Admit(Port(port), 7, start);
  known = true;
  CHECK(CountAdmitted(late, Port(64), 400, 4, start + 2s) == 1000);
}

TEST_CASE("where senders are not known, requesters are told apart") {
  RequestLimiter limiter = MakeLimiter();
  int num = 0;
  for (int i = 0; i < 1000; ++i) num += limiter.Admit({}, 1, {});
  CHECK(num == 400);
  CHECK(limiter.Admit({}, 2, {}));
}
