#include "common/scan/ray_selection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

SelectionParameters TestSelection(SelectionMethod method) {
  SelectionParameters parameters = TestParameters().selection;
  parameters.method = method;
  parameters.gap_threshold_rays = 25;
  parameters.rays_min = 30;
  parameters.rays_max = 50;
  parameters.limit_edges = false;
  return parameters;
}

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
std::vector<int> SelectSegmentsLiterally(const ValidRays& rays, const SelectionParameters& parameters, double P) {
  const int num_rays = static_cast<int>(rays.size());
  std::vector<double> rays_displacement;
  for (std::size_t i = 0; i + 1 < rays.size(); ++i) rays_displacement.push_back(DistanceBetween(rays, i, i + 1));
  double max = 0.0;
  for (const float range_m : rays.range_m) max = std::max<double>(max, range_m);

  std::set<int> feature_edges{0, num_rays - 1};
  for (int i = 0; i + 1 < num_rays; ++i) {
    if (rays_displacement[static_cast<std::size_t>(i)] > parameters.edge_threshold_m) feature_edges.insert({i, i + 1});
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
      if (*std::next(i) - *i <= parameters.gap_threshold_rays) continue;
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

TEST_CASE("every method takes 0, 1, 2 and 4096 rays and gives rising indices") {
  for (const auto method :
       {SelectionMethod::kAll, SelectionMethod::kUniform, SelectionMethod::kDensity, SelectionMethod::kSegments}) {
    for (const int num_rays : {0, 1, 2, 4096}) {
      const ValidRays rays = RoomRays(num_rays);
      const auto picked = SelectRays(rays, TestSelection(method)).critical;
      CAPTURE(static_cast<int>(method), num_rays);
      CheckIndices(picked, rays.size());
      if (num_rays > 0) CHECK_FALSE(picked.empty());
    }
  }
}

TEST_CASE("the method all picks every ray") {
  std::vector<int> expected(360);
  std::iota(expected.begin(), expected.end(), 0);
  CHECK(SelectRays(RoomRays(360), TestSelection(SelectionMethod::kAll)).critical == expected);
}

TEST_CASE("the uniform method picks every n-th ray") {
  SelectionParameters parameters = TestSelection(SelectionMethod::kUniform);
  parameters.uniform_step = 7;
  CHECK(SelectRays(RoomRays(30), parameters).critical == std::vector<int>{0, 7, 14, 21, 28});  // Eq. 1
  parameters.uniform_step = 4096;
  CHECK(SelectRays(RoomRays(30), parameters).critical == std::vector<int>{0});
}

TEST_CASE("the density method picks the first ray in each N-th of the contour") {
  for (const ValidRays& rays : {HandMadeRays(), RoomRays(683)}) {
    SelectionParameters parameters = TestSelection(SelectionMethod::kDensity);
    parameters.density_rays = 37;
    std::vector<double> way_m{0.0};
    for (std::size_t i = 0; i + 1 < rays.size(); ++i) way_m.push_back(way_m.back() + DistanceBetween(rays, i, i + 1));
    std::vector<int> expected;
    for (int i = 1; i <= 37; ++i) {  // Eq. 4
      const double low_m = way_m.back() / 37 * (i - 1);
      const double high_m = way_m.back() / 37 * i;
      const auto first =
          std::find_if(way_m.begin(), way_m.end() - 1, [&](double m) { return m >= low_m && m < high_m; });
      if (first != way_m.end() - 1) expected.push_back(static_cast<int>(first - way_m.begin()));
    }
    auto picked = SelectRays(rays, parameters).critical;
    // The last ray is at the end of the last N-th; rounding decides whether it is in.
    if (picked.back() == static_cast<int>(rays.size()) - 1) picked.pop_back();
    CHECK(picked == expected);
  }
}

TEST_CASE("the segments method picks what the paper's pseudo-code picks") {
  SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  parameters.density_scale_mode = DensityScaleMode::kPrevious;
  for (const ValidRays& rays : {HandMadeRays(), RoomRays(270), RoomRays(2)}) {
    for (const double P : {0.5, 5.0, 20.0, 100.0, 3000.0}) {
      const RaySelection selection = SelectRays(rays, parameters, P);
      CAPTURE(rays.size(), P);
      CHECK(selection.critical == SelectSegmentsLiterally(rays, parameters, P));
      CHECK(selection.density_scale == P);
    }
  }
}

TEST_CASE("both sides of every jump are critical") {
  const auto picked = SelectRays(HandMadeRays(), TestSelection(SelectionMethod::kSegments)).critical;
  for (const int jump : {44, 89, 134, 179, 224}) {
    CHECK(std::count(picked.begin(), picked.end(), jump) == 1);
    CHECK(std::count(picked.begin(), picked.end(), jump + 1) == 1);
  }
}

TEST_CASE("P is found so that 30 to 50 rays are picked") {
  const SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  for (const ValidRays& rays : {HandMadeRays(), RoomRays(60), RoomRays(180), RoomRays(360), RoomRays(726)}) {
    const RaySelection selection = SelectRays(rays, parameters);
    CAPTURE(rays.size(), selection.density_scale);
    CHECK(selection.critical.size() >= 30);
    CHECK(selection.critical.size() <= 50);
    CHECK(selection.critical == SelectSegmentsLiterally(rays, parameters, selection.density_scale));
  }
}

TEST_CASE("a scan with fewer rays than are wanted is picked whole") {
  CHECK(SelectRays(RoomRays(12), TestSelection(SelectionMethod::kSegments)).critical.size() == 12);
}

TEST_CASE("P rises after too many rays, falls after too few and stays in between") {
  const SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  CHECK(NextDensityScale(100.0, 51, parameters) > 100.0);
  CHECK(NextDensityScale(100.0, 50, parameters) == 100.0);
  CHECK(NextDensityScale(100.0, 30, parameters) == 100.0);
  CHECK(NextDensityScale(100.0, 29, parameters) < 100.0);
}

TEST_CASE("P that follows the previous scan settles in the band and never runs away") {
  SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  parameters.density_scale_mode = DensityScaleMode::kPrevious;
  double P = kFirstDensityScale;
  std::size_t num_picked = 0;
  for (int scan = 0; scan < 100; ++scan) {
    num_picked = SelectRays(RoomRays(360), parameters, P).critical.size();
    P = NextDensityScale(P, num_picked, parameters);
  }
  CHECK(num_picked >= 30);
  CHECK(num_picked <= 50);
  for (int scan = 0; scan < 10000; ++scan) P = NextDensityScale(P, 0, parameters);
  CHECK(P > 0.0);
  for (int scan = 0; scan < 10000; ++scan) P = NextDensityScale(P, 4096, parameters);
  CHECK(std::isfinite(P));
}

TEST_CASE("a scan that is all jumps leaves no more rays than are wanted where edges are limited") {
  Random random(5);
  ValidRays rays = RoomRays(360);
  for (float& range_m : rays.range_m) range_m = static_cast<float>(random.Uniform(1.0, 9.0));
  SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  CHECK(SelectRays(rays, parameters).critical.size() > 300);
  parameters.limit_edges = true;
  const auto picked = SelectRays(rays, parameters).critical;
  CHECK(picked.size() >= 30);
  CHECK(picked.size() <= 50);
}

TEST_CASE("a scan with so many rays that gaps alone would pick too many has wider gaps") {
  SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  parameters.gap_threshold_rays = 10;
  parameters.rays_min = 60;
  parameters.rays_max = 90;
  for (const bool limit_edges : {false, true}) {
    parameters.limit_edges = limit_edges;
    for (const int num_beams : {683, 900, 1081, 2000, 4096}) {
      CAPTURE(limit_edges, num_beams);
      for (const ValidRays& rays : {RoomRays(num_beams), RoundRays(num_beams)}) {
        const std::vector<int> picked = SelectRays(rays, parameters).critical;
        CHECK(picked.size() >= 60);
        CHECK(picked.size() <= 90);
      }
    }
  }
}

TEST_CASE("gaps get no wider than it takes, and stay as they are where that does not help") {
  SelectionParameters parameters = TestSelection(SelectionMethod::kSegments);
  parameters.gap_threshold_rays = 10;
  parameters.rays_min = 60;
  parameters.rays_max = 90;
  const auto WidestGap = [&](int num_beams) {
    const std::vector<int> picked = SelectRays(RoundRays(num_beams), parameters).critical;
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
  for (const auto method : {SelectionMethod::kDensity, SelectionMethod::kSegments}) {
    CheckIndices(SelectRays(rays, TestSelection(method)).critical, rays.size());
  }
}

}  // namespace crsm
