#include "common/diagnosis/sweep_study.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "common/worlds/simulator.hpp"

namespace crsm {
namespace {

constexpr double kSweep_s = 0.15;  // of the arena's laser, whose scans are as far apart

/// A drive whose robot turns by 3 rad/s. time_of: by the messages, of a beam behind that share of a sweep [s].
template <class TimeOf>
std::vector<LaserScan> DriveArena(TimeOf&& time_of) {
  Simulator simulator(LoadWorld("arena"), 1);
  std::vector<LaserScan> scans;
  while (auto scan = simulator.Next()) {
    const auto num_beams = static_cast<double>(scan->ranges_m.size());
    for (double beam = 0.0; beam < num_beams; ++beam) {
      scan->times_s.push_back(static_cast<float>(time_of(beam / (num_beams - 1.0))));
    }
    scans.push_back(std::move(*scan));
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
  CHECK(right.num_turning > 12);
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

TEST_CASE("of a robot that does not turn, what the messages say stays; without times there is nothing to study") {
  std::vector<LaserScan> scans = DriveArena([](double share) { return -kSweep_s * share; });
  scans.resize(20);
  for (LaserScan& scan : scans) scan.ranges_m = scans.front().ranges_m;  // it stands
  CHECK(Study(scans).agrees());
  for (LaserScan& scan : scans) scan.times_s.clear();
  CHECK_FALSE(StudySweep(scans, Parameters{}));
  Parameters preset;
  preset.scan.sweep_s = 0.1;
  CHECK(StudySweep(scans, preset)->said_s == 0.1);
}

TEST_CASE("a sweep is studied by the constants that are given") {
  using Constants = DiagnosisConstants::SweepStudy;
  const std::vector<LaserScan> scans = DriveArena([](double share) { return -kSweep_s * share; });
  const auto StudyBy = [&](void (*change)(Constants&)) {
    Constants constants;
    change(constants);
    return Study(scans, constants);
  };
  CHECK(StudyBy([](Constants& c) { c.num_scans = 5; }).num_turning < 5);
  CHECK(StudyBy([](Constants& c) { c.turning_rad = 9.0; }).num_turning == 0);
  CHECK(StudyBy([](Constants& c) { c.enough_turning = 20; }).num_turning == 20);
  CHECK(StudyBy([](Constants& c) { c.few_turning = 10'000; }).agrees());
  CHECK(StudyBy([](Constants& c) { c.better_fitness_min = 1.0; }).agrees());
  CHECK(StudyBy([](Constants& c) { c.better_sigmas = 1e6; }).agrees());
  CHECK_FALSE(StudyBy([](Constants& c) { c.longest_share = 0.1; }).can_be);
  CHECK_FALSE(StudyBy([](Constants& c) { c.shortest_share = 2.0; }).can_be);
  CHECK(StudyBy([](Constants& c) { c.longest_share = c.longest_period_s = 0.1; }).sweep_s == 0.0);
}

}  // namespace crsm
