#include "common/logs/carmen_log.hpp"

#include "catch.hpp"
#include "common/logs/left_out.hpp"
#include "common/math/trigonometry.hpp"
#include "real_logs.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

using Utimes = std::vector<std::int64_t>;
using Lines = std::vector<std::string>;

std::string Repeat(const std::string& word, int count) {
  std::string words;
  for (int i = 0; i < count; ++i) words += word;
  return words;
}

std::string Flaser(int count, const std::string& ranges, const std::string& time_s) {
  return "FLASER " + std::to_string(count) + ranges + " 1 2 0.1 1 2 0.1 " + time_s + " host 7.5\n";
}

/// Two beams at that time.
std::string ScanAt(const std::string& time_s) { return Flaser(2, " 1 1", time_s); }

/// With that pose of the robot.
std::string ScanFrom(const std::string& pose, int second) {
  return "FLASER 2 1 1 0 0 0 " + pose + " " + std::to_string(second) + ".5 host 7.5\n";
}

std::string RobotLaser(const std::string& geometry, const std::string& beams) {
  return "ROBOTLASER1 0 " + geometry + " 0.01 0 " + beams + " 0 1 2 3 1 2 3 0 0 0.4 0.4 1e9 12.25 host 7.5\n";
}

const std::string kGood = Flaser(3, " 1.5 0 81.83", "10.5");

/// All that a log gives.
struct Result {
  std::vector<LaserScan> scans;
  std::vector<std::optional<Pose2>> odometry;  ///< of each scan
  std::map<std::string, std::int64_t> counts;
  Lines complaints;
  Lines notes;  ///< on the odometry
};

Result Read(const std::string& bytes) {
  const ScratchFile file(bytes);
  CarmenLog log(file.path());
  CHECK_FALSE(log.Odometry());
  Result result;
  while (auto scan = log.Next()) {
    result.scans.push_back(*scan);
    result.odometry.push_back(log.Odometry());
  }
  CHECK_FALSE(log.Next());
  CHECK(log.Progress() == 1.0);
  result.counts = log.Counts();
  result.complaints = log.Complaints();
  result.notes = log.OdometryNotes();
  return result;
}

}  // namespace

TEST_CASE("a timestamp becomes microseconds exactly") {
  CHECK(ParseUtime("1211.520329") == 1211520329);
  CHECK(ParseUtime("976052905.167303") == 976052905167303);
  CHECK(ParseUtime("0.000001") == 1);
  CHECK(ParseUtime("12") == 12000000);
  CHECK(ParseUtime("12.5") == 12500000);
  CHECK(ParseUtime("9000000000000.000001") == 9000000000000000001);
  // Digits beyond the microsecond are rounded, and carry.
  CHECK(ParseUtime("1.0000004") == 1000000);
  CHECK(ParseUtime("1.0000005") == 1000001);
  CHECK(ParseUtime("1.99999951234") == 2000000);
  // With exponents, as C++ writes doubles: exactly, too.
  CHECK(ParseUtime("1.13486e+09") == 1134860000000000);
  CHECK(ParseUtime("1e9") == 1000000000000000);
  CHECK(ParseUtime("1.211520329E+3") == 1211520329);
  CHECK(ParseUtime("12.5e-1") == 1250000);
  CHECK(ParseUtime("1e-06") == 1);
  CHECK(ParseUtime("5e-7") == 1);
  CHECK(ParseUtime("4e-7") == 0);
  CHECK(ParseUtime("1e-1000") == 0);
  CHECK(ParseUtime("0e1000") == 0);
  CHECK(ParseUtime("9e12") == 9000000000000000000);
}

