#include "common/diagnosis/range_study.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "common/math/median.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {
namespace {

bool IsNumber(float range_m) { return range_m > 0.0f && std::isfinite(range_m); }

bool IsHit(float range_m, const std::optional<float>& no_return_m) {
  return IsNumber(range_m) && !(no_return_m && range_m >= *no_return_m);
}

template <class Visit>
void ForEachNumber(std::span<const LaserScan> scans, const Visit& visit) {
  for (const LaserScan& scan : scans) {
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      if (IsNumber(scan.ranges_m[beam])) visit(scan, beam, scan.ranges_m[beam]);
    }
  }
}

/// The beams with ranges that are hardly below the largest of all.
struct Pile {
  float least_m = 0.0f;
  std::size_t count = 0;
  double angle_rad = 0.0;  ///< that they fill in all scans together
  std::set<std::size_t> beams;
};

Pile FindPile(std::span<const LaserScan> scans, double pile_share) {
  float largest_m = 0.0f;
  ForEachNumber(scans, [&](const LaserScan&, std::size_t, float range_m) { largest_m = std::max(largest_m, range_m); });
  Pile pile;
  pile.least_m = largest_m;
  ForEachNumber(scans, [&](const LaserScan& scan, std::size_t beam, float range_m) {
    if (static_cast<double>(range_m) < (1.0 - pile_share) * static_cast<double>(largest_m)) return;
    pile.least_m = std::min(pile.least_m, range_m);
    ++pile.count;
    pile.angle_rad += std::abs(static_cast<double>(scan.angle_step_rad));
    pile.beams.insert(beam);
  });
  return pile;
}

/// How much of the view a flat wall fills at most with ranges of one pile: it faces the laser squarely, r = d / cos(a).
double WidestWall(double pile_share) { return 2.0 * std::acos(1.0 - pile_share); }

}  // namespace

double RangeFinding::RangeMax() const {
  constexpr double kDigits = 1e4;  // four decimals, as it is written
  ScanParameters unit;
  unit.range_max_m = 1.0;
  return (std::ceil(kDigits * static_cast<double>(*no_return_m) / LargestUsableRange(unit)) - 1.0) / kDigits;
}

double FindReach(std::span<const LaserScan> scans, const std::optional<float>& no_return_m,
                 const DiagnosisConstants::RangeStudy& constants) {
  const auto ForEach = [&](const auto& visit) {
    ForEachNumber(scans, [&](const LaserScan&, std::size_t beam, float range_m) {
      if (IsHit(range_m, no_return_m)) visit(range_m, beam);
    });
  };
  float largest_m = 0.0f;
  ForEach([&](float range_m, std::size_t) { largest_m = std::max(largest_m, range_m); });
  float below_m = 0.0f;
  std::map<float, std::set<std::size_t>> beams_in_pile;  // by their range
  ForEach([&](float range_m, std::size_t beam) {
    if (range_m < largest_m - constants.pile_m) {
      below_m = std::max(below_m, range_m);
    } else {
      beams_in_pile[range_m].insert(beam);
    }
  });
  const bool is_pile =
      std::ranges::any_of(beams_in_pile, [&](const auto& each) { return each.second.size() >= constants.pile_beams; });
  return is_pile && below_m > 0.0f ? below_m : largest_m;
}

RangeFinding StudyRanges(std::span<const LaserScan> scans, const ScanParameters& parameters,
                         const DiagnosisConstants::RangeStudy& constants) {
  RangeFinding finding;
  std::size_t num_beams = 0;
  std::size_t widest = 0;
  for (const LaserScan& scan : scans) {
    num_beams += scan.ranges_m.size();
    widest = std::max(widest, scan.ranges_m.size());
  }
  if (num_beams == 0) return finding;
  const Pile pile = FindPile(scans, constants.pile_share);
  const double share = static_cast<double>(pile.count) / static_cast<double>(num_beams);
  if (share >= constants.many_beams &&
      pile.angle_rad > WidestWall(constants.pile_share) * static_cast<double>(scans.size()) &&
      static_cast<double>(pile.beams.size()) >= constants.all_over * static_cast<double>(widest)) {
    finding.no_return_m = pile.least_m;
    finding.no_return_share = share;
  }
  const double usable_m = LargestUsableRange(parameters);
  finding.no_return_is_hit = finding.no_return_m && *finding.no_return_m <= usable_m;
  std::size_t num_hits = 0;
  std::size_t num_beyond = 0;
  std::vector<double> hits_in_scans;
  for (const LaserScan& scan : scans) {
    const std::size_t num_before = num_hits;
    for (const float range_m : scan.ranges_m) {
      if (!IsHit(range_m, finding.no_return_m)) continue;
      ++num_hits;
      if (range_m > usable_m) ++num_beyond;
    }
    hits_in_scans.push_back(static_cast<double>(num_hits - num_before));
  }
  finding.hits_a_scan = FindMedian(std::move(hits_in_scans));
  finding.reach_m = FindReach(scans, finding.no_return_m, constants);
  if (num_hits > 0) finding.beyond_share = static_cast<double>(num_beyond) / static_cast<double>(num_hits);
  return finding;
}

}  // namespace crsm
