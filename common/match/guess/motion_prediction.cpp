#include "common/match/guess/motion_prediction.hpp"

#include <algorithm>
#include <cmath>

namespace crsm {

Pose2 PredictPose(std::span<const ScanMatch> recent, const MatchConstants::Prediction& constants) {
  // The way is the mean of some motions, because along a corridor no single one is known well. Where nothing seen holds
  // the position, it is the mean of all that are remembered and not too old: an error of one motion, taken over into
  // the next ones, would grow until the robot seemed to stand. The turn is the last one: it is always known well, and
  // soon another.
  const bool is_degenerate = recent.back().state == MatchState::kDegenerate;
  const std::size_t num_motions = is_degenerate ? recent.size() : constants.motions;
  Pose2 sum;
  std::size_t num = 0;
  for (; num < num_motions && num + 1 < recent.size(); ++num) {
    const ScanMatch& to = recent[recent.size() - 1 - num];
    const ScanMatch& from = recent[recent.size() - 2 - num];
    if (num >= constants.motions && recent.back().utime - from.utime > constants.oldest_us) break;
    if (!IsMotionMatched(from, to)) break;
    const Pose2 motion = Inverse(from.T_map_laser) * to.T_map_laser;
    sum.x_m += motion.x_m;
    sum.y_m += motion.y_m;
    if (num == 0) sum.yaw_rad = motion.yaw_rad;
  }
  if (num == 0) return recent.back().T_map_laser;
  const double share = 1.0 / static_cast<double>(num);
  return recent.back().T_map_laser * Pose2{share * sum.x_m, share * sum.y_m, sum.yaw_rad};
}

double ComputeSteadiness(std::span<const ScanMatch> recent, std::int64_t utime,
                         const MatchConstants::MotionPrior& constants) {
  if (recent.empty()) return 1.0;
  const double elapsed_s = 1e-6 * static_cast<double>(utime - recent.back().utime);
  return elapsed_s <= constants.steady_s ? 1.0 : std::pow(constants.steady_s / elapsed_s, 2);
}

}  // namespace crsm
