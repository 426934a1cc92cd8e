#include "common/diagnosis/sweep_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/math/median.hpp"
#include "common/math/trigonometry.hpp"
#include "common/slam.hpp"

namespace crsm {
namespace {

/// What a sweep makes of a scan.
struct Trial {
  double fitness = 0.0;  ///< 0 if it was lost
  bool turns = false;    ///< the robot, in the sweep
};

/// What became of each scan, up to enough that turn.
std::vector<Trial> Try(std::span<const LaserScan> scans, const Parameters& parameters, double sweep_s,
                       const DiagnosisConstants::SweepStudy& constants) {
  std::vector<Trial> trials;
  Slam slam(parameters);
  ScanMatch last;
  int num_turning = 0;
  for (const LaserScan& scan : scans) {
    if (!trials.empty() && scan.utime <= last.utime) continue;
    const ScanMatch match = slam.Process(scan).match;
    Trial trial;
    if (match.state != MatchState::kLost) trial.fitness = match.fitness;
    if (!trials.empty() && IsMotionMatched(last, match)) {
      const double elapsed_s = 1e-6 * static_cast<double>(match.utime - last.utime);
      const double turned_rad = WrapAngle(match.T_map_laser.yaw_rad - last.T_map_laser.yaw_rad) * sweep_s / elapsed_s;
      trial.turns = std::abs(turned_rad) > constants.turning_rad;
    }
    trials.push_back(trial);
    last = match;
    num_turning += trial.turns;
    if (num_turning == constants.enough_turning) break;
  }
  return trials;
}

/// Whether turning scans fit better by one sweep than by another, so clearly that it is no chance.
bool IsClearlyBetter(const std::vector<Trial>& one, const std::vector<Trial>& other, const std::vector<Trial>& turns,
                     const DiagnosisConstants::SweepStudy& constants) {
  double sum = 0.0;
  double squares = 0.0;
  double num = 0.0;
  for (std::size_t i = 0; i < std::min({one.size(), other.size(), turns.size()}); ++i) {
    if (!turns[i].turns) continue;
    const double better = one[i].fitness - other[i].fitness;
    sum += better;
    squares += better * better;
    ++num;
  }
  if (num < constants.few_turning) return false;
  const double mean = sum / num;
  const double deviation = std::sqrt(std::max(0.0, squares / num - mean * mean) / num);
  return mean > constants.better_fitness_min && mean > constants.better_sigmas * deviation;
}

double FindPeriod(std::span<const LaserScan> scans) {
  std::vector<double> periods_s;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    if (scans[i].utime > scans[i - 1].utime) {
      periods_s.push_back(1e-6 * static_cast<double>(scans[i].utime - scans[i - 1].utime));
    }
  }
  return periods_s.empty() ? 0.0 : FindMedian(periods_s);
}

double FindSaidSweep(std::span<const LaserScan> scans) {
  std::vector<double> sweeps_s;
  for (const LaserScan& scan : scans) {
    if (!scan.times_s.empty()) sweeps_s.push_back(static_cast<double>(scan.times_s.back()) - scan.times_s.front());
  }
  return sweeps_s.empty() ? 0.0 : FindMedian(sweeps_s);
}

/// The share of a turn that the laser sees, of the time for a turn.
double LikelySweep(const LaserScan& scan, double period_s, const DiagnosisConstants::SweepStudy& constants) {
  return period_s <= constants.longest_period_s ? period_s * std::min(1.0, ViewOf(scan) / (2.0 * kPi)) : 0.0;
}

}  // namespace

double ViewOf(const LaserScan& scan) {
  return std::abs(scan.angle_step_rad) * static_cast<double>(scan.ranges_m.size() - 1);
}

std::optional<SweepFinding> StudySweep(std::span<const LaserScan> scans, Parameters parameters,
                                       const DiagnosisConstants::SweepStudy& constants) {
  scans = scans.first(std::min(scans.size(), constants.num_scans));
  SweepFinding finding;
  finding.said_s = parameters.scan.beam_times ? FindSaidSweep(scans) : 0.0;
  const bool says_times = finding.said_s != 0.0;
  if (!says_times) finding.said_s = parameters.scan.sweep_s;
  if (finding.said_s == 0.0) return std::nullopt;
  finding.period_s = FindPeriod(scans);
  const double share = finding.period_s > 0.0 ? std::abs(finding.said_s) / finding.period_s : 0.5;
  finding.can_be = share >= constants.shortest_share && share <= constants.longest_share;
  finding.sweep_s = finding.can_be ? finding.said_s : LikelySweep(scans.front(), finding.period_s, constants);
  if (finding.sweep_s == 0.0) return finding;

  parameters.loops.loops = false;
  parameters.match.start.reset();
  parameters.update.algorithm = Algorithm::kCrsm;  // what is studied is the laser
  const std::array<double, 3> sweeps_s{finding.sweep_s, -finding.sweep_s, 0.0};
  std::vector<Trial> turns;
  std::vector<Trial> best;
  for (const double sweep_s : sweeps_s) {
    parameters.scan.beam_times = says_times && sweep_s == finding.said_s;
    parameters.scan.sweep_s = sweep_s;
    std::vector<Trial> trials = Try(scans, parameters, sweep_s, constants);
    if (turns.empty()) {
      turns = best = std::move(trials);
      finding.num_turning = static_cast<int>(std::ranges::count_if(turns, &Trial::turns));
      if (finding.num_turning < constants.few_turning) break;
      scans = scans.first(std::min(scans.size(), turns.size()));
    } else if (IsClearlyBetter(trials, best, turns, constants)) {
      best = std::move(trials);
      finding.sweep_s = sweep_s;
    }
  }
  return finding;
}

}  // namespace crsm
