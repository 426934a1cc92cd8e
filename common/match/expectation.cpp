#include "common/match/expectation.hpp"

#include <algorithm>

namespace crsm {
namespace {

/// Of a scan on a finished map before any was found there: the search stops near it. Scans of the building that was
/// mapped have 0.65 to 0.8 on intel, aces, fr079 and the simulated worlds.
constexpr double kBaselineFitness = 0.6;

/// What is expected at least on a finished map, whatever the last scans had: else a place that was found wrongly lowers
/// from scan to scan what the next one has to reach. With a lost_ratio of 0.7 this asks for 0.53. Scans of the
/// building that was mapped have more, but for one in twenty; at wrong places they have 0.2 to 0.5.
constexpr double kLeastBaselineFitness = 0.75;

/// Whether the robot is followed on a finished map, by the last scans that were found: where it goes on, people may
/// stand before walls, and doors be closed that were open.
bool IsFollowed(const TrackingState& tracking) {
  constexpr double kFirmly = 0.5;  // hardly ever reached at wrong places
  constexpr std::int64_t kAWhile = 5;
  return tracking.on_finished_map() && tracking.fitnesses().size() == TrackingState::kUsual &&
         tracking.baseline_fitness() >= kFirmly && tracking.num_lost() < kAWhile;
}

/// After each consecutive loss accept 10 % less fitness, at most four times: the scene may have changed. On a finished
/// map it did not: the robot was carried away.
double ComputeAcceptable(const TrackingState& tracking, double lost_ratio) {
  constexpr std::int64_t kMostRelaxations = 4;
  constexpr double kRelaxation = 0.9;
  if (tracking.on_finished_map()) return lost_ratio;
  for (std::int64_t i = 0; i < std::min(tracking.num_lost(), kMostRelaxations); ++i) lost_ratio *= kRelaxation;
  return lost_ratio;
}

/// Share of the hits that lie in explored cells when the laser stands at `T_map_laser`.
double ComputeExploredShare(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser) {
  int num = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const Pose2 hit = T_map_laser * Pose2{hits_m(0, i), hits_m(1, i), 0.0};
    if (map.At(map.geometry().CellAt(hit.x_m, hit.y_m)) != kUnexploredByte) ++num;
  }
  return static_cast<double>(num) / static_cast<double>(hits_m.cols());
}

}  // namespace

Expectation::Expectation(const TrackingState& tracking, const MatchParameters& parameters)
    : usual_(tracking.baseline_fitness()),
      acceptable_(ComputeAcceptable(tracking, parameters.lost_ratio)),
      unknown_(tracking.on_finished_map() && usual_ == 0.0),
      followed_(IsFollowed(tracking)),
      goes_on_(tracking.num_lost() == 0 && !tracking.on_finished_map()) {
  if (unknown_) usual_ = kBaselineFitness;
  enough_ = usual_ > 0.0 ? parameters.good_ratio * usual_ : parameters.satisfying_fitness;
  if (tracking.on_finished_map() && !followed_) usual_ = std::max(usual_, kLeastBaselineFitness);
}

bool Expectation::IsMetBy(const ScoredPose& found, bool leniently, const Eigen::Matrix2Xd& critical_hits_m,
                          const ByteMap& map) const {
  // A scan that looks into nothing but the unknown has no match. Where the robot drives out into the open, a laser of
  // short range sees for some scans more of what is new than of what it knows.
  const double least_share = leniently && goes_on_ ? 0.5 : 0.8;
  const double explored = ComputeExploredShare(map, critical_hits_m, found.pose);
  const double expected = usual_ * std::max(explored, least_share);
  const double quality = expected > 0.0 ? found.fitness / expected : 1.0;
  return quality >= acceptable_;
}

}  // namespace crsm
