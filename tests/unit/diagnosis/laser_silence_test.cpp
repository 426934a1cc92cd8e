#include "services/diagnosis/laser_silence.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

using namespace std::chrono_literals;
using enum LaserSilence::Verdict;

const LaserSilence::Time kStart{1000s};

}  // namespace

TEST_CASE("a laser that is never heard is missed once, after 1.5 s") {
  LaserSilence silence(kStart);
  CHECK(silence.Look(kStart + 1499ms) == kNone);
  CHECK(silence.Look(kStart + 1500ms) == kNothingYet);
  CHECK(silence.Look(kStart + 1h) == kNone);
  CHECK_FALSE(silence.ever_heard());
}

TEST_CASE("a laser that falls silent is missed after 3 s, once for each silence") {
  LaserSilence silence(kStart);
  for (const auto heard : {kStart, kStart + 1h}) {
    silence.Hear(heard);
    CHECK(silence.ever_heard());
    CHECK(silence.Look(heard + 2999ms) == kNone);
    CHECK(silence.Look(heard + 3s) == kFellSilent);
    CHECK(silence.Look(heard + 10s) == kNone);
  }
}

TEST_CASE("a laser that was missed is told to be back, once, and how long it was away") {
  LaserSilence silence(kStart);
  CHECK_FALSE(silence.IsMissing(kStart + 2s));
  silence.Look(kStart + 2s);
  CHECK(silence.IsMissing(kStart + 7s));
  CHECK(silence.Hear(kStart + 7s) == 7s);
  CHECK_FALSE(silence.IsMissing(kStart + 7s));
  CHECK_FALSE(silence.Hear(kStart + 8s));
  CHECK_FALSE(silence.Hear(kStart + 20s));  // nobody had looked
  silence.Look(kStart + 24s);
  silence.HearPublisher(kStart + 25s, "publishing");
  CHECK_FALSE(silence.IsMissing(kStart + 26s));
  CHECK(silence.IsMissing(kStart + 28s));
  CHECK(silence.Hear(kStart + 30s) == 10s);
}

TEST_CASE("a publisher that lives is waited for, one that dies is missed") {
  LaserSilence silence(kStart);
  silence.Hear(kStart);
  for (int second = 0; second <= 100; ++second) {
    silence.HearPublisher(kStart + second * 1s, "publishing");
    CHECK(silence.Look(kStart + second * 1s) == kNone);
  }
  CHECK(silence.Look(kStart + 102s) == kNone);
  CHECK(silence.Look(kStart + 103s) == kFellSilent);
}

TEST_CASE("nothing is missed after the end of a log, until another laser has been heard") {
  LaserSilence silence(kStart);
  silence.Hear(kStart);
  silence.HearPublisher(kStart, kPublisherFinished);
  CHECK(silence.Look(kStart + 1h) == kNone);
  silence.Hear(kStart + 2h);
  CHECK(silence.Look(kStart + 2h + 3s) == kFellSilent);
}

}  // namespace crsm
