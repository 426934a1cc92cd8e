#include "common/metrics/path_sketch.hpp"

#include <cmath>

#include "catch.hpp"

namespace crsm {
namespace {

ScanMatch At(std::int64_t utime, double x_m, double y_m, MatchState state = MatchState::kOk) {
  ScanMatch match;
  match.utime = utime;
  match.T_map_laser = {x_m, y_m, 0.0};
  match.state = state;
  match.num_critical = 70;
  return match;
}

}  // namespace

TEST_CASE("a short path is sketched by all of its matches, in order") {
  PathSketch sketch;
  CHECK(sketch.Matches().empty());
  for (int i = 0; i < 1000; ++i) sketch.Add(At(i, 0.1 * i, 0.0));
  const auto matches = sketch.Matches();
  REQUIRE(matches.size() == 1000);
  for (std::size_t i = 0; i < matches.size(); ++i) CHECK(matches[i].utime == static_cast<std::int64_t>(i));
}

TEST_CASE("a robot that stands is sketched by where it came to stand and by its last matches") {
  PathSketch sketch;
  for (int i = 0; i < 100000; ++i) sketch.Add(At(i, 1.0, 2.0));
  const auto matches = sketch.Matches();
  CHECK(matches.size() <= 20);
  CHECK(matches.front().utime == 0);
  CHECK(matches.back().utime == 99999);
}

TEST_CASE("all scans are counted by what has become of them, however few are kept") {
  PathSketch sketch;
  sketch.Add(At(1, 0.0, 0.0, MatchState::kLost));
  ScanMatch afloat = At(2, 0.0, 0.0);
  afloat.floating = true;
  for (int i = 0; i < 100; ++i) sketch.Add(afloat);
  CHECK(sketch.counts() == ScanCounts{0, 100, 1, 0});
  CHECK(sketch.num_matches() == 101);
}

TEST_CASE("however long a path is, its sketch is small, goes near all of it, and has its lost scans") {
  constexpr int kCount = 300000;
  PathSketch sketch;
  const auto Place = [](int i) {  // a growing spiral of 15 km
    const double angle_rad = 2.0 * std::sqrt(static_cast<double>(i));
    return std::pair(0.025 * angle_rad * std::cos(angle_rad), 0.025 * angle_rad * std::sin(angle_rad));
  };
  for (int i = 0; i < kCount; ++i) {
    const auto [x_m, y_m] = Place(i);
    sketch.Add(At(i, x_m, y_m, i % 10 == 9 ? MatchState::kLost : MatchState::kOk));
  }
  const auto matches = sketch.Matches();
  CHECK(matches.size() <= 8192 + 16);
  CHECK(matches.size() >= 2048);
  CHECK(sketch.num_matches() == kCount);
  CHECK(sketch.counts().lost == kCount / 10);
  std::int64_t num_lost = 0;
  for (std::size_t i = 1; i < matches.size(); ++i) {
    CHECK(matches[i].utime > matches[i - 1].utime);
    num_lost += matches[i].state == MatchState::kLost;
    const auto& [a, b] = std::pair(matches[i - 1].T_map_laser, matches[i].T_map_laser);
    CHECK(std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < 7.5);  // of 2,048 parts of it
  }
  CHECK(num_lost > 100);
  CHECK(matches.back().utime == kCount - 1);
}

}  // namespace crsm
