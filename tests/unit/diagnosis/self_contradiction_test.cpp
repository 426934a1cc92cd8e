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

}  // namespace crsm
