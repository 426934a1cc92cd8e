#include "services/base/stall_watch.hpp"

#include <vector>

#include "catch.hpp"

using namespace crsm;
using namespace std::chrono_literals;

namespace {

/// A watch, and what it has said.
struct TestWatch {
  std::vector<std::string> said;
  StallWatch watch{"rrhc_matcher", [this](const std::string& line) { said.push_back(line); }};
  StallWatch::Clock::time_point now{1h};

  void WaitFor(const StallWatch::Awaited& awaited, std::chrono::milliseconds how_long) {
    for (const auto end = now + how_long; now < end; now += 20ms) watch.Look(awaited, now);
  }
};

constexpr StallWatch::Awaited kVersion{"version {} of the map", 123};

}  // namespace

TEST_CASE("a wait of five seconds is said once, with what is waited for") {
  TestWatch test;
  test.WaitFor(kVersion, 4990ms);
  CHECK(test.said.empty());
  test.WaitFor(kVersion, 20s);
  CHECK(test.said == std::vector<std::string>{"rrhc_matcher: has waited 5 s for version 123 of the map"});
}

TEST_CASE("waits that follow each other are no stall, and each stall is said") {
  TestWatch test;
  for (std::int64_t version = 0; version < 10; ++version) test.WaitFor({kVersion.what, version}, 4s);
  test.WaitFor({}, 20s);
  CHECK(test.said.empty());
  for (int i = 0; i < 2; ++i) {
    test.WaitFor(kVersion, 6s);
    test.WaitFor({}, 1s);
  }
  CHECK(test.said.size() == 2);
}
