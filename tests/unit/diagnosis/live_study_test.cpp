#include "services/diagnosis/live_study.hpp"

#include <chrono>
#include <thread>

#include "catch.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

/// Scans of a robot that turns fast, and of a laser whose beams take 0.15 s.
std::vector<LaserScan> DriveArena() { return ScansOf(LoadWorld("arena")); }

Parameters SayingSweep(double sweep_s) {
  Parameters parameters;
  parameters.scan.range_max_m = 12.0;
  parameters.scan.sweep_s = sweep_s;
  return parameters;
}

/// All that is found while the scans pass by.
std::vector<std::string> Follow(LiveStudy& study, const std::vector<LaserScan>& scans) {
  std::vector<std::string> found;
  const auto Take = [&] {
    for (std::string& line : study.TakeFindings()) found.push_back(std::move(line));
  };
  for (const LaserScan& scan : scans) {
    study.Add(scan);
    study.Add(scan);  // sent again
    Take();
  }
  for (int i = 0; i < 6000 && found.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    Take();
  }
  return found;
}

}  // namespace

TEST_CASE("a live laser whose beams run the other way than it is said is told so once, with the flags that are right") {
  const std::vector<LaserScan> scans = DriveArena();
  REQUIRE(scans.size() >= 300);
  LiveStudy study(SayingSweep(-0.15));
  const std::vector<std::string> found = Follow(study, scans);
  REQUIRE(found.size() == 1);
  CHECK(found[0] ==
        "each scan takes 0.15 s, counter-clockwise, not as is said (0.15 s, clockwise): --no-beam-times --sweep-s "
        "0.1500");
}

TEST_CASE("a live laser of whose sweep nothing is said is told it with the flags that are right") {
  std::vector<LaserScan> scans = DriveArena();
  const std::vector<std::string> found = DescribeStudy(scans, SayingSweep(0.0));
  REQUIRE(found.size() == 1);
  CHECK(found[0].find("each scan takes 0.151 s, counter-clockwise: --no-beam-times --sweep-s 0.151") == 0);
  for (LaserScan& scan : scans) scan = Mirror(std::move(scan));
  CHECK(DescribeStudy(scans, SayingSweep(0.0))[0].find("each scan takes 0.151 s, clockwise: ") == 0);
}

TEST_CASE("of a live laser whose beams are as they are said to be nothing is told") {
  CHECK(DescribeStudy(DriveArena(), SayingSweep(0.15)).empty());
  CHECK(DescribeStudy({}, SayingSweep(0.15)).empty());
}

TEST_CASE(
    "a range of a live laser that stands for no return, and would be mapped, is told with the flag that mends it") {
  std::vector<LaserScan> scans = DriveArena();
  scans.resize(100);
  for (LaserScan& scan : scans) {
    for (std::size_t i = 0; i < scan.ranges_m.size(); i += 3) scan.ranges_m[i] = 8.19f;
    for (float& range_m : scan.ranges_m) range_m = std::min(range_m, 8.19f);
  }
  Parameters parameters = SayingSweep(0.15);
  const std::vector<std::string> found = DescribeStudy(scans, parameters);
  REQUIRE(found.size() == 1);
  CHECK(found[0].find("8.19 m is no return (") == 0);
  CHECK(found[0].find("--range-max-m 8.") != std::string::npos);
  parameters.scan.range_max_m = 8.0;
  CHECK(DescribeStudy(scans, parameters).empty());
}
