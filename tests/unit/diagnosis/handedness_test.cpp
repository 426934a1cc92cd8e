#include "common/diagnosis/handedness.hpp"

#include <limits>

#include "catch.hpp"
#include "common/logs/carmen_log.hpp"
#include "real_logs.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

using Verdict = HandednessJudge::Verdict;

/// A room with a box in it, of which no two sides are alike.
std::vector<Wall> Room() {
  return ParseWorld(
             "box -3 -2 7 4.5\nbox 1 0.5 1.5 0.8\nwall -3 0 -1.5 0\n"
             "waypoint 0 -1\nwaypoint 0.5 -1\nspeed 1 1\nlaser 360 360 10 10 0\n",
             "room")
      .walls;
}

struct Motion {
  double turn_rad = 0.15;  ///< from a scan to the next
  int num_scans = 30;
  int every = 1;           ///< of the scans, one in so many has a heading
  double told_sign = 1.0;  ///< of the headings
};

template <class Change>
Verdict Judge(const Motion& motion, Change change) {
  HandednessJudge judge;
  for (int k = 0; k < motion.num_scans; ++k) {
    const double yaw_rad = WrapAngle(3.0 + k * motion.turn_rad);
    const std::int64_t utime = 1'000'000 + 100'000 * k;
    judge.Add(change(ScanWalls(Room(), {0.01 * k, -1.0, yaw_rad}, utime)));
    if (k % motion.every == 0) judge.Add(Odometry{utime, Pose2{0.0, 0.0, WrapAngle(7.0 + motion.told_sign * yaw_rad)}});
  }
  return judge.verdict();
}

Verdict Judge(const Motion& motion) {
  return Judge(motion, [](const LaserScan& scan) { return scan; });
}

}  // namespace

TEST_CASE("scans that turn as their headings do are right, those that turn against them are mirrored") {
  for (const double turn_rad : {0.15, -0.15, 0.03, 0.5}) {
    CAPTURE(turn_rad);
    const Motion motion{.turn_rad = turn_rad, .num_scans = 90};
    const Motion told_wrongly{.turn_rad = turn_rad, .num_scans = 90, .told_sign = -1.0};
    CHECK(Judge(motion) == Verdict::kRight);
    CHECK(Judge(motion, Mirror) == Verdict::kMirrored);
    CHECK(Judge(told_wrongly) == Verdict::kMirrored);
    CHECK(Judge(told_wrongly, Mirror) == Verdict::kRight);
  }
}

TEST_CASE(
    "nothing is known of a robot that stands, of few scans, without headings, or where none or all ranges are alike") {
  CHECK(Judge({.turn_rad = 0.0}) == Verdict::kUnknown);
  CHECK(Judge({.turn_rad = 0.005, .num_scans = 300}) == Verdict::kUnknown);  // 0.05 rad in the ten scans of a pair
  CHECK(Judge({.num_scans = 10}) == Verdict::kUnknown);                      // nine pairs
  CHECK(Judge({.num_scans = 20}) == Verdict::kRight);
  CHECK(Judge({.every = 1000}) == Verdict::kUnknown);
  CHECK(Judge({}, [](LaserScan scan) {
          scan.ranges_m.assign(scan.ranges_m.size(), std::numeric_limits<float>::quiet_NaN());
          return scan;
        }) == Verdict::kUnknown);
  CHECK(Judge({}, [](LaserScan scan) {  // all looks alike
          scan.ranges_m.assign(scan.ranges_m.size(), 2.0f);
          return scan;
        }) == Verdict::kUnknown);
}

TEST_CASE("two turns of ten may go against the others, three leave it open") {
  const auto JudgeTurns = [](int num_against, int others_one_in = 5) {
    DiagnosisConstants::Handedness constants;
    constants.others_one_in = others_one_in;
    HandednessJudge judge(constants);
    double told_rad = 0.0;
    for (int k = 0; k <= 10; ++k) {
      constexpr double kTurn_rad = 0.15;
      const std::int64_t utime = 1'000'000 + 100'000 * k;
      if (k > 0) told_rad += k <= num_against ? -kTurn_rad : kTurn_rad;
      judge.Add(ScanWalls(Room(), {0.01 * k, -1.0, k * kTurn_rad}, utime));
      judge.Add(Odometry{utime, Pose2{0.0, 0.0, told_rad}});
    }
    return judge.verdict();
  };
  CHECK(JudgeTurns(2) == Verdict::kRight);
  CHECK(JudgeTurns(3) == Verdict::kUnknown);
  CHECK(JudgeTurns(7) == Verdict::kUnknown);
  CHECK(JudgeTurns(8) == Verdict::kMirrored);
  CHECK(JudgeTurns(2, 6) == Verdict::kUnknown);
  CHECK(JudgeTurns(3, 3) == Verdict::kRight);
}

TEST_CASE("a scan between two headings is judged by both; one far from any by none") {
  CHECK(Judge({.num_scans = 60, .every = 2}, Mirror) == Verdict::kMirrored);
  CHECK(Judge({.turn_rad = 0.5, .num_scans = 60, .every = 5}, Mirror) == Verdict::kUnknown);  // turns too wide to tell
}

TEST_CASE("real scans turn as the odometry of their robots does, from wherever one begins to listen", "[logs]") {
  for (const std::string name : {"intel", "fr079", "aces", "killian"}) {
    const auto path = FindRealLog("radish/" + name + ".clf.gz");
    if (!path) return;
    CAPTURE(name);
    CarmenLog log(*path);
    HandednessJudge judge;
    int num_right = 0;
    for (auto scan = log.Next(); scan; scan = log.Next()) {
      judge.Add(*scan);
      judge.Add(Odometry{scan->utime, log.Odometry()});
      if (judge.verdict() == Verdict::kUnknown) continue;
      REQUIRE(judge.verdict() == Verdict::kRight);
      ++num_right;
      judge = HandednessJudge();
    }
    CHECK(num_right >= 20);
  }
}

}  // namespace crsm
