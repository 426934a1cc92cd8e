#include "services/stages/scan_queue.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

struct Item {
  std::int64_t utime = 0;
  int number = 0;
};

std::int64_t CountOf(const Counters& counters, const std::string& name) {
  const auto found = counters.counts().find(name);
  return found == counters.counts().end() ? 0 : found->second;
}

}  // namespace

TEST_CASE("scans leave the queue in the order in which they came, whatever their times") {
  Counters counters;
  ScanQueue<Item> queue(counters);
  CHECK(queue.empty());
  for (const int utime : {5, 3, 9}) queue.Push({utime});
  for (const int utime : {5, 3, 9}) {
    REQUIRE_FALSE(queue.empty());
    CHECK(queue.front().utime == utime);
    queue.Pop();
  }
  CHECK(queue.empty());
  CHECK(CountOf(counters, "received") == 3);
  CHECK(CountOf(counters, "dropped_overload") == 0);
}

TEST_CASE("a scan that comes again while it waits is the same scan; once it has left it is a new one") {
  Counters counters;
  ScanQueue<Item> queue(counters);
  queue.Push({1, 10});
  queue.Push({2, 20});
  queue.Push({1, 30});
  CHECK(CountOf(counters, "resent") == 1);
  CHECK(queue.front().number == 10);
  queue.Pop();
  queue.Push({1, 40});
  queue.Pop();
  CHECK(queue.front().number == 40);
  CHECK(CountOf(counters, "resent") == 1);
}

TEST_CASE("a stage that falls behind, or is slow from the beginning, drops the oldest scans and counts them") {
  for (const bool pops : {false, true}) {
    Counters counters;
    ScanQueue<Item> queue(counters);
    for (int utime = 0; utime < 1000; ++utime) {
      queue.Push({utime});
      if (pops && utime % 10 == 9) queue.Pop();  // ten come while one is handled
    }
    CHECK(queue.front().utime == 1000 - 20 + pops);  // half a second of the fastest laser
    std::int64_t num_left = 0;
    for (; !queue.empty(); queue.Pop()) ++num_left;
    CHECK(CountOf(counters, "received") == 1000);
    CHECK(num_left + CountOf(counters, "dropped_overload") == 1000 - 100 * pops);
  }
}

}  // namespace crsm