TEST_CASE("a timestamp that is no decimal number, or too large, is none") {
  for (const char* text : {"",
                           ".",
                           ".5",
                           "5.",
                           "-1.5",
                           "+1",
                           "1.2.3",
                           "nan",
                           "inf",
                           "0x10",
                           "0x1p3",
                           "1,5",
                           " 1",
                           "9000000000001",
                           "99999999999999999999999",
                           "e9",
                           "1e",
                           "1e+",
                           "1e+-5",
                           "1e++5",
                           "1e5.5",
                           "1.e5",
                           "1e5e5",
                           "1e400",
                           "9.1e12",
                           "1e1001",
                           "1e-1001",
                           "1e99999999999",
                           "1e-2147483648"}) {
    CAPTURE(text);
    CHECK_FALSE(ParseUtime(text));
  }
}

TEST_CASE("a FLASER line begins at -90 deg, and its step follows from the number of beams") {
  const std::vector<std::pair<int, double>> steps_deg = {{180, 1.0}, {181, 1.0},  {360, 0.5},
                                                         {361, 0.5}, {720, 0.25}, {721, 0.25},
                                                         {2, 180.0}, {19, 10.0},  {4096, 180.0 / 4095.0}};
  for (const auto& [count, step_deg] : steps_deg) {
    CAPTURE(count);
    const Result result = Read(Flaser(count, Repeat(" 2.5", count), "10.5"));
    REQUIRE(result.scans.size() == 1);
    const LaserScan& scan = result.scans[0];
    CHECK(scan.utime == 10500000);
    CHECK(scan.angle_min_rad == static_cast<float>(-kPi / 2.0));
    CHECK(scan.angle_step_rad == Approx(step_deg * kPi / 180.0).epsilon(1e-6));  // single precision
    CHECK(scan.ranges_m == std::vector<float>(static_cast<std::size_t>(count), 2.5f));
    CHECK(result.counts.empty());
  }
}

TEST_CASE("how many scans have odometry is told") {
  const std::string drive = ScanFrom("5 5 0", 0) + ScanFrom("5.7 5.8 1", 1) + ScanFrom("nan 0 0", 2);
  CHECK(Read(drive).notes == Lines{"gives odometry to 2 of 3 scans (the robot's pose in its lines)"});
}

TEST_CASE("a ROBOTLASER1 line brings its own angles, and a reading at its maximum range or beyond is no return") {
  const Result result = Read(RobotLaser("-2.0 4.0 0.5 4.0", "5 0.007 3.999 4.0 5.24 nan"));
  REQUIRE(result.scans.size() == 1);
  const LaserScan& scan = result.scans[0];
  CHECK(scan.utime == 12250000);
  CHECK(scan.angle_min_rad == -2.0f);
  CHECK(scan.angle_step_rad == 0.5f);
  REQUIRE(scan.ranges_m.size() == 5);
  CHECK(std::isnan(scan.ranges_m[4]));
  CHECK(std::vector<float>(scan.ranges_m.begin(), scan.ranges_m.begin() + 4) ==
        std::vector<float>{0.007f, 3.999f, 0.0f, 0.0f});
  // One that does not know its maximum range keeps all readings.
  CHECK(Read(RobotLaser("-2.0 4.0 0.5 0.0", "2 1.5 50")).scans.at(0).ranges_m == std::vector<float>{1.5f, 50.0f});
  // Remissions are passed over.
  CHECK(Read("ROBOTLASER1 0 -1 2 1 9 0.01 1 2 1 2 2 77 78 1 2 3 1 2 3 0 0 0 0 0 12.25 host 7.5\n").scans ==
        std::vector<LaserScan>{{12250000, -1.0f, 1.0f, {1.0f, 2.0f}}});
}

TEST_CASE("odometry is the robot's pose of the scan's own line, to a millionth, whatever the laser's says") {
  const Result result = Read("FLASER 2 1 1 9 9 9 1.25 -2.5 0.1 1.5 host 7.5\nODOM 5 5 0.5 0 0 0 1.6 host 7.5\n" +
                             RobotLaser("-1 2 1 9", "2 1 2") + "FLASER 2 1 1 0 0 0 1.0000004 1e6 7 2.5 host 7.5\n");
  // 7 rad less a turn.
  CHECK(result.odometry ==
        std::vector<std::optional<Pose2>>{Pose2{1.25, -2.5, 0.1}, Pose2{1.0, 2.0, 3.0}, Pose2{1.0, 1e6, 0.716815}});
  CHECK(result.counts.empty());
}

