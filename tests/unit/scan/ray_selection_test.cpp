#include "common/scan/ray_selection.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "common/scan/paper_selection.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// 270 rays over 270 degrees: near and far pieces of wall by turns, with five jumps of about 3 m between them.
ValidRays HandMadeRays() {
  ValidRays rays;
  for (int i = 0; i < 270; ++i) {
    rays.angle_rad.push_back(static_cast<float>((i - 135) * kPi / 180.0));
    rays.range_m.push_back((i / 45) % 2 == 0 ? 2.0f + 0.003f * static_cast<float>(i)
                                             : 5.0f + 0.01f * static_cast<float>(i % 45));
  }
  return rays;
}

ValidRays RoomRays(int num_beams) {
  return FindValidRays(ScanRoom({0.3, -0.2, 0.1}, 1, num_beams), TestParameters().scan);
}

/// All ranges are alike: no edges.
ValidRays RoundRays(int num_beams) {
  ValidRays rays;
  for (int i = 0; i < num_beams; ++i) {
    rays.angle_rad.push_back(static_cast<float>((1.5 * i / num_beams - 0.75) * kPi));
    rays.range_m.push_back(3.0f);
  }
  return rays;
}

double DistanceBetween(const ValidRays& rays, std::size_t i, std::size_t j) {
  return std::hypot(rays.range_m[i] * std::cos(rays.angle_rad[i]) - rays.range_m[j] * std::cos(rays.angle_rad[j]),
                    rays.range_m[i] * std::sin(rays.angle_rad[i]) - rays.range_m[j] * std::sin(rays.angle_rad[j]));
}

/// Section 4.3 word by word: edges, Eq. 5, lines 1 to 11 with line 4 as the text around it derives it.
std::vector<int> SelectSegmentsLiterally(const ValidRays& rays, double P) {
  const PaperSelectionConstants constants;
  const int num_rays = static_cast<int>(rays.size());
  std::vector<double> rays_displacement;
  for (std::size_t i = 0; i + 1 < rays.size(); ++i) rays_displacement.push_back(DistanceBetween(rays, i, i + 1));
  double max = 0.0;
  for (const float range_m : rays.range_m) max = std::max<double>(max, range_m);

  std::set<int> feature_edges{0, num_rays - 1};
  for (int i = 0; i + 1 < num_rays; ++i) {
    if (rays_displacement[static_cast<std::size_t>(i)] > constants.edge_threshold_m) feature_edges.insert({i, i + 1});
  }
  std::set<int> picked = feature_edges;
  for (auto edge = feature_edges.begin(); std::next(edge) != feature_edges.end(); ++edge) {
    const int start = *edge;
    const int end = *std::next(edge);
    if (end == start + 1) continue;
    double spar = 0.0;
    for (int j = start; j < end; ++j) spar += rays_displacement[static_cast<std::size_t>(j)] / (end - start);
    double local_d = 0.0;
    for (int i = start; i < end; ++i) {
      const auto ray = static_cast<std::size_t>(i);
      local_d += rays_displacement[ray];
      if (local_d >= P * spar / std::exp(rays.range_m[ray] / std::sqrt(max))) {
        picked.insert(i);
        local_d = 0.0;
      }
    }
  }
  for (bool gap_left = true; gap_left;) {
    gap_left = false;
    for (auto i = picked.begin(); std::next(i) != picked.end(); ++i) {
      if (*std::next(i) - *i <= constants.gap_threshold_rays) continue;
      gap_left = true;
      picked.insert((*i + *std::next(i)) / 2);
    }
  }
  return {picked.begin(), picked.end()};
}

void CheckIndices(const std::vector<int>& picked, std::size_t num_rays) {
  CHECK(std::adjacent_find(picked.begin(), picked.end(), std::greater_equal<>()) == picked.end());
  if (!picked.empty()) CHECK(picked.front() >= 0);
  if (!picked.empty()) CHECK(picked.back() < static_cast<int>(num_rays));
}

}  // namespace

