#include "catch.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "synthetic_scans.hpp"

// What the matcher as it ships demands of each scan on a finished map.

namespace crsm {
namespace {

const Pose2 kPlace{-0.5, 0.3, 0.2};
constexpr double kUsual = 0.85;  // fitness of scans of the niche on its map: 0.88

/// The niche, and in it a ring of walls about 1 m around the place: what is seen of the niche from there lies behind
/// it.
std::uint8_t RingedByte(Cell cell) {
  const int dx = std::abs(cell.x + 10);
  const int dy = std::abs(cell.y - 6);
  return std::max(dx, dy) == 20 ? kOccupiedByte : NicheByte(cell);
}

template <class Paint>
ScanMatch MatchNicheOn(Paint&& paint, MatchState first) {
  RrhcMatcher matcher(MatchParameters{}, 0.05);
  matcher.Apply(PaintTiles(-1, 1, paint));
  std::vector<ScanMatch> before;
  for (int k = 0; k < 12; ++k) before.push_back({k, kPlace, kUsual, 1, 1, 0, k == 0 ? first : MatchState::kOk});
  return matcher.Match(ShippedRays(ScanNiche(kPlace, 100)), After(before), {});
}

}  // namespace

TEST_CASE("as shipped, a scan whose rays run through walls of a finished map is lost, however well they end") {
  CHECK(MatchNicheOn(NicheByte, MatchState::kOk).state == MatchState::kOk);
  const ScanMatch behind_walls = MatchNicheOn(RingedByte, MatchState::kOk);
  CHECK(behind_walls.fitness > 0.8);
  CHECK(behind_walls.state == MatchState::kLost);
  CHECK(behind_walls.T_map_laser == kPlace);  // where it was last
}

TEST_CASE("as shipped, a map that grows is not asked that: its walls may have been there for a moment") {
  const ScanMatch match = MatchNicheOn(RingedByte, MatchState::kFirst);
  CHECK(match.fitness > 0.8);
  CHECK(match.state == MatchState::kOk);
}

}  // namespace crsm