TEST_CASE("a scan whose odometry is no pose is used without it, and that is counted") {
  std::string lines = ScanFrom("0 0 0", 0);
  int second = 1;
  for (const char* pose : {"nan 0 0", "0 inf 0", "0 0 -inf", "0 0 1e300", "1000001 0 0", "0 0 nan"}) {
    lines += ScanFrom(pose, second++);
  }
  const Result result = Read(lines);
  REQUIRE(result.odometry.size() == 7);
  for (std::size_t i = 0; i < 7; ++i) CHECK(result.odometry[i].has_value() == (i == 0));
  CHECK(result.counts == std::map<std::string, std::int64_t>{{"bad_odometry", 6}});
}

TEST_CASE("a log reads the same plain, compressed and with DOS line ends") {
  const std::string text =
      "# comment\nPARAM robot_name x\n" + kGood + "ODOM 1 2 3\n\n" + RobotLaser("0 1 1 4", "2 1 2");
  std::string dos_text;
  for (const char c : text) dos_text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const auto scans = Read(text).scans;
  CHECK(scans.size() == 2);
  CHECK(Read(Compress(text)).scans == scans);
  CHECK(Read(dos_text).scans == scans);
  CHECK(Read(dos_text).counts.empty());
}

TEST_CASE("scans come in the log's order though their time goes back; one with the time of an earlier one is skipped") {
  const Result result = Read(ScanAt("3.0") + ScanAt("1.0") + ScanAt("3.0") + ScanAt("2.0"));
  CHECK(UtimesOf(result.scans) == Utimes{3000000, 1000000, 2000000});
  CHECK(result.counts.at("utime_repeated") == 1);
}

TEST_CASE("numbers with exponents are numbers, wherever they stand") {
  const Result result = Read("FLASER 3 1.5e+00 2e-1 8.183E+1 0 0 1.2e-16 -1.5e0 2.5e-1 1e-3 1.05e+01 gfs 1.05e+01\n");
  REQUIRE(result.scans.size() == 1);
  CHECK(result.scans[0].utime == 10500000);
  CHECK(result.scans[0].ranges_m == std::vector<float>{1.5f, 0.2f, 81.83f});
  CHECK(result.odometry.at(0) == Pose2{-1.5, 0.25, 0.001});
  CHECK(result.counts.empty());
}

TEST_CASE("scans whose stamps are rounded to six digits, or are all 0, get times of their own, and that is said") {
  for (const std::string stamp : {"0", "1.13486e+09"}) {
    CAPTURE(stamp);
    std::string log;
    for (int i = 0; i < 237; ++i) log += Flaser(2, " 1 " + std::to_string(1000 + i), stamp);
    std::string with_logger = log;
    const std::string logger = "host 7.5";
    for (std::size_t at = 0, i = 0; (at = with_logger.find(logger, at)) != std::string::npos; ++i, ++at) {
      with_logger.replace(at, logger.size(), "host " + std::to_string(i) + ".25");
    }
    const Result numbered = Read(log);
    REQUIRE(numbered.scans.size() == 237);
    for (int i = 0; i < 237; ++i) {
      CHECK(numbered.scans[static_cast<std::size_t>(i)].utime == *ParseUtime(stamp) + i * 1'000'000);
    }
    CHECK(numbered.complaints ==
          Lines{"49 of the first 50 scans have the ipc_timestamp of the scan before: the scans "
                "are numbered instead, as if one came every 1 s: times and speeds are not the true ones"});
    const Result logged = Read(with_logger);
    REQUIRE(logged.scans.size() == 237);
    CHECK(logged.scans[3].utime == 3'250'000);
    CHECK(logged.complaints.at(0).ends_with("the times at which the scans were recorded are used instead"));
  }
}

