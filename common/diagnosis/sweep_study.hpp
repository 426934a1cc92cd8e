#pragma once

#include <optional>
#include <span>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// When the beams of a log's scans were measured: what its messages say, and what its first scans show.
struct SweepFinding {
  double said_s = 0.0;    ///< from the first beam to the last, negative: the last one is first; 0: nothing is said
  double period_s = 0.0;  ///< from a scan to the next; 0 where the clock stands
  bool can_be = true;     ///< the messages' sweep is a likely share of that period
  double sweep_s = 0.0;   ///< what fits best, as ScanParameters::sweep_s: said_s itself, or what is to win over it

  /// Whether what is said, or that nothing is, is to be believed.
  bool agrees() const { return sweep_s == said_s; }
};

/// The angle from the first beam to the last [rad]; there are some.
double ViewOf(const LaserScan& scan);

/// Maps the first scans with each sweep that the laser may have: the one that is said, the share of the scans' period
/// that its view is of a turn, both of them in either direction, and none. While the robot turns, what is right fits
/// best. Few messages have times for their beams; of those that have, some are of another unit, longer than a turn of
/// the laser, or in the wrong order: drivers of lasers that turn clockwise reverse their beams, and not the times. What
/// is said stays, as does that nothing is, unless another sweep is clearly better than it and than its own opposite.
/// Where what is said cannot be, the share of the period takes its place.
///
/// scans: of one laser, in their order. Where they have no times, parameters.scan.sweep_s is what is said. Nothing if
/// that is 0, and the scans are too rare for a laser that turns, or see no more than half a turn. Of the other
/// parameters only the seed counts: the maps are made as shipped.
std::optional<SweepFinding> StudySweep(std::span<const LaserScan> scans, const Parameters& parameters,
                                       const DiagnosisConstants::SweepStudy& constants = {});

}  // namespace crsm
