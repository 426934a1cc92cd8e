#include "common/results/run_origin.hpp"

#include <limits>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "common/results/read_results.hpp"
#include "common/results/summary.hpp"
#include "scratch.hpp"

namespace crsm {

TEST_CASE("a map that was continued is made from both logs, and more of one log is no other") {
  CHECK(JoinOrigins("", "monday.lcm") == "monday.lcm");
  CHECK(JoinOrigins("monday.lcm", "tuesday.lcm") == "monday.lcm; then tuesday.lcm");
  CHECK(JoinOrigins("monday.lcm", "monday.lcm") == "monday.lcm");
  CHECK(JoinOrigins("monday.lcm; then tuesday.lcm", "tuesday.lcm") == "monday.lcm; then tuesday.lcm");
  CHECK(JoinOrigins("another_monday.lcm", "monday.lcm") == "another_monday.lcm; then monday.lcm");
  std::string origin;
  for (int day = 0; day < 100; ++day) origin = JoinOrigins(origin, "day" + std::to_string(day) + ".lcm");
  CHECK(origin.size() <= 403);
  CHECK(origin.starts_with("..."));
  CHECK(origin.ends_with("day98.lcm; then day99.lcm"));
}

TEST_CASE("a utime is a date where it can be one") {
  CHECK(FormatUtc(1'059'646'830'000'000) == "2003-07-31T10:20:30Z");
  CHECK(FormatUtc(631'152'000'000'000) == "1990-01-01T00:00:00Z");
  for (const std::int64_t no_date :
       {std::int64_t{0}, std::int64_t{631'151'999'999'999}, std::int64_t{-1}, std::numeric_limits<std::int64_t>::max(),
        std::numeric_limits<std::int64_t>::min()}) {
    CAPTURE(no_date);
    CHECK(FormatUtc(no_date).empty());
  }
}

TEST_CASE("summary.json says what the map was made from, when that was recorded, and when it was mapped") {
  Summary summary;
  auto json = nlohmann::json::parse(FormatSummary(summary));
  for (const char* unknown : {"made_from", "recorded", "mapped"}) CHECK(json[unknown].is_null());
  summary.origin = {"intel.clf.gz --preset sick", "2026-11-28T03:00:00Z"};
  summary.values.first_utime = 1'059'646'830'000'000;
  json = nlohmann::json::parse(FormatSummary(summary));
  CHECK(json["made_from"] == "intel.clf.gz --preset sick");
  CHECK(json["recorded"] == "2003-07-31T10:20:30Z");
  CHECK(json["mapped"] == "2026-11-28T03:00:00Z");

  const ScratchFolder folder;
  CHECK(ReadMadeFrom(folder.path()).empty());
  folder.Write("summary.json", "{}");
  CHECK(ReadMadeFrom(folder.path()).empty());
  folder.Write("summary.json", FormatSummary(summary));
  CHECK(ReadMadeFrom(folder.path()) == "intel.clf.gz --preset sick");
}

}  // namespace crsm