TEST_CASE("scans that are left out are worth a word from ten or one in a hundred on, and no handful of many") {
  CHECK_FALSE(IsWorthSaying(9, 2000));
  CHECK(IsWorthSaying(10, 2000));
  CHECK_FALSE(IsWorthSaying(1, 101));
  CHECK(IsWorthSaying(1, 100));
  CHECK_FALSE(IsWorthSaying(0, 0));
}

TEST_CASE("what an editor puts before a text is no part of its first line") {
  CHECK(Read("\xef\xbb\xbf" + ScanAt("3.0") + ScanAt("4.0")).scans.size() == 2);
}

TEST_CASE("where many scans are left out it is said why, and which line is the first of them") {
  const std::string good = ScanAt("3.0");
  const std::string no_time = "FLASER 2 1 1 0 0 0 0 0 0 nohost 0\n";
  const std::vector<std::pair<std::string, std::string>> complaints{
      {good + no_time, "1 of 2 scans are left out: line 2 is wrong at 'nohost'"},
      {"# a log\n" + no_time, "1 of 1 scans are left out: line 2 is wrong at 'nohost'"},
      {good + no_time + no_time, "2 of 3 scans are left out: line 2 is wrong at 'nohost'"},
      {ScanAt("1.01893e+99"), "1 of 1 scans are left out: line 1 is wrong at '1.01893e+99'"},
      {ScanAt("0x1p3"), "1 of 1 scans are left out: line 1 is wrong at '0x1p3'"},
      {RobotLaser("-2 4.0 0 4.0", "2 1 1"), "1 of 1 scans are left out: line 1 is wrong at '0'"},
      {RobotLaser("50 4.0 0.5 4.0", "2 1 1"), "1 of 1 scans are left out: line 1 is wrong at '50'"},
      {RobotLaser("-2 4.0 2.2 4.0", "4 1 1 1 1"),
       "1 of 1 scans are left out: line 1 has beams over more than a full turn: its angles must be radians"},
      {"FLASER 2 1\n", "1 of 1 scans are left out: line 1 ends before its last field"},
      {"FLASER 2 1 1 " + Repeat("0 ", 1 << 19) + "\n",
       "1 of 1 scans are left out: line 1 is longer than any line of a laser"},
      {good + good + good,
       "2 of 3 scans are left out: their ipc_timestamp repeats that of an earlier scan; each scan needs its own"}};
  for (const auto& [text, complaint] : complaints) CHECK(Read(text).complaints == Lines{complaint});
  std::string drive;
  for (int i = 0; i < 2000; ++i) drive += ScanAt(std::to_string(i) + ".0");
  CHECK(Read(drive + Repeat(no_time, 9)).complaints.empty());
}

TEST_CASE("a line of more beams than a scan may have is thinned, over the same angles, and that is said once") {
  const Result result = Read(Flaser(5520, Repeat(" 1 2", 2760), "1.5") + Flaser(5520, Repeat(" 1 2", 2760), "2.5"));
  REQUIRE(result.scans.size() == 2);
  CHECK(result.scans[0].ranges_m == std::vector<float>(2760, 1.0f));
  CHECK(result.scans[0].angle_step_rad == Approx(2.0 * kPi / 5519.0));
  CHECK(result.complaints == Lines{"scans have 5520 beams, of which one in 2 is used, because 4096 are the most"});
}

