#include "common/logs/log_clock.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kNow_us = 1'700'000'000'000'000;  // in 2023
constexpr int kNumScans = 120;

using Clock = std::function<std::int64_t(int number)>;
using Utimes = std::vector<std::int64_t>;

/// Each scan is another one.
LaserScan ScanAt(std::int64_t utime, int number) {
  return {utime, 0.0f, 0.1f, {1.0f + 0.001f * static_cast<float>(number), 2.0f}};
}

struct Result {
  Utimes utimes;
  int num_repeated = 0;
  std::string complaint;
};

Result Read(const std::vector<LaserScan>& scans, const Clock& recorder) {
  LogClock clock;
  const auto RecordedAt = [&](std::size_t i) {
    return recorder ? std::optional(recorder(static_cast<int>(i))) : std::nullopt;
  };
  for (std::size_t i = 0; i < scans.size() && !clock.HasStudiedEnough(); ++i) clock.Study(scans[i], RecordedAt(i));
  Result result;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto utime = clock.TimeOf(scans[i], RecordedAt(i));
    if (utime) result.utimes.push_back(*utime);
    if (!utime) ++result.num_repeated;
  }
  result.complaint = clock.Complaint("utime");
  return result;
}

Result Read(const Clock& stamps, const Clock& recorder = nullptr) {
  std::vector<LaserScan> scans;
  for (int i = 0; i < kNumScans; ++i) scans.push_back(ScanAt(stamps(i), i));
  return Read(scans, recorder);
}

Utimes UtimesOf(const Clock& clock) {
  Utimes utimes;
  for (int i = 0; i < kNumScans; ++i) utimes.push_back(clock(i));
  return utimes;
}

