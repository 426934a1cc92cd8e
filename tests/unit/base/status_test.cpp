#include "services/base/status.hpp"

#include "catch.hpp"

namespace crsm {

TEST_CASE("counters add up by name") {
  Counters counters;
  CHECK(counters.counts().empty());
  counters.Add("handled");
  counters.Add("handled");
  counters.Add("lost", 5);
  CHECK(counters.counts() == std::map<std::string, std::int64_t>{{"handled", 2}, {"lost", 5}});
}

TEST_CASE("before the first message all latencies are 0, and one latency is every percentile") {
  Latency latency;
  CHECK(latency.num_recorded() == 0);
  CHECK(latency.max_ms() == 0.0);
  CHECK(latency.Percentile(0.5) == 0.0);
  latency.Record(3.5);
  for (const double share : {0.0, 0.5, 0.99, 1.0}) CHECK(latency.Percentile(share) == 3.5);
}

TEST_CASE("percentiles of 0 to 100 ms in any order are their numbers") {
  Latency latency;
  for (int i = 0; i <= 100; ++i) latency.Record(37 * i % 101);  // 37 and 101 have no common factor: each comes once
  CHECK(latency.Percentile(0.0) == 0.0);
  CHECK(latency.Percentile(0.5) == 50.0);
  CHECK(latency.Percentile(0.99) == 99.0);
  CHECK(latency.Percentile(1.0) == 100.0);
}

TEST_CASE("percentiles forget what is older than 1,024 messages, the longest latency does not") {
  Latency latency;
  latency.Record(500.0);
  for (int i = 0; i < 1023; ++i) latency.Record(1.0);
  CHECK(latency.Percentile(1.0) == 500.0);
  latency.Record(1.0);
  CHECK(latency.Percentile(1.0) == 1.0);
  CHECK(latency.max_ms() == 500.0);
  CHECK(latency.num_recorded() == 1025);
}

}  // namespace crsm
