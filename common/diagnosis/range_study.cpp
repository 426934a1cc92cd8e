#include "common/diagnosis/range_study.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include "common/scan/valid_rays.hpp"

namespace crsm {
namespace {

bool IsNumber(float range_m) { return range_m > 0.0f && std::isfinite(range_m); }

/// Which beams have the largest range of all.
struct Largest {
  float range_m = 0.0f;
  std::size_t count = 0;
  std::set<std::size_t> beams;
};

Largest FindLargest(std::span<const LaserScan> scans) {
  Largest largest;
  for (const LaserScan& scan : scans) {
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      const float range_m = scan.ranges_m[beam];
      if (!IsNumber(range_m) || range_m < largest.range_m) continue;
      if (range_m > largest.range_m) largest = {range_m, 0, {}};
      ++largest.count;
      largest.beams.insert(beam);
    }
  }
  return largest;
}

}  // namespace

double RangeFinding::RangeMax() const {
  constexpr double kDigits = 1e4;  // four decimals, as it is written
  ScanParameters unit;
  unit.range_max_m = 1.0;
  return (std::ceil(kDigits * static_cast<double>(*no_return_m) / LargestUsableRange(unit)) - 1.0) / kDigits;
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
  const Largest largest = FindLargest(scans);
  const double share = static_cast<double>(largest.count) / static_cast<double>(num_beams);
  if (share >= constants.many_beams &&
      static_cast<double>(largest.beams.size()) >= constants.all_over * static_cast<double>(widest)) {
    finding.no_return_m = largest.range_m;
    finding.no_return_share = share;
  }
  const double usable_m = LargestUsableRange(parameters);
  finding.no_return_is_hit = finding.no_return_m && *finding.no_return_m <= usable_m;
  std::size_t num_hits = 0;
  std::size_t num_beyond = 0;
  for (const LaserScan& scan : scans) {
    for (const float range_m : scan.ranges_m) {
      if (!IsNumber(range_m) || range_m == finding.no_return_m) continue;
      ++num_hits;
      if (range_m > usable_m) ++num_beyond;
      finding.reach_m = std::max(finding.reach_m, static_cast<double>(range_m));
    }
  }
  if (num_hits > 0) finding.beyond_share = static_cast<double>(num_beyond) / static_cast<double>(num_hits);
  return finding;
}

}  // namespace crsm