const Clock kRecorder = [](int i) { return kNow_us + 77 + i * std::int64_t{200'000}; };

}  // namespace

TEST_CASE("stamps that tell scans apart stay as they are, and nothing is said") {
  const std::vector<std::pair<const char*, Clock>> right{
      {"10 Hz", [](int i) { return kNow_us + i * 100'000; }},
      {"since a start", [](int i) { return i * 100'000; }},
      {"that step back now and then", [](int i) { return kNow_us + i * 100'000 - (i % 20 == 0 ? 900'000 : 0); }},
      {"that begin anew", [](int i) { return i % 60 * 200'000; }},
      {"a scan in three seconds", [](int i) { return i * 3'000'000; }},
      {"of two lasers that measure together", [](int i) { return kNow_us + i / 2 * 100'000; }},
      {"that stand for a second", [](int i) { return std::max(i, 10) * 100'000; }},
      {"milliseconds or not: no epoch tells", [](int i) { return i * 100; }}};
  for (const auto& [name, stamps] : right) {
    CAPTURE(name);
    for (const Clock& recorder : {Clock(), kRecorder}) {
      const Result result = Read(stamps, recorder);
      CHECK(result.utimes == UtimesOf(stamps));
      CHECK(result.complaint.empty());
    }
  }
}

TEST_CASE(
    "scans whose stamps are all alike, or rounded to many seconds, are numbered by seconds from the first stamp") {
  const std::vector<std::pair<Clock, std::string>> rounded{
      {[](int) { return 0; }, "49 of the first 50 scans have the utime of the scan before"},
      {[](int) { return 1'134'860'000'000'000; }, "49 of the first 50 scans"},
      {[](int i) { return i < 40 ? 1'134'860'000'000'000 : 1'134'870'000'000'000; }, "48 of the first 50 scans"},
      {[](int i) { return i / 10 * 1'000'000; }, "45 of the first 50 scans"},
      {[](int i) { return i / 3 * 100'000; }, "33 of the first 50 scans"}};
  for (const auto& [stamps, expected] : rounded) {
    CAPTURE(expected);
    const Result result = Read(stamps);
    CHECK(result.utimes == UtimesOf([&](int i) { return stamps(0) + i * std::int64_t{1'000'000}; }));
    CHECK(result.complaint.starts_with(expected));
    CHECK(result.complaint.ends_with(
        "the scans are numbered instead, as if one came every 1 s: times and speeds are not the true ones"));
  }
}

TEST_CASE("where the recorder has times, scans that share stamps get those") {
  for (const Clock& stamps : {Clock([](int) { return 0; }), Clock([](int i) { return i / 5; })}) {
    const Result result = Read(stamps, kRecorder);
    CHECK(result.utimes == UtimesOf(kRecorder));
    CHECK(result.complaint.ends_with("the times at which the scans were recorded are used instead"));
  }
  // A recorder whose own clock stands, or counts events, is of no use.
  for (const Clock& recorder : {Clock([](int) { return kNow_us; }), Clock([](int i) { return i; }),
                                Clock([](int i) { return kNow_us + i / 4 * 400'000; })}) {
    CHECK(Read([](int) { return 0; }, recorder).utimes == UtimesOf([](int i) { return i * 1'000'000; }));
  }
}

TEST_CASE("times since 1970 in milliseconds or nanoseconds become microseconds, and seconds the recorder's times") {
  const Clock right = [](int i) { return kNow_us + i * 100'000; };
  const Result milliseconds = Read([&](int i) { return right(i) / 1'000; }, kRecorder);
  CHECK(milliseconds.utimes == UtimesOf(right));
  CHECK(milliseconds.complaint == "utime is in milliseconds: it is corrected");
  const Result nanoseconds = Read([&](int i) { return right(i) * 1'000; });
  CHECK(nanoseconds.utimes == UtimesOf(right));
  CHECK(nanoseconds.complaint == "utime is in nanoseconds: it is corrected");
  const Clock seconds = [&](int i) { return right(i) / 1'000'000; };
  CHECK(Read(seconds, kRecorder).utimes == UtimesOf(kRecorder));
  CHECK(Read(seconds, kRecorder).complaint.starts_with("utime is in seconds: the times at which"));
  CHECK(Read([](int i) { return 1'700'000'000 + 2 * i; }).utimes ==
        UtimesOf([](int i) { return kNow_us + i * 2'000'000; }));
  LogClock clock;
  for (int i = 0; i < 20; ++i) clock.Study(ScanAt(right(i) / 1'000, i));
  CHECK(clock.ToMicroseconds(right(5) / 1'000 + 7) == right(5) + 7'000);
  CHECK(clock.ToMicroseconds(123) == 123);
}

TEST_CASE("milliseconds or nanoseconds since any start become microseconds where the recorder's clock shows the pace") {
  const Clock right = [](int i) { return 70'000'000 + i * std::int64_t{200'000}; };  // a minute after the start
  const Clock milliseconds = [&](int i) { return right(i) / 1'000; };
  const Clock nanoseconds = [&](int i) { return right(i) * 1'000; };
  for (const auto& [stamps, name] : {std::pair(milliseconds, "milliseconds"), {nanoseconds, "nanoseconds"}}) {
    const Result result = Read(stamps, kRecorder);
    CHECK(result.utimes == UtimesOf(right));
    CHECK(result.complaint == fmt::format("utime is in {}: it is corrected", name));
    for (const double pace : {0.5, 2.0}) {  // of a log that was played at another pace
      const Clock other = [&](int i) { return kNow_us + std::llround(pace * 200'000.0 * i); };
      CHECK(Read(stamps, other).utimes == UtimesOf(stamps));
    }
    CHECK(Read(stamps, stamps).utimes == UtimesOf(stamps));  // written from the stamps
    CHECK(Read(stamps).complaint.empty());
  }
}

TEST_CASE("a scan that is sent again is no other one: it decides nothing, and gets no time") {
  std::vector<LaserScan> scans;
  for (int i = 0; i < 60; ++i) scans.insert(scans.end(), 3, ScanAt(100'000 * i, i));  // of a log recorded in lockstep
  CHECK(Read(scans, nullptr).complaint.empty());
  CHECK(Read(scans, nullptr).utimes.size() == 180);  // UniqueUtimes tells them
  for (LaserScan& scan : scans) scan.utime = 0;
  const Result result = Read(scans, nullptr);
  CHECK(result.utimes.size() == 60);
  CHECK(result.num_repeated == 120);
  CHECK(Read(std::vector<LaserScan>(60, ScanAt(0, 0)), nullptr).complaint.empty());
}

TEST_CASE("a scan whose recorder lost its time gets none") {
  const Result result = Read([](int) { return 0; }, [](int i) { return i == 70 ? -5 : kRecorder(i); });
  CHECK(result.utimes.size() == kNumScans - 1);
  CHECK(result.num_repeated == 1);
}

TEST_CASE("few scans show nothing, none nothing either, and no stamp is too large") {
  CHECK(Read(std::vector<LaserScan>{}, nullptr).complaint.empty());
  std::vector<LaserScan> scans;
  for (int i = 0; i < 10; ++i) scans.push_back(ScanAt(7, i));
  CHECK(Read(scans, nullptr).complaint.empty());
  scans.push_back(ScanAt(7, 10));
  CHECK(Read(scans, nullptr).complaint.starts_with("10 of the first 11 scans"));
  for (const std::int64_t utime :
       {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}}) {
    const Result result = Read([&](int) { return utime; });
    CHECK(result.utimes.size() == kNumScans);
    CHECK(result.utimes[1] - result.utimes[0] == 1'000'000);
  }
}

}  // namespace crsm
