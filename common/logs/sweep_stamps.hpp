#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crsm {

/// When a stamp is that of a sweep's first beam. Shares of the sweep, of how long after their stamps scans are
/// recorded.
struct SweepStampsConstants {
  std::size_t few = 10;   ///< scans: fewer prove nothing
  double earliest = 0.9;  ///< nothing is recorded before its last beam is measured
  double usual = 1.5;     ///< what takes longer as a rule is another clock
};

/// Whether the stamps of a log are of the first beam or of the last. The scans themselves do not tell; but a recorder
/// with the same clock takes a sweep when its last beam is measured.
class SweepStamps {
 public:
  explicit SweepStamps(const SweepStampsConstants& constants = {}) : constants_(constants) {}

  /// One of the first scans. Both in microseconds.
  void Study(std::int64_t stamp, std::int64_t recorded_utime);

  /// Of sweeps that take so long [s], either way round; false for those that take no time.
  bool AreOfFirstBeam(double sweep_s) const;

 private:
  SweepStampsConstants constants_;
  std::vector<double> lags_s_;
};

}  // namespace crsm
