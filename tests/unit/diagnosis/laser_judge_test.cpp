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

/// What is said of `num_scans` scans, each changed before it is judged.
std::vector<std::string> Judge(int num_scans, const std::function<void(int number, LaserScan&)>& change) {
  LaserJudge judge{ScanParameters{}};
  std::vector<std::string> said;
  for (int number = 0; number < num_scans; ++number) {
    LaserScan scan = RoomScan(number);
    change(number, scan);
    for (std::string& complaint : judge.Look(scan)) said.push_back(std::move(complaint));
  }
  return said;
}

void SetAll(LaserScan& scan, float range_m) { std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), range_m); }

void CheckSaid(const std::vector<std::string>& said, const std::string& expected) {
  CAPTURE(said);
  REQUIRE(said.size() == 1);
  CHECK(said[0].find(expected) != std::string::npos);
  CHECK(said[0].find('\n') == std::string::npos);
}

}  // namespace

TEST_CASE("nothing is said of a good laser") {
  CHECK(Judge(1000, [](int, LaserScan&) {}).empty());
}

TEST_CASE("nothing is said of scans without beams") {
  CHECK(Judge(5, [](int, LaserScan& scan) { scan.ranges_m.clear(); }).empty());
}

TEST_CASE("each fault is said once, after ten scans that show it, within 3 s of a laser of 4 Hz") {
  const auto Millimetres = [](int, LaserScan& scan) {
    for (float& range_m : scan.ranges_m) range_m *= 1000.0f;
  };
  CHECK(Judge(9, Millimetres).empty());
  CheckSaid(Judge(10, Millimetres), "ranges look like millimetres");
  CheckSaid(Judge(1000, Millimetres), "divide by 1000");

  const auto Stands = [](int, LaserScan& scan) { scan.utime = 77; };
  CHECK(Judge(10, Stands).empty());  // nine steps between them
  CheckSaid(Judge(11, Stands), "utime stands still at 77");
  CheckSaid(Judge(1000, [](int, LaserScan& scan) { scan.utime = 0; }), "utime is always 0");
  CheckSaid(Judge(1000, [](int number, LaserScan& scan) { scan.utime = 1'000'000'000 - number; }),
            "utime goes back in 10 of 20 scans");

  const auto NoReturn = [](int number, LaserScan& scan) {
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const std::size_t kind = (i + static_cast<std::size_t>(number)) % 4;
      scan.ranges_m[i] = kind == 0   ? 0.0f
                         : kind == 1 ? -1.0f
                         : kind == 2 ? std::numeric_limits<float>::infinity()
                                     : std::numeric_limits<float>::quiet_NaN();
    }
  };
  CHECK(Judge(9, NoReturn).empty());
  CheckSaid(Judge(1000, NoReturn), "none of the 180 rays has a range");
  CheckSaid(Judge(1000, [](int, LaserScan& scan) { SetAll(scan, 29.0f); }),
            "ranges are 29 m to 29 m, but only 0.05 m to 28.5 m are accepted: set range_max_m");
}

TEST_CASE("what is said of ranges holds in whatever order they come") {
  const auto Repeat = [](std::vector<float> ranges_m) {
    return [=](int, LaserScan& scan) {
      for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) scan.ranges_m[i] = ranges_m[i % ranges_m.size()];
    };
  };
  CheckSaid(Judge(1000, Repeat({31.0f, 29.0f, 35.0f, 30.0f})), "ranges are 29 m to 35 m");
  CheckSaid(Judge(1000, Repeat({3000.0f, 9000.0f, 1000.0f})), "half of them above 3000");
}

TEST_CASE("a clock that stands still is told from a scan that is sent again, also one with rays that are no numbers") {
  CHECK(Judge(1000, [](int, LaserScan& scan) {
          scan = RoomScan(0);
          scan.ranges_m[5] = std::numeric_limits<float>::quiet_NaN();
        }).empty());
}

TEST_CASE("a clock that ticks less often than the laser turns is one that stands still") {
  CheckSaid(Judge(1000, [](int number, LaserScan& scan) { scan.utime = number / 10 * 1'000'000; }),
            "utime stands still");
  CHECK(Judge(1000, [](int number, LaserScan& scan) { scan.utime = number / 2 * 1'000'000; }).size() == 1);
}

TEST_CASE("a clock that steps back now and then, as in logs, is no fault") {
  CHECK(Judge(1000, [](int number, LaserScan& scan) { scan.utime -= number % 20 == 0 ? 900'000 : 0; }).empty());
}

TEST_CASE("a clock that begins anew is said with its step and its scan, each time") {
  const auto Restart = [](int number, LaserScan& scan) { scan.utime -= number >= 200 ? 20'000'000 : 0; };
  CheckSaid(Judge(1000, Restart), "the clock steps back by 20 s at scan 201: ");
  CheckSaid(Judge(1000, [](int number, LaserScan& scan) { scan.utime += number < 500 ? 2'100'000'000 : 0; }),
            "by 35 min at scan 501: ");
  CheckSaid(Judge(1000, [](int number, LaserScan& scan) { scan.utime += number < 5 ? 1'700'000'000'000'000 : 0; }),
            "by 19676 days at scan 6: ");
  CHECK(Judge(1000, [](int number, LaserScan& scan) { scan.utime -= number / 200 * 60'000'000; }).size() == 4);
  // Two lasers with clocks a minute apart: this once, and what is wrong with them.
  CHECK(Judge(1000, [](int number, LaserScan& scan) { scan.utime += number % 2 == 0 ? 60'000'000 : 0; }).size() == 2);
}

TEST_CASE("two lasers with different clocks on one channel go back at every other scan") {
  CheckSaid(Judge(100, [](int number, LaserScan& scan) { scan.utime += number % 2 == 0 ? 5'000'000 : 0; }),
            "two lasers on this channel");
}

TEST_CASE("millimetres are seen among rays without return and the error codes of a Hokuyo, 1 to 19") {
  CheckSaid(Judge(1000,
                  [](int, LaserScan& scan) {
                    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
                      scan.ranges_m[i] = i % 5 == 0 ? 0.0f : i % 20 == 1 ? 7.0f : 1000.0f * scan.ranges_m[i];
                    }
                  }),
            "ranges look like millimetres");
}

TEST_CASE("a number that stands for no return is beyond the range, and no millimetres") {
  CheckSaid(Judge(1000,
                  [](int number, LaserScan& scan) {
                    SetAll(scan, 1000.0f);
                    scan.utime += number;
                  }),
            "ranges are 1000 m to 1000 m");
}

TEST_CASE("a robot in the open, whose laser reaches a wall with one ray in twenty, is not complained of") {
  CHECK(Judge(1000, [](int, LaserScan& scan) {
          for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
            if (i % 20 != 0) scan.ranges_m[i] = 81.83f;  // no return, of a SICK
          }
        }).empty());
}

TEST_CASE("a laser that goes wrong after an hour is found out within twenty scans") {
  for (const int wrong_from : {36'000, 36'001}) {  // a scan that is looked at anyway, and the one after it
    const auto Blind = [&](int number, LaserScan& scan) {
      if (number >= wrong_from) SetAll(scan, 0.0f);
    };
    CHECK(Judge(wrong_from + 9, Blind).empty());
    CheckSaid(Judge(wrong_from + 20, Blind), "none of the 180 rays has a range");
  }
}

TEST_CASE("two faults at once are both said") {
  CHECK(Judge(1000, [](int, LaserScan& scan) {
          scan.utime = 0;
          scan.ranges_m[0] = 0.0f;
          for (float& range_m : scan.ranges_m) range_m *= 1000.0f;
        }).size() == 2);
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
