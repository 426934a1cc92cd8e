#pragma once

#include <bitset>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// Judges from its scans whether a laser, or the driver in front of it, is set up wrongly: a clock that stands still,
/// runs backwards or counts no microseconds, ranges in millimetres, no ray that measures anything. A scan now and then
/// proves nothing: robots stand in the open, logs step back in time, scans are sent twice. Of seven real logs and the
/// built-in worlds, one steps back in time 5 times in 20 scans, where 10 are complained of, and none has a scan without
/// rays.
class LaserJudge {
 public:
  explicit LaserJudge(const ScanParameters& parameters, const DiagnosisConstants::LaserJudge& constants = {})
      : parameters_(parameters), constants_(constants) {}

  /// The next scan as it came; one that is sent again counts once. Returns what is wrong and what mends it, a sentence
  /// for each fault, after ten scans that show it, and not again. That the clock begins anew is said each time, unless
  /// it does so at every few scans.
  ///
  /// Costs a few comparisons a ray for each of the first 30 scans, then for one in ten unless that one looks wrong.
  std::vector<std::string> Look(const LaserScan& scan);

 private:
  enum class Fault { kClockStands, kClockGoesBack, kUnit, kMillimetres, kNoRays };
  using Steps = std::bitset<64>;  ///< of the clock, the newest first: those that show a fault

  void JudgeClock(const LaserScan& scan, std::vector<std::string>& found);
  void JudgeUnit(const LaserScan& scan, std::vector<std::string>& found);
  double MeanStep(const LaserScan& scan) const;
  void JudgeRestart(const LaserScan& scan, std::vector<std::string>& found);
  void JudgeRanges(const LaserScan& scan, std::vector<std::string>& found);
  bool IsNew(Fault fault);
  int CountInWindow(const Steps& steps) const;  ///< those that show the fault

  ScanParameters parameters_;
  DiagnosisConstants::LaserJudge constants_;
  LaserScan last_;
  std::int64_t first_utime_ = 0;
  std::int64_t num_scans_ = 0;
  Steps standing_steps_;
  Steps backward_steps_;
  std::optional<std::int64_t> restart_;  ///< the scan with which the clock last began anew, in the order of arrival
  std::map<Fault, int> in_a_row_;        ///< of the faults that the ranges show
  std::map<Fault, bool> said_;
};

}  // namespace crsm
