#include "common/match/judge/expectation.hpp"

#include <algorithm>

#include "common/match/judge/census.hpp"

namespace crsm {
namespace {

/// Whether the robot is followed on a finished map, by the last scans that were found: where it goes on, people may
/// stand before walls, and doors be closed that were open.
bool IsFollowed(const TrackingState& tracking, const MatchConstants& constants) {
  return tracking.on_finished_map() && tracking.fitnesses().size() == TrackingState::kUsual &&
         tracking.baseline_fitness() >= constants.finished_map.followed_fitness &&
         tracking.num_lost() < constants.acceptance.patience;
}

/// The share of the baseline fitness below which a scan is lost.
double ComputeAcceptable(const TrackingState& tracking, const MatchConstants::Acceptance& constants) {
  double share = constants.lost;
  if (tracking.on_finished_map()) return share;
  const std::int64_t num = std::min(tracking.num_lost(), constants.patience);
  for (std::int64_t i = 0; i < num; ++i) share *= constants.relaxation;
  return share;
}

}  // namespace

Expectation::Expectation(const TrackingState& tracking, const MatchConstants& constants)
    : constants_(constants.acceptance),
      usual_(tracking.baseline_fitness()),
      acceptable_(ComputeAcceptable(tracking, constants.acceptance)),
      unknown_(tracking.on_finished_map() && usual_ == 0.0),
      followed_(IsFollowed(tracking, constants)),
      goes_on_(tracking.num_lost() == 0 && !tracking.on_finished_map()) {
  if (unknown_) usual_ = constants.finished_map.baseline_fitness;
  enough_ = usual_ > 0.0 ? constants.acceptance.good * usual_ : 1.0;
  if (tracking.on_finished_map() && !followed_) usual_ = std::max(usual_, constants.finished_map.baseline_fitness_min);
}

bool Expectation::IsMetBy(const ScoredPose& found, bool leniently, const Eigen::Matrix2Xd& critical_hits_m,
                          const ByteMap& map) const {
  // A scan that looks into nothing but the unknown has no match.
  const double least_share = leniently && goes_on_ ? constants_.explored_min_near : constants_.explored_min;
  const double explored = 1.0 - FindUnexploredShare(map, critical_hits_m, found.pose);
  const double expected = usual_ * std::max(explored, least_share);
  const double quality = expected > 0.0 ? found.fitness / expected : 1.0;
  return quality >= acceptable_;
}

}  // namespace crsm
