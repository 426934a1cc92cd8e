#include "common/diagnosis/laser_judge.hpp"

#include <functional>
#include <limits>

#include "catch.hpp"
#include "real_logs.hpp"
#include "services/settings/command_line.hpp"
#include "services/sources/open_laser_source.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kPeriod_us = 100'000;

/// A scan of a robot that drives slowly through a room, at 10 Hz.
LaserScan RoomScan(int number) { return ScanRoom({0.001 * number, 0.0, 0.0}, 1'000'000 + number * kPeriod_us, 180); }

using Change = std::function<void(int number, LaserScan&)>;
using Said = std::vector<std::string>;

/// What is said of `num_scans` scans, each changed before it is judged.
Said Judge(int num_scans, const Change& change) {
  LaserJudge judge(ScanParameters{});
  Said said;
  for (int number = 0; number < num_scans; ++number) {
    LaserScan scan = RoomScan(number);
    change(number, scan);
    for (std::string& complaint : judge.Look(scan)) said.push_back(std::move(complaint));
  }
  return said;
}

void SetAll(LaserScan& scan, float range_m) { std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), range_m); }

/// Rays have these ranges in turn.
Change Repeat(const std::vector<float>& ranges_m) {
  return [=](int number, LaserScan& scan) {
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      scan.ranges_m[i] = ranges_m[(i + static_cast<std::size_t>(number)) % ranges_m.size()];
    }
  };
}

void Millimetres(int, LaserScan& scan) {
  for (float& range_m : scan.ranges_m) range_m *= 1000.0f;
}

/// As millimetres, among rays without return and the error codes of a Hokuyo, 1 to 19.
void MillimetresOfHokuyo(int number, LaserScan& scan) {
  Millimetres(number, scan);
  for (std::size_t i = 0; i < scan.ranges_m.size(); i += 5) scan.ranges_m[i] = 0.0f;
  for (std::size_t i = 1; i < scan.ranges_m.size(); i += 20) scan.ranges_m[i] = 7.0f;
}

/// The clock is that much later, as a function of the scan's number.
template <class Later>
Change Clock(Later&& later_us) {
  return [=](int number, LaserScan& scan) { scan.utime += later_us(number); };
}

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const Change kStands = [](int, LaserScan& scan) { scan.utime = 77; };
const Change kNoReturn = Repeat({0.0f, -1.0f, kInfinity, kNan});

}  // namespace

