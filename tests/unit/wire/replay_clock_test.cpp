#include "services/wire/replay_clock.hpp"

#include "catch.hpp"
#include "scratch.hpp"
#include "services/wire/event_log_writer.hpp"
#include "services/wire/lcm_event_log.hpp"
#include "wire_messages.hpp"

using namespace crsm;

namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::int64_t kFiftyYears_us = 50LL * 365 * 86'400 * kSecond_us;

}  // namespace

TEST_CASE("what is recorded is played as it came, but for jumps of its clock: back is no time, far ahead a minute") {
  ReplayClock clock;
  const std::pair<std::int64_t, std::int64_t> times_s[]{{5, 5},      {6, 6},    {6, 6},    {56, 56},    {3656, 116},
                                                        {3657, 117}, {57, 117}, {58, 118}, {4000, 178}, {4001, 179}};
  for (const auto& [utime_s, played_s] : times_s) {
    CHECK(clock.Follow(utime_s * kSecond_us) == played_s * kSecond_us);
    CHECK(clock.now() == played_s * kSecond_us);
  }
  CHECK(ReplayClock().Follow(kFiftyYears_us) == kFiftyYears_us);
}

TEST_CASE("a log whose clock was set while it was recorded lasts as long as the recording") {
  const ScratchFile file("");
  {
    EventLogWriter log(file.path());
    for (const std::int64_t utime : {kSecond_us, 2 * kSecond_us, kFiftyYears_us, kFiftyYears_us + kSecond_us}) {
      log.Write("SCAN_REQUEST", scan_request_t{utime, 1});
    }
    log.Flush();
  }
  lcm::LogFile log(file.path(), "r");
  std::vector<std::int64_t> seconds;
  while (const lcm::LogEvent* event = log.readNextEvent()) seconds.push_back(event->timestamp / kSecond_us);
  CHECK(seconds == std::vector<std::int64_t>{1, 2, 62, 63});
}
