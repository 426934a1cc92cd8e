#include "common/diagnosis/self_contradiction.hpp"

#include <algorithm>
#include <vector>

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// A walk to and fro in the niche; on the way back the poses are off by so much along x.
std::vector<PlacedRays> WalkToAndFro(double off_m, double path_per_scan_m = 0.5) {
  std::vector<PlacedRays> scans;
  for (int i = 0; i < 40; ++i) {
    const Pose2 truth{0.1 * (i < 20 ? i : 39 - i) - 1.0, 0.0, i < 20 ? 0.0 : 0.5};
    const Pose2 placed{truth.x_m + (i < 20 ? 0.0 : off_m), truth.y_m, truth.yaw_rad};
    scans.push_back({FindValidRays(ScanNiche(truth, i), {}), placed, path_per_scan_m * i});
  }
  return scans;
}

}  // namespace

TEST_CASE("scans of one place that are placed rightly do not contradict each other, misplaced ones do") {
  const SelfContradiction right = FindSelfContradiction(WalkToAndFro(0.0));
  CHECK(right.num_looks >= 10);
  CHECK(right.share == 0.0);
  CHECK(right.worst_share == 0.0);
  const SelfContradiction wrong = FindSelfContradiction(WalkToAndFro(0.8));
  CHECK(wrong.num_looks >= 10);
  CHECK(wrong.share > 0.2);
  CHECK(wrong.worst_share > 0.2);
}

TEST_CASE("the place where scans contradict each other most is one of the path, which need not be straight") {
  std::vector<PlacedRays> scans = WalkToAndFro(0.8);
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i].T_map_laser.y_m += i % 3 == 0 ? 0.1 : 0.0;
  const SelfContradiction wrong = FindSelfContradiction(scans);
  CHECK(wrong.worst_share > 0.2);
  const auto IsThere = [&](const PlacedRays& scan) {
    return scan.T_map_laser.x_m == wrong.worst_place.x_m && scan.T_map_laser.y_m == wrong.worst_place.y_m;
  };
  CHECK(std::ranges::any_of(scans, IsThere));  // on the path, and in the building
}

TEST_CASE("scans that are near along the path are not compared, nor is nothing") {
  CHECK(FindSelfContradiction(WalkToAndFro(0.8, 0.1)).num_looks == 0);
  CHECK(FindSelfContradiction({}).num_looks == 0);
  std::vector<PlacedRays> without_rays(50);
  for (int i = 0; i < 50; ++i) {
    without_rays[static_cast<std::size_t>(i)] = {{}, {0.5 * (i % 2), 0.0, 0.0}, 10.0 * i};
  }
  CHECK(FindSelfContradiction(without_rays).num_looks == 0);
}

TEST_CASE("contradictions are looked for by the constants that are given") {
  using Constants = DiagnosisConstants::SelfContradiction;
  const std::vector<PlacedRays> wrong = WalkToAndFro(0.8);
  const auto Find = [&](void (*change)(Constants&)) {
    Constants constants;
    change(constants);
    return FindSelfContradiction(wrong, constants);
  };
  const SelfContradiction usual = FindSelfContradiction(wrong);
  CHECK(Find([](Constants& c) { c.long_apart_m = 100.0; }).num_looks == 0);
  CHECK(Find([](Constants& c) { c.same_place_m = 0.1; }).num_looks < usual.num_looks);
  CHECK(Find([](Constants& c) { c.apart_m = 0.0; }).num_looks > usual.num_looks);
  CHECK(Find([](Constants& c) { c.most_pairs = 2; }).num_looks == 4);
  CHECK(Find([](Constants& c) { c.most_hits = 9; }).num_looks == 0);
  CHECK(Find([](Constants& c) { c.least_seen = 91; }).num_looks == 0);
  CHECK(Find([](Constants& c) { c.beam_gap = 0.5; }).num_looks == 0);
  CHECK(Find([](Constants& c) { c.nearest_m = 100.0; }).num_looks == 0);
  CHECK(Find([](Constants& c) { c.tolerance_m = 9.0; }).share == 0.0);
  CHECK(Find([](Constants& c) { c.tolerance_per_m = 9.0; }).share == 0.0);
  CHECK(Find([](Constants& c) { c.contradicting_share = 1.0; }).share == 0.0);
  CHECK(Find([](Constants& c) { c.square_looks_min = 10'000; }).worst_share == 0.0);
  CHECK(Find([](Constants& c) { c.square_m = 100.0; }).worst_share == usual.share);  // all in one
}

}  // namespace crsm