TEST_CASE("nothing is said of a good laser, or of accidents") {
  const std::vector<std::pair<const char*, Change>> good{
      {"a room", [](int, LaserScan&) {}},
      {"a scan that is sent again, with a ray that is no number",
       [](int, LaserScan& scan) {
         scan = RoomScan(0);
         scan.ranges_m[5] = kNan;
       }},
      {"a clock that steps back now and then, as in logs",
       Clock([](int number) { return number % 20 == 0 ? -900'000 : 0; })},
      {"a robot in the open, whose laser, a SICK, reaches a wall with one ray in twenty", [](int, LaserScan& scan) {
         for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
           if (i % 20 != 0) scan.ranges_m[i] = 81.83f;
         }
       }}};
  for (const auto& [name, change] : good) {
    CAPTURE(name);
    CHECK(Judge(1000, change) == Said{});
  }
  CHECK(Judge(5, [](int, LaserScan& scan) { scan.ranges_m.clear(); }).empty());
}

TEST_CASE("each fault of a laser is said once, in one line") {
  const std::vector<std::pair<Change, const char*>> faults{
      {Millimetres, "ranges look like millimetres"},
      {Millimetres, "divide by 1000"},
      {MillimetresOfHokuyo, "ranges look like millimetres"},
      {Repeat({3000.0f, 9000.0f, 1000.0f}), "half of them above 3000"},
      {Repeat({1000.0f}), "ranges are 1000 m to 1000 m"},  // a number that stands for no return, and no millimetres
      {Repeat({31.0f, 29.0f, 35.0f, 30.0f}), "ranges are 29 m to 35 m"},
      {Repeat({29.0f}), "ranges are 29 m to 29 m, but only 0.05 m to 28.5 m are accepted: set range_max_m"},
      {kNoReturn, "none of the 180 rays has a range"},
      {kStands, "utime stands still at 77"},
      {[](int, LaserScan& scan) { scan.utime = 0; }, "utime is always 0"},
      {[](int number, LaserScan& scan) { scan.utime = number / 10 * 1'000'000; }, "utime stands still"},
      {[](int number, LaserScan& scan) { scan.utime = number / 2 * 1'000'000; }, "utime"},
      {[](int number, LaserScan& scan) { scan.utime = 1'000'000'000 - number; }, "utime goes back in 10 of 20 scans"},
      {Clock([](int number) { return number % 2 == 0 ? 5'000'000 : 0; }), "two lasers on this channel"},
      {Clock([](int number) { return number >= 200 ? -20'000'000 : 0; }), "the clock steps back by 20 s at scan 201: "},
      {Clock([](int number) { return number < 500 ? 2'100'000'000 : 0; }), "by 35 min at scan 501: "},
      {Clock([](int number) { return number < 5 ? 1'700'000'000'000'000 : 0; }), "by 19676 days at scan 6: "}};
  for (const auto& [change, expected] : faults) {
    CAPTURE(expected);
    const Said said = Judge(1000, change);
    REQUIRE(said.size() == 1);
    CHECK(said[0].find(expected) != std::string::npos);
    CHECK(said[0].find('\n') == std::string::npos);
  }
  // Of a clock in another unit, and of one in seconds that scans are lost, too.
  const auto Count = [](std::int64_t first, std::int64_t num_per_second) {
    return Change([=](int number, LaserScan& scan) { scan.utime = first + number * num_per_second / 10; });
  };
  CHECK(Judge(50, Count(1'700'000'000'000, 1'000)).empty());
  const Said milliseconds = Judge(1000, Count(1'700'000'000'000, 1'000));
  REQUIRE(milliseconds.size() == 1);
  CHECK(
      milliseconds[0].starts_with("utime is in milliseconds, as 1700000005000 shows: times are 1,000 times too small"));
  const Said nanoseconds = Judge(1000, Count(5'000, 1'000'000'000));
  REQUIRE(nanoseconds.size() == 1);
  CHECK(nanoseconds[0].starts_with("utime goes up by 1e+08 a scan, as if it were in nanoseconds"));
  const Said seconds = Judge(1000, Count(1'700'000'000, 1));
  REQUIRE(seconds.size() == 2);
  CHECK(seconds[0].starts_with("utime is in seconds"));
  CHECK(seconds[1].find("scans with the utime of another one are lost") != std::string::npos);
  CHECK(Judge(1000, Count(1'700'000'000'000'000, 1'000'000)).empty());
  // Of a clock that begins anew each time; of two lasers with clocks a minute apart this once, and what is wrong.
  CHECK(Judge(1000, Clock([](int number) { return number / 200 * -60'000'000; })).size() == 4);
  CHECK(Judge(1000, Clock([](int number) { return number % 2 == 0 ? 60'000'000 : 0; })).size() == 2);
  CHECK(Judge(1000, [](int number, LaserScan& scan) {
          scan.utime = 0;
          Millimetres(number, scan);
        }).size() == 2);
}

TEST_CASE("a fault is found out within ten scans that show it, and within twenty of a laser that worked for an hour") {
  for (const Change& fault : {Change(Millimetres), kNoReturn}) {
    CHECK(Judge(9, fault).empty());
    CHECK(Judge(10, fault).size() == 1);
  }
  CHECK(Judge(15,
              [](int number, LaserScan& scan) {  // one in ten is looked at of the later ones alone
                if (number > 0) SetAll(scan, 0.0f);
              })
            .size() == 1);
  CHECK(Judge(10, kStands).empty());  // nine steps between them
  CHECK(Judge(11, kStands).size() == 1);
  for (const int wrong_from : {36'000, 36'001}) {  // a scan that is looked at anyway, and the one after it
    const auto Blind = [&](int number, LaserScan& scan) {
      if (number >= wrong_from) SetAll(scan, 0.0f);
    };
    CHECK(Judge(wrong_from + 9, Blind).empty());
    CHECK(Judge(wrong_from + 20, Blind).size() == 1);
  }
}

namespace {

/// What is said of a whole log or world, under a preset if there is one.
std::vector<std::string> JudgeSource(const std::string& name, const char* preset) {
  CommandLine line("test", "", {ParameterGroup::kScan}, {});
  const std::vector<const char*> argv{"test", "--preset", preset};
  REQUIRE_FALSE(line.Parse(preset ? 3 : 1, argv.data()));
  LaserJudge judge(line.parameters().scan);
  const auto source = OpenLaserSource(name, {});
  std::vector<std::string> said;
  while (const auto scan = source->Next()) {
    for (std::string& complaint : judge.Look(*scan)) said.push_back(std::move(complaint));
  }
  return said;
}

}  // namespace

TEST_CASE("nothing is said of the simulated worlds") {
  for (const std::string& world : ListBuiltInWorlds()) {
    CAPTURE(world);
    CHECK(JudgeSource("sim:" + world, nullptr) == std::vector<std::string>{});
  }
}

TEST_CASE("nothing is said of the real logs", "[logs]") {
  for (const auto& [log, preset] :
       std::vector<std::pair<std::string, const char*>>{{"radish/aces.clf.gz", "sick"},
                                                        {"radish/fr079.clf.gz", "sick"},
                                                        {"radish/intel.clf.gz", "sick"},
                                                        {"radish/killian.clf.gz", "sick"},
                                                        {"urg04lx/exp1.clf.gz", "urg-04lx"},
                                                        {"urg04lx/exp3.clf.gz", "urg-04lx"},
                                                        {"lcm/mbot_convex.lcmlog.gz", nullptr}}) {
    CAPTURE(log);
    if (const auto path = FindRealLog(log)) CHECK(JudgeSource(*path, preset) == std::vector<std::string>{});
  }
}

}  // namespace crsm
