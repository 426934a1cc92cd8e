#include "common/diagnosis/sweep_study.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

constexpr double kSweep_s = 0.15;  // of the arena's laser, whose scans are as far apart

/// A world with a laser that takes 0.2 s for a scan, and a robot that turns too fast for that.
World TurnFastIn(const std::string& name) {
  World world = LoadWorld(name);
  world.laser = {.fov_rad = 2.0 * kPi, .beams = 360, .range_max_m = 12.0, .rate_hz = 5.0, .noise_m = 0.02};
  world.laser.sweep_s = 0.2;
  world.linear_m_s = 0.3;
  world.angular_rad_s = 1.7;
  return world;
}

/// The same world in a mirror, seen by a laser that turns clockwise, with its beams in the order of their angles.
std::vector<LaserScan> ReverseBeams(std::vector<LaserScan> scans) {
  for (LaserScan& scan : scans) {
    scan.angle_min_rad = -scan.angle_min_rad - static_cast<float>(scan.ranges_m.size() - 1) * scan.angle_step_rad;
    std::ranges::reverse(scan.ranges_m);
  }
  return scans;
}

/// A drive whose robot turns by 3 rad/s.
std::vector<LaserScan> DriveArena() { return ScansOf(LoadWorld("arena")); }

/// The same with times. time_of: by the messages, of a beam behind that share of a sweep [s].
template <class TimeOf>
std::vector<LaserScan> DriveArena(TimeOf&& time_of) {
  std::vector<LaserScan> scans = DriveArena();
  for (LaserScan& scan : scans) {
    const auto num_beams = static_cast<double>(scan.ranges_m.size());
    for (double beam = 0.0; beam < num_beams; ++beam) {
      scan.times_s.push_back(static_cast<float>(time_of(beam / (num_beams - 1.0))));
    }
  }
  return scans;
}

SweepFinding Study(const std::vector<LaserScan>& scans, const DiagnosisConstants::SweepStudy& constants = {}) {
  Parameters parameters;
  parameters.scan.range_max_m = 12.0;
  return *StudySweep(scans, parameters, constants);
}

}  // namespace

TEST_CASE("a sweep that is said rightly stays; of beams in the other order it is told while the robot turns") {
  const SweepFinding right = Study(DriveArena([](double share) { return kSweep_s * (share - 1.0); }));
  CHECK(right.agrees());
  CHECK(right.can_be);
  CHECK(right.said_s == Approx(kSweep_s));
  const SweepFinding wrong = Study(DriveArena([](double share) { return -kSweep_s * share; }));
  CHECK_FALSE(wrong.agrees());
  CHECK(wrong.said_s == Approx(-kSweep_s));
  CHECK(wrong.sweep_s == Approx(kSweep_s));
}

TEST_CASE("times a thousand times too short, or longer than a turn of the laser, are not believed") {
  for (const double factor : {0.001, 3.0}) {
    const SweepFinding finding = Study(DriveArena([&](double share) { return factor * kSweep_s * (share - 1.0); }));
    CHECK_FALSE(finding.can_be);
    CHECK(finding.said_s == Approx(factor * kSweep_s));
    CHECK(finding.sweep_s == Approx(kSweep_s).margin(0.01));
  }
}

TEST_CASE("a laser that turns is known by its scans where nothing is said, also if some of them are missing") {
  std::vector<LaserScan> scans = DriveArena();
  CHECK(Study(scans).said_s == 0.0);
  CHECK(Study(scans).sweep_s == Approx(kSweep_s).margin(0.002));
  for (std::size_t i = scans.size(); i-- > 0;) {
    if (i % 5 == 0) scans.erase(scans.begin() + static_cast<std::ptrdiff_t>(i));
  }
  CHECK(Study(scans).sweep_s == Approx(kSweep_s).margin(0.002));
}

TEST_CASE("what is found of a laser goes by nobody's cells, and by no profile") {
  Parameters coarse;
  coarse.scan.range_max_m = 12.0;
  coarse.update.cell_size_m = 0.5;
  coarse.update.algorithm = Algorithm::kPaper;
  CHECK(StudySweep(DriveArena(), coarse)->sweep_s == Approx(kSweep_s).margin(0.002));
}

TEST_CASE("of a laser that turns clockwise the last beam is the first one, unless its angles fall") {
  std::vector<LaserScan> scans = DriveArena();
  for (LaserScan& scan : scans) scan = Mirror(std::move(scan));
  CHECK(Study(scans).sweep_s == Approx(kSweep_s).margin(0.002));
  CHECK(Study(ReverseBeams(DriveArena())).sweep_s == Approx(-kSweep_s).margin(0.002));
}

TEST_CASE("a laser that sees a part of its turn takes that share of the period for a scan") {
  World world = LoadWorld("arena");
  world.laser.fov_rad = 1.5 * kPi;
  world.laser.sweep_s = 0.75 * kSweep_s;
  CHECK(Study(ScansOf(world)).sweep_s == Approx(0.75 * kSweep_s).margin(0.002));
}

TEST_CASE("a laser whose beams are measured at once has no sweep, whatever is likely") {
  World world = LoadWorld("arena");
  world.laser.sweep_s = 0.0;
  DiagnosisConstants::SweepStudy constants;
  constants.enough_turning = 30;  // to save time
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CHECK(Study(ScansOf(world, seed), constants).sweep_s == 0.0);
  }
}

TEST_CASE("scans that are lost where a sweep is not corrected tell of it as those do that turn") {
  DiagnosisConstants::SweepStudy constants;
  constants.num_scans = 1000;
  constants.few_turning = 70;  // 102 tell of it, 47 of which are lost
  CHECK(Study(ScansOf(TurnFastIn("rooms")), constants).sweep_s == Approx(0.2).margin(0.002));
}

TEST_CASE("where two opposite sweeps are both better than none, but not clearly apart, neither is taken") {
  World world = TurnFastIn("env1");
  world.linear_m_s = 0.5;
  world.angular_rad_s = 2.0;
  CHECK(Study(ScansOf(world)).sweep_s == 0.0);
  CHECK(Study(ReverseBeams(ScansOf(world))).sweep_s == 0.0);
}

TEST_CASE("a sweep that could be, but is a third of what it is said to be, is corrected") {
  const SweepFinding finding = Study(DriveArena([](double share) { return kSweep_s / 3.0 * (share - 1.0); }));
  CHECK(finding.can_be);
  CHECK(finding.sweep_s == Approx(kSweep_s).margin(0.002));
}

TEST_CASE("scans that are too rare for a laser that turns, or see half a turn, are not studied") {
  std::vector<LaserScan> scans = DriveArena();
  for (LaserScan& scan : scans) scan.utime *= 10;
  CHECK_FALSE(StudySweep(scans, Parameters{}));
  World world = LoadWorld("arena");
  world.laser.fov_rad = kPi;
  CHECK_FALSE(StudySweep(ScansOf(world), Parameters{}));
}

TEST_CASE("of a robot that does not turn, what the messages say stays, also if they say nothing") {
  std::vector<LaserScan> scans = DriveArena([](double share) { return -kSweep_s * share; });
  scans.resize(20);
  for (LaserScan& scan : scans) scan.ranges_m = scans.front().ranges_m;  // it stands
  CHECK(Study(scans).agrees());
  for (LaserScan& scan : scans) scan.times_s.clear();
  CHECK(Study(scans).agrees());
  Parameters preset;
  preset.scan.sweep_s = 0.1;
  CHECK(StudySweep(scans, preset)->said_s == 0.1);
}

}  // namespace crsm
