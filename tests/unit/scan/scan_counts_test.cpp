#include "common/scan/scan_counts.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

ScanMatch Make(MatchState state, bool floating, int num_critical = 70) {
  ScanMatch match;
  match.state = state;
  match.floating = floating;
  match.num_critical = num_critical;
  return match;
}

}  // namespace

TEST_CASE("each scan is in exactly one place: on the map, floating, lost or without rays") {
  using enum ScanOutcome;
  struct Case {
    MatchState state;
    ScanOutcome on_map;
    ScanOutcome floating;
    ScanOutcome without_rays;
  };
  const std::vector<Case> cases{
      {MatchState::kFirst, kOnMap, kFloating, kWithoutRays},
      {MatchState::kOk, kOnMap, kFloating, kOnMap},  // what was matched had rays
      {MatchState::kDegenerate, kOnMap, kFloating, kOnMap},
      {MatchState::kLost, kLost, kLost, kWithoutRays},  // lost beside another piece is lost all the same
  };
  ScanCounts counts;
  for (const Case& tested : cases) {
    CAPTURE(static_cast<int>(tested.state));
    CHECK(OutcomeOf(Make(tested.state, false)) == tested.on_map);
    CHECK(OutcomeOf(Make(tested.state, true)) == tested.floating);
    CHECK(OutcomeOf(Make(tested.state, false, 0)) == tested.without_rays);
    counts.Add(Make(tested.state, false));
    counts.Add(Make(tested.state, true));
    counts.Add(Make(tested.state, false, 0));
  }
  CHECK(counts == ScanCounts{5, 3, 2, 2});
  CHECK(counts.scans() == 12);
}

TEST_CASE("of what is not on the map lost scans are always named, the others where there are any") {
  CHECK(DescribeOthers({}) == "0 lost");
  CHECK(DescribeOthers({9, 3, 2, 1}) == "3 floating (on another piece), 2 lost, 1 without rays");
}

}  // namespace crsm
