#pragma once

#include <optional>
#include <span>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// What the ranges of a log's first scans tell of a laser.
struct RangeFinding {
  double reach_m = 0.0;              ///< the furthest hit, as of FindReach
  double hits_a_scan = 0.0;          ///< median: some lasers say nothing in most of their beams
  std::optional<float> no_return_m;  ///< from this range on the laser has measured nothing
  double no_return_share = 0.0;      ///< of all beams
  bool no_return_is_hit = false;     ///< the parameters take it for one
  double beyond_share = 0.0;         ///< of all hits: beyond what the parameters take for one

  /// The largest range_max_m that takes no_return_m for no hit. Only where there is one.
  double RangeMax() const;
};

/// The furthest hit [m]; 0 without any. A few beams of which a laser says that they measured nothing are no hits,
/// though they may be too few to tell more of them: as 50 m in one beam of seventy. no_return_m: as of RangeFinding.
double FindReach(std::span<const LaserScan> scans, const std::optional<float>& no_return_m,
                 const DiagnosisConstants::RangeStudy& constants = {});

/// Ranges that lie within a thousandth of the largest of all, of many beams all over the view, are how the laser says
/// that it measured nothing, as 81.83 m, or 8.183 m and 8.191 m. (Zero, infinity and NaN say so without a word.) Hits
/// spread wider: of a flat wall 5.1 degrees at most lie within a thousandth of its distance, and those near its foot.
RangeFinding StudyRanges(std::span<const LaserScan> scans, const ScanParameters& parameters,
                         const DiagnosisConstants::RangeStudy& constants = {});

}  // namespace crsm