TEST_CASE("a malformed line is counted and skipped, and the next one is read") {
  const std::vector<std::string> bad_lines = {
      "FLASER\n",
      "FLASER three 1 1 1 0 0 0 0 0 0 1.5 host 1.5\n",
      Flaser(1, " 1", "1.5"),  // too few beams
      Flaser(0, "", "1.5"),
      Flaser(-3, " 1 1 1", "1.5"),
      Flaser(65537, Repeat(" 1", 65537), "1.5"),  // too many
      Flaser(2147483647, " 1 1", "1.5"),
      Flaser(3, " 1 1", "1.5"),      // fewer ranges than said
      Flaser(3, " 1 1 1 1", "1.5"),  // more
      Flaser(3, " 1 1.2.3 1", "1.5"),
      Flaser(3, " 1 x 1", "1.5"),
      Flaser(3, " 1 1e99 1", "1.5"),  // no single precision
      Flaser(3, " 1 1 1", "-1.5"),
      Flaser(3, " 1 1 1", "nan"),
      "FLASER 3 1 1 1 0 0 0 0 0 zero 1.5 host 1.5\n",
      "FLASER 3 1 1 1 0 0 0 0 0 0 1.5\n",  // no host
      "ROBOTLASER1\n",
      RobotLaser("nan 4.0 0.5 4.0", "2 1 1"),
      RobotLaser("-2 4.0 nan 4.0", "2 1 1"),
      RobotLaser("-2 4.0 0 4.0", "2 1 1"),  // all beams in one direction
      RobotLaser("1e30 4.0 0.5 4.0", "2 1 1"),
      RobotLaser("-2 4.0 0.5 4.0", "1 1"),
      RobotLaser("-2 4.0 0.5 4.0", "3 1 1"),
      "FLASER 2 1 1 " + Repeat("0 ", 1 << 19) + "\n",  // longer than 1 MiB
      "FLASER 2 1 1 " + Repeat("0 ", 3 << 20) + "\n",
      Flaser(3, std::string(" 1 \0 1", 6), "1.5"),
  };
  for (const std::string& bad_line : bad_lines) {
    CAPTURE(bad_line.substr(0, 80));
    const Result result = Read(bad_line + kGood);
    CHECK(UtimesOf(result.scans) == Utimes{10500000});
    CHECK(result.counts.at("bad_line") == 1);
  }
}

TEST_CASE("a last line cut short anywhere costs itself at most, and never brings a wrong scan") {
  const std::string second = Flaser(3, " 7.25 8.5 9.75", "20.5");
  for (std::size_t cut = 0; cut < second.size(); ++cut) {
    CAPTURE(cut);
    Result result = Read(kGood + second.substr(0, cut));
    const bool has_logger_time = cut > second.find("7.5\n");  // the last field; it is not used
    CHECK(UtimesOf(result.scans) == (has_logger_time ? Utimes{10500000, 20500000} : Utimes{10500000}));
    CHECK(result.counts["bad_line"] == (!has_logger_time && cut >= 6 ? 1 : 0));
  }
}

TEST_CASE("progress rises from 0 to 1, and an empty log has no scans") {
  CHECK(Read("").scans.empty());
  std::string text;
  for (int i = 0; i < 100; ++i) text += ScanAt(std::to_string(i));
  const ScratchFile file(text);
  CarmenLog log(file.path());
  CHECK(log.Progress() == 0.0);
  for (int i = 0; i < 50; ++i) log.Next();
  CHECK(log.Progress() == Approx(0.5).margin(0.02));  // the first ten lines are a byte shorter than the others
}

TEST_CASE("the real CARMEN logs have the scans that their description says", "[logs]") {
  struct RealCarmenLog {
    std::string name;
    std::size_t num_scans;
    std::size_t num_beams;
  };
  for (const RealCarmenLog& real : {RealCarmenLog{"radish/intel.clf.gz", 13631, 180},
                                    {"radish/fr079.clf.gz", 4934, 360},
                                    {"radish/aces.clf.gz", 7374, 180},
                                    {"urg04lx/exp1.clf.gz", 756, 683},
                                    {"urg04lx/exp3.clf.gz", 525, 683}}) {
    const auto path = FindRealLog(real.name);
    if (!path) continue;
    CAPTURE(real.name);
    CarmenLog log(*path);
    const auto scans = ReadAll(log);
    CHECK(scans.size() == real.num_scans);
    std::int64_t num_back = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      REQUIRE(scans[i].ranges_m.size() == real.num_beams);
      num_back += i > 0 && scans[i].utime < scans[i - 1].utime ? 1 : 0;
    }
    CHECK(num_back == (real.name == "radish/intel.clf.gz" ? 631 : 0));
    CHECK(log.Counts().empty());
  }
}

}  // namespace crsm