TEST_CASE("any number of rays gives rising indices, and few rays are all picked") {
  for (const int num_rays : {0, 1, 2, 12, 4096}) {
    const ValidRays rays = RoomRays(num_rays);
    CAPTURE(num_rays);
    for (const auto& picked : {SelectRays(rays, 90), PaperSelection()(rays)}) {
      CheckIndices(picked, rays.size());
      CHECK(std::cmp_greater_equal(picked.size(), std::min(num_rays, 12)));
    }
  }
}

TEST_CASE("the paper's selection picks what its pseudo-code picks, with a P that follows the scans before") {
  for (const ValidRays& rays : {HandMadeRays(), RoomRays(270), RoomRays(360), RoomRays(2)}) {
    PaperSelection select;
    double P = 100.0;
    for (int scan = 0; scan < 100; ++scan) {
      const std::vector<int> expected = SelectSegmentsLiterally(rays, P);
      CAPTURE(rays.size(), scan, P);
      REQUIRE(select(rays) == expected);
      if (expected.size() > 50) P *= 1.1;
      if (expected.size() < 30) P /= 1.1;
      P = std::max(P, 1e-3);
    }
    if (rays.size() > 100) CHECK(select(rays).size() <= 50);
    if (rays.size() > 100) CHECK(select(rays).size() >= 30);
  }
}

TEST_CASE("P never runs away") {
  PaperSelection select;
  for (int scan = 0; scan < 10000; ++scan) select(RoomRays(2));  // too few rays
  CHECK(select(RoomRays(360)).size() == 360);
  for (int scan = 0; scan < 1000; ++scan) select(RoomRays(360));
  CHECK(select(RoomRays(360)).size() <= 50);
}

TEST_CASE("both sides of every jump are critical") {
  const auto picked = SelectRays(HandMadeRays(), 50);
  for (const int jump : {44, 89, 134, 179, 224}) {
    CHECK(std::count(picked.begin(), picked.end(), jump) == 1);
    CHECK(std::count(picked.begin(), picked.end(), jump + 1) == 1);
  }
}

TEST_CASE("from two thirds of the most rays to the most are picked, of few beams and of many") {
  for (const int num_beams : {90, 180, 360, 683, 726, 900, 1081, 2000, 4096}) {
    for (const ValidRays& rays : {HandMadeRays(), RoomRays(num_beams), RoundRays(num_beams)}) {
      CAPTURE(num_beams);
      const std::size_t num = SelectRays(rays, 90).size();
      CHECK(num >= 60);
      CHECK(num <= 90);
    }
  }
}

TEST_CASE("a scan that is all jumps leaves no more rays than are wanted") {
  Random random(5);
  ValidRays rays = RoomRays(360);
  for (float& range_m : rays.range_m) range_m = static_cast<float>(random.Uniform(1.0, 9.0));
  CHECK(PaperSelection()(rays).size() > 300);
  const auto picked = SelectRays(rays, 60);
  CHECK(picked.size() >= 40);
  CHECK(picked.size() <= 60);
}

TEST_CASE("gaps get no wider than it takes") {
  const auto WidestGap = [&](int num_beams) {
    const std::vector<int> picked = SelectRays(RoundRays(num_beams), 90);
    int widest = 0;
    for (std::size_t i = 0; i + 1 < picked.size(); ++i) widest = std::max(widest, picked[i + 1] - picked[i]);
    return widest;
  };
  CHECK(WidestGap(641) <= 10);   // 640 halved six times is 10, of which there are 64
  CHECK(WidestGap(1081) <= 17);  // 1,080 halved six times is 17, of which there are 64; halved once more, 128 of 9
  CHECK(WidestGap(1081) > 10);
}

TEST_CASE("rays that all end in one place are selected without harm") {
  const ValidRays rays{std::vector<float>(500, 0.25f), std::vector<float>(500, 2.0f)};
  CheckIndices(SelectRays(rays, 90), rays.size());
  CheckIndices(PaperSelection()(rays), rays.size());
}

}  // namespace crsm
