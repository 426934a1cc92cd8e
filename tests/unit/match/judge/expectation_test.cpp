#include "common/match/judge/expectation.hpp"

#include <algorithm>

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

constexpr double kUsual = 0.8;  // fitness of the scans before

/// Half of the plane, x < 0, is explored.
ByteMap HalfExplored() {
  return PaintMap(-1, 0, [](Cell cell) { return cell.x < 0 ? kFreeByte : kUnexploredByte; });
}

/// Twenty hits, `num_explored` of them in the explored half.
Eigen::Matrix2Xd Hits(int num_explored) {
  Eigen::Matrix2Xd hits_m(2, 20);
  for (int i = 0; i < 20; ++i) hits_m.col(i) << (i < num_explored ? -1.0 : 1.0), 0.1 * i;
  return hits_m;
}

/// After scans that fitted as usual, and some that were lost.
TrackingState AfterLosing(int num_lost, bool on_finished_map = false) {
  std::vector<ScanMatch> matches{{0, {}, 0.0, 0, 0, 0, on_finished_map ? MatchState::kOk : MatchState::kFirst}};
  if (on_finished_map) matches.front().fitness = kUsual;
  for (int k = 1; k < 4; ++k) matches.push_back({k, {}, kUsual, 0, 0, 0, MatchState::kOk});
  for (int k = 0; k < num_lost; ++k) matches.push_back({4 + k, {}, 0.1, 0, 0, 0, MatchState::kLost});
  return After(matches);
}

/// The least fitness that explains a scan, to half a thousandth.
double LeastFitness(const TrackingState& tracking, int num_explored = 20, bool leniently = false) {
  const Expectation expected(tracking, MatchConstants{});
  const ByteMap map = HalfExplored();
  for (int i = 0; i <= 2000; ++i) {
    if (expected.IsMetBy({{}, 0.0005 * i}, leniently, Hits(num_explored), map)) return 0.0005 * i;
  }
  return 2.0;
}

}  // namespace

TEST_CASE(
    "a scan is explained by 7/10 of the baseline fitness, a tenth less after each of five losses as the map grows") {
  const double shares[] = {0.7, 0.63, 0.567, 0.5103, 0.45927, 0.413343};
  for (const int num_lost : {0, 1, 2, 3, 4, 5, 6, 50}) {
    CHECK(LeastFitness(AfterLosing(num_lost)) == Approx(kUsual * shares[std::min(num_lost, 5)]).margin(0.001));
    // The scene is known, and the robot was carried away.
    CHECK(LeastFitness(AfterLosing(num_lost, true)) == Approx(kUsual * 0.7).margin(0.001));
  }
}

TEST_CASE("on a finished map matches that fit badly do not lower what the next one has to reach") {
  std::vector<ScanMatch> matches;
  for (int k = 0; k < 20; ++k) matches.push_back({k, {}, 0.3, 0, 0, 0, MatchState::kOk});
  const TrackingState tracking = After(matches);
  REQUIRE(tracking.on_finished_map());
  CHECK(LeastFitness(tracking) == Approx(0.525).margin(0.001));  // seven tenths of 0.75
  CHECK(Expectation(tracking, MatchConstants{}).enough() == Approx(0.95 * 0.3));
}

TEST_CASE("rays that look into the unknown need not fit: up to a fifth, or half where the robot goes on as before") {
  // Of 20 rays: so many of them that end where the map is explored can fit as usual.
  for (const int num_explored : {20, 19, 18, 17, 16, 11, 10, 0}) {
    CAPTURE(num_explored);
    const double share = num_explored / 20.0;
    const auto Least = [&](const TrackingState& tracking, bool leniently) {
      return LeastFitness(tracking, num_explored, leniently);
    };
    CHECK(Least(AfterLosing(0), false) == Approx(kUsual * 0.7 * std::max(share, 0.8)).margin(0.001));
    CHECK(Least(AfterLosing(0), true) == Approx(kUsual * 0.7 * std::max(share, 0.5)).margin(0.001));
    // It may have stopped.
    CHECK(Least(AfterLosing(1), true) == Approx(kUsual * 0.63 * std::max(share, 0.8)).margin(0.001));
    CHECK(Least(AfterLosing(0, true), true) == Approx(kUsual * 0.7 * std::max(share, 0.8)).margin(0.001));
  }
}

TEST_CASE("what the hits see is told at the pose that was found") {
  const Expectation expected(AfterLosing(0), MatchConstants{});
  const double fitness = 0.7 * kUsual;  // enough where a fifth of the rays looks into the unknown, else too little
  const ByteMap map = HalfExplored();
  CHECK_FALSE(expected.IsMetBy({{0.0, 0.0, 0.0}, fitness}, false, Hits(20), map));
  CHECK(expected.IsMetBy({{0.0, 0.0, kPi}, fitness}, false, Hits(20), map));
  CHECK(expected.IsMetBy({{1.5, 0.0, 0.0}, fitness}, false, Hits(20), map));
}

TEST_CASE("the search stops a twentieth below the baseline fitness, where there is one") {
  CHECK(Expectation(AfterLosing(0), MatchConstants{}).enough() == Approx(0.95 * kUsual));
  CHECK(Expectation(AfterLosing(9), MatchConstants{}).enough() == Approx(0.95 * kUsual));
  const TrackingState second = After({{0, {}, 0.0, 0, 0, 0, MatchState::kFirst}});
  CHECK(Expectation(second, MatchConstants{}).enough() == 1.0);  // only the best there is
  CHECK(LeastFitness(second) == 0.0);                            // nothing tells what is too little
}

TEST_CASE("before a scan was found on a finished map it is expected to fit as scans of the mapped building do") {
  for (const int num_lost : {0, 1, 30}) {
    std::vector<ScanMatch> matches;
    for (int k = 0; k < num_lost; ++k) matches.push_back({k, {}, 0.1, 0, 0, 0, MatchState::kLost});
    const TrackingState tracking = After(matches);
    const Expectation expected(tracking, MatchConstants{});
    CHECK(expected.unknown());
    CHECK(expected.enough() < 0.65);       // these have 0.65 to 0.8
    CHECK(LeastFitness(tracking) > 0.4);   // walls that are not the building's are met by chance,
    CHECK(LeastFitness(tracking) < 0.55);  // some noise and people are not
  }
  CHECK_FALSE(Expectation(AfterLosing(3, true), MatchConstants{}).unknown());
  CHECK_FALSE(Expectation(TrackingState(), MatchConstants{}).unknown());
}

}  // namespace crsm
