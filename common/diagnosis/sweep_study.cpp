#include "common/diagnosis/sweep_study.hpp"

#include <algorithm>
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
  bool tells = false;    ///< of the sweep: the robot turns meanwhile, or so fast that the scan was lost
};

/// What became of each scan, up to enough that turn in a time [s], or are lost.
std::vector<Trial> Try(std::span<const LaserScan> scans, const Parameters& parameters, double within_s,
                       const DiagnosisConstants::SweepStudy& constants) {
  std::vector<Trial> trials;
  Slam slam(parameters);
  ScanMatch last;
  int num_telling = 0;
  for (const LaserScan& scan : scans) {
    if (!trials.empty() && scan.utime <= last.utime) continue;
    const ScanMatch match = slam.Process(scan).match;
    const bool is_lost = match.state == MatchState::kLost;
    Trial trial{is_lost ? 0.0 : match.fitness, is_lost};
    if (!trials.empty() && IsMotionMatched(last, match)) {
      const double elapsed_s = 1e-6 * static_cast<double>(match.utime - last.utime);
      const double turned_rad = WrapAngle(match.T_map_laser.yaw_rad - last.T_map_laser.yaw_rad) * within_s / elapsed_s;
      trial.tells = std::abs(turned_rad) > constants.turning_rad;
    }
    trials.push_back(trial);
    last = match;
    num_telling += trial.tells;
    if (num_telling == constants.enough_turning) break;
  }
  return trials;
}

/// Whether turning scans fit better by one sweep than by another, so clearly that it is no chance.
bool IsClearlyBetter(const std::vector<Trial>& one, const std::vector<Trial>& other,
                     const DiagnosisConstants::SweepStudy& constants) {
  double sum = 0.0;
  double squares = 0.0;
  double num = 0.0;
  for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i) {
    if (!one[i].tells && !other[i].tells) continue;
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

/// A laser that turns needs the time from scan to scan for a turn: of that, the share that it sees. 0 for a laser that
/// is not known to turn so.
double FindLikelySweep(const LaserScan& scan, double period_s, const DiagnosisConstants::SweepStudy& constants) {
  const double view_rad = ViewOf(scan);
  if (period_s > constants.longest_period_s || view_rad < constants.narrowest_view_rad) return 0.0;
  return period_s * std::min(1.0, view_rad / (2.0 * kPi));
}

/// The sweep that stays where nothing tells, and then the others, each once.
std::vector<double> ListCandidates(double first_s, double likely_s, const DiagnosisConstants::SweepStudy& constants) {
  std::vector<double> sweeps_s{first_s};
  for (const double sweep_s : {-first_s, likely_s, -likely_s, 0.0}) {
    const bool is_new = std::ranges::none_of(sweeps_s, [&](double other_s) {
      const double longest_s = std::max(std::abs(sweep_s), std::abs(other_s));
      return std::abs(sweep_s - other_s) <= constants.alike_share * longest_s;
    });
    if (is_new) sweeps_s.push_back(sweep_s);
  }
  return sweeps_s;
}

}  // namespace

double ViewOf(const LaserScan& scan) {
  return std::abs(scan.angle_step_rad) * static_cast<double>(scan.ranges_m.size() - 1);
}

std::optional<SweepFinding> StudySweep(std::span<const LaserScan> scans, const Parameters& parameters,
                                       const DiagnosisConstants::SweepStudy& constants) {
  scans = scans.first(std::min(scans.size(), constants.num_scans));
  SweepFinding finding;
  finding.said_s = parameters.scan.beam_times ? FindSaidSweep(scans) : 0.0;
  const bool says_times = finding.said_s != 0.0;
  if (!says_times) finding.said_s = parameters.scan.sweep_s;
  finding.period_s = FindPeriod(scans);
  const double likely_s = FindLikelySweep(scans.front(), finding.period_s, constants);
  if (finding.said_s == 0.0 && likely_s == 0.0) return std::nullopt;
  const double share = finding.period_s > 0.0 ? std::abs(finding.said_s) / finding.period_s : 0.5;
  finding.can_be = finding.said_s == 0.0 || (share >= constants.shortest_share && share <= constants.longest_share);
  finding.sweep_s = finding.can_be ? finding.said_s : likely_s;

  Parameters of_trial;  // what is studied is the laser: nobody's profile, cells or start
  of_trial.scan = parameters.scan;
  of_trial.match.seed = parameters.match.seed;
  of_trial.loops.loops = false;
  const double longest_s = std::max(std::abs(finding.sweep_s), likely_s);
  const std::vector<double> sweeps_s = ListCandidates(finding.sweep_s, likely_s, constants);
  std::vector<std::vector<Trial>> trials;
  for (const double sweep_s : sweeps_s) {
    of_trial.scan.beam_times = says_times && sweep_s == finding.said_s;
    of_trial.scan.sweep_s = sweep_s;
    trials.push_back(Try(scans, of_trial, longest_s, constants));
    if (std::ranges::count_if(trials.front(), &Trial::tells) < constants.few_turning) break;
    scans = scans.first(std::min(scans.size(), trials.back().size()));
  }
  // In two sweeps that are both wrong a scan may fit better than in none: the wrong way round is to be worse, too.
  std::size_t best = 0;
  for (std::size_t i = 1; i < trials.size(); ++i) {
    const auto opposite = static_cast<std::size_t>(std::ranges::find(sweeps_s, -sweeps_s[i]) - sweeps_s.begin());
    const bool has_opposite = opposite != i && opposite < trials.size();
    if (has_opposite && !IsClearlyBetter(trials[i], trials[opposite], constants)) continue;
    if (IsClearlyBetter(trials[i], trials[best], constants)) best = i;
  }
  finding.sweep_s = sweeps_s[best];
  return finding;
}

}  // namespace crsm
