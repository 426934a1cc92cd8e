#pragma once

#include <optional>
#include <span>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// When the beams of a log's scans were measured: what its messages say, and what its first scans show.
struct SweepFinding {
  double said_s = 0.0;    ///< from the first beam to the last, by the messages; negative: the last one is first
  double period_s = 0.0;  ///< from a scan to the next; 0 where the clock stands
  bool can_be = true;     ///< the messages' sweep is a likely share of that period
  double sweep_s = 0.0;   ///< what fits best, as ScanParameters::sweep_s: said_s itself, or what is to win over it
  int num_turning = 0;    ///< scans that were compared; with too few of them sweep_s is what is likely

  /// Whether the messages' times are to be believed.
  bool agrees() const { return sweep_s == said_s; }
};

/// The angle from the first beam to the last [rad]; there are some.
double ViewOf(const LaserScan& scan);

/// Maps the first scans three times: with the sweep that the messages say, the other way round, and all beams at once.
/// While the robot turns, what is right fits best. Drivers of lasers that turn clockwise reverse their beams, and some
/// leave the times as they were; others say times that are a thousand times too short, or longer than a turn of the
/// laser: such a sweep is taken to be the share of the period that the laser's view is of a turn. What the messages
/// say stays unless another is clearly better.
///
/// scans: of one laser, in their order. Where they have no times, parameters.scan.sweep_s is what is said; nothing if
/// that is 0.
std::optional<SweepFinding> StudySweep(std::span<const LaserScan> scans, Parameters parameters,
                                       const DiagnosisConstants::SweepStudy& constants = {});

}  // namespace crsm
