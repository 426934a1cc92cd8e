#include "common/diagnosis/range_study.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "catch.hpp"
#include "common/logs/carmen_log.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/valid_rays.hpp"
#include "real_logs.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

/// A drive through a hall of a laser that reaches 6 m, and says `no_return()` where it sees nothing.
std::vector<LaserScan> Drive(const std::function<float()>& no_return) {
  std::vector<LaserScan> scans = ScansOf(LoadWorld("hall"), 1, 200);
  for (LaserScan& scan : scans) {
    for (float& range_m : scan.ranges_m) {
      if (range_m <= 0.0f || range_m > 6.0f) range_m = no_return();
    }
  }
  return scans;
}

std::vector<LaserScan> Drive(float no_return_m) {
  return Drive([no_return_m] { return no_return_m; });
}

constexpr float kDegree = static_cast<float>(kPi) / 180.0f;

/// A laser with a view of 60 degrees turns on the spot: at the end of a corridor, 8 m away, it sees a wall of so many
/// degrees, and nearer things beside it.
std::vector<LaserScan> TurnBeforeWall(int wall_deg) {
  std::vector<LaserScan> scans;
  for (int k = 0; k < 30; ++k) {
    LaserScan scan{1'000'000 + 100'000 * k, -30.0f * kDegree, kDegree, std::vector<float>(60)};
    for (int beam = 0; beam < 60; ++beam) {
      const int from_wall_deg = std::max({0, k - beam, beam - (k + wall_deg - 1)});
      scan.ranges_m[static_cast<std::size_t>(beam)] = 8.0f - 0.1f * static_cast<float>(from_wall_deg);
    }
    scans.push_back(std::move(scan));
  }
  return scans;
}

}  // namespace

TEST_CASE("a range that many beams have exactly, and none exceeds, is no return") {
  for (const float no_return_m : {8.19f, 81.83f}) {
    const RangeFinding finding = StudyRanges(Drive(no_return_m), {});
    REQUIRE(finding.no_return_m);
    CHECK(*finding.no_return_m == no_return_m);
    CHECK(finding.no_return_share > 0.05);
    CHECK(finding.reach_m == Approx(6.0).margin(0.1));
    ScanParameters corrected;
    corrected.range_max_m = finding.RangeMax();
    CHECK(LargestUsableRange(corrected) < no_return_m);
    CHECK(LargestUsableRange(corrected) > 0.999 * no_return_m);
  }
}

TEST_CASE("ranges within a thousandth of the largest that many beams have are no return, whatever their digits") {
  std::minstd_rand random(1);
  const std::vector<float> codes_m{8.183f, 8.183001f, 8.187f, 8.191f};
  const auto Code = [&] { return codes_m[random() % codes_m.size()]; };
  const auto Between = [&] { return std::uniform_real_distribution<float>(8.183f, 8.191f)(random); };
  const auto InCentimetres = [&] { return 10.0f * Code(); };
  for (const std::function<float()>& no_return : std::vector<std::function<float()>>{Code, Between, InCentimetres}) {
    const std::vector<LaserScan> scans = Drive(no_return);
    float least_m = 100.0f;
    for (const LaserScan& scan : scans) {
      for (const float range_m : scan.ranges_m) {
        if (range_m > 7.0f) least_m = std::min(least_m, range_m);
      }
    }
    const RangeFinding finding = StudyRanges(scans, {});
    REQUIRE(finding.no_return_m);
    CHECK(*finding.no_return_m == least_m);
    CHECK(finding.no_return_share > 0.05);
    CHECK(finding.reach_m == Approx(6.0).margin(0.1));
    CHECK(finding.beyond_share == 0.0);
    ScanParameters corrected;
    corrected.range_max_m = finding.RangeMax();
    CHECK(LargestUsableRange(corrected) < least_m);
  }
  const auto Wider = [&] { return std::uniform_real_distribution<float>(8.12f, 8.2f)(random); };
  CHECK_FALSE(StudyRanges(Drive(Wider), {}).no_return_m);
  CHECK(StudyRanges(Drive(Wider), {}, {.pile_share = 0.01}).no_return_m);
}

TEST_CASE("a wall that fills no more of the view than one within a thousandth of its distance can is hit") {
  CHECK_FALSE(StudyRanges(TurnBeforeWall(5), {}).no_return_m);  // 8 % of the beams, and each at some time
  const RangeFinding finding = StudyRanges(TurnBeforeWall(6), {});
  REQUIRE(finding.no_return_m);
  CHECK(*finding.no_return_m == 8.0f);
}

TEST_CASE("in a real log the values of a SICK that measured nothing are no return", "[logs]") {
  const auto path = FindRealLog("beyond/no_return_jitters.clf.gz");
  if (!path) return;
  CarmenLog log(*path);
  const RangeFinding finding = StudyRanges(ReadAll(log), {});
  REQUIRE(finding.no_return_m);
  CHECK(*finding.no_return_m == 8.183f);
  CHECK(finding.no_return_is_hit);
}

TEST_CASE("zero is no return without a word; a wall ahead of a robot that stands is none") {
  const std::vector<LaserScan> scans = Drive(0.0f);
  CHECK_FALSE(StudyRanges(scans, {}).no_return_m);
  std::vector<LaserScan> standing(50, scans.front());
  for (LaserScan& scan : standing) {
    for (std::size_t beam = 0; beam < scan.ranges_m.size() / 10; ++beam) scan.ranges_m[beam] = 7.5f;
  }
  CHECK_FALSE(StudyRanges(standing, {}).no_return_m);
  CHECK_FALSE(StudyRanges({}, {}).no_return_m);
}

TEST_CASE("what a few beams say where they measured nothing is no hit, though too few to be sure what it means") {
  std::vector<LaserScan> scans = Drive(0.0f);
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i].ranges_m[7 * i % scans[i].ranges_m.size()] = 50.0f;
  const RangeFinding finding = StudyRanges(scans, {});
  CHECK_FALSE(finding.no_return_m);
  CHECK(finding.reach_m == Approx(6.0).margin(0.1));
  DiagnosisConstants::RangeStudy constants;
  constants.pile_beams = 1000;
  CHECK(StudyRanges(scans, {}, constants).reach_m == 50.0);
  constants = {};
  constants.pile_m = 100.0;  // nothing is left below it
  CHECK(StudyRanges(scans, {}, constants).reach_m == 50.0);
  std::vector<LaserScan> all_alike(20, scans.front());
  for (LaserScan& scan : all_alike) std::ranges::fill(scan.ranges_m, 4.0f);
  CHECK(FindReach(all_alike, std::nullopt) == 4.0);
  CHECK(FindReach({}, std::nullopt) == 0.0);
}

TEST_CASE("how many beams of a scan measure anything is counted") {
  std::vector<LaserScan> scans = Drive(0.0f);
  scans.resize(9);
  for (LaserScan& scan : scans) {
    std::ranges::fill(scan.ranges_m, std::numeric_limits<float>::infinity());
    for (std::size_t beam = 0; beam < 25; ++beam) scan.ranges_m[beam] = 2.0f + 0.01f * static_cast<float>(beam);
  }
  std::ranges::fill(scans.front().ranges_m, 2.0f);  // one is another
  CHECK(StudyRanges(scans, {}).hits_a_scan == 25.0);
}

TEST_CASE("hits beyond what the parameters take for one are counted") {
  ScanParameters parameters;
  CHECK(StudyRanges(Drive(0.0f), parameters).beyond_share == 0.0);
  parameters.range_max_m = 3.0;
  CHECK(StudyRanges(Drive(0.0f), parameters).beyond_share > 0.2);
}

}  // namespace crsm
