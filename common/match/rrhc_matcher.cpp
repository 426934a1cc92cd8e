#include "common/match/rrhc_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "common/match/global_search.hpp"
#include "common/match/motion_prediction.hpp"
#include "common/match/pose_uncertainty.hpp"
#include "common/match/rrhc_search.hpp"
#include "common/match/summit.hpp"

namespace crsm {
namespace {

Eigen::Matrix2Xd Columns(const Eigen::Matrix2Xd& all, std::span<const int> picked) {
  Eigen::Matrix2Xd columns(2, static_cast<Eigen::Index>(picked.size()));
  for (std::size_t i = 0; i < picked.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = all.col(picked[i]);
  return columns;
}

/// Mean fitness of the last scans that were matched; 0 when there are none among the last thousand.
double ComputeUsualFitness(std::span<const ScanMatch> history) {
  constexpr int kScans = 10;
  history = history.last(std::min<std::size_t>(history.size(), 1000));
  double sum = 0.0;
  int num = 0;
  for (auto match = history.rbegin(); match != history.rend() && num < kScans; ++match) {
    if (match->state != MatchState::kOk && match->state != MatchState::kDegenerate) continue;
    sum += match->fitness;
    ++num;
  }
  return num == 0 ? 0.0 : sum / num;
}

/// How many of the last scans were lost in a row, up to `most`.
int CountLost(std::span<const ScanMatch> history, int most) {
  int num = 0;
  for (auto match = history.rbegin(); match != history.rend() && num < most; ++match, ++num) {
    if (match->state != MatchState::kLost) break;
  }
  return num;
}

/// Whether the map was there before the first of these scans: the first one of a map that grows is kFirst.
bool IsFinishedMap(std::span<const ScanMatch> history) {
  return history.empty() || history.front().state != MatchState::kFirst;
}

/// Whether a scan is to be looked for on all of a finished map: the first ones until one is found, later every tenth
/// after ten were lost in a row.
bool IsGlobalSearchDue(std::span<const ScanMatch> history) {
  constexpr int kPatience = 10;
  const int num = static_cast<int>(std::min<std::size_t>(history.size(), kPatience));
  if (!IsFinishedMap(history) || CountLost(history, num) < num) return false;
  return num < kPatience || history.size() % kPatience == 0;
}

/// Share of the hits that lie in explored cells when the laser stands at `T_map_laser`.
double ComputeExploredShare(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                            const MapGeometry& geometry) {
  int num = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const Pose2 hit = T_map_laser * Pose2{hits_m(0, i), hits_m(1, i), 0.0};
    if (map.At(geometry.CellAt(hit.x_m, hit.y_m)) != kUnexploredByte) ++num;
  }
  return static_cast<double>(num) / static_cast<double>(hits_m.cols());
}

void SetUncertainty(ScanMatch& match, const PoseUncertainty& uncertainty) {
  const Eigen::Matrix3d& c = uncertainty.covariance;
  match.covariance = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
  match.state = uncertainty.degenerate ? MatchState::kDegenerate : MatchState::kOk;
  if (uncertainty.degenerate) match.degenerate_axis = {uncertainty.degenerate->x(), uncertainty.degenerate->y()};
}

}  // namespace

RrhcMatcher::RrhcMatcher(const MatchParameters& parameters)
    : parameters_(parameters), field_(parameters.unexplored_score, parameters.interpolate) {}

bool RrhcMatcher::ApplyChanges(std::span<const TileChange> changes) {
  bool well_formed = true;
  std::vector<CellRectangle> changed;
  for (const TileChange& change : changes) {
    if (!map_.Apply(change)) {
      well_formed = false;
    } else if (!change.runs.empty()) {
      changed.push_back(FindChangedCells(change));
    }
  }
  field_.RefreshCells(map_, changed);
  return well_formed;
}

ScanMatch RrhcMatcher::Match(std::int64_t utime, const ValidRays& rays, std::span<const int> critical,
                             std::span<const ScanMatch> history, const MapGeometry& geometry, std::int64_t map_version,
                             const std::optional<Pose2>& T_odom_robot) const {
  ScanMatch match;
  match.utime = utime;
  match.num_critical = static_cast<std::int32_t>(critical.size());
  match.map_version = map_version;
  if (parameters_.odometry) match.T_odom_robot = T_odom_robot;
  if (map_.tiles().entries().empty()) return match;

  const bool first = history.empty();
  const Pose2 repeated = first ? parameters_.start.value_or(Pose2{}) : PredictPose(history, parameters_);
  const std::optional<Pose2> by_odometry =
      first ? std::nullopt : PredictPoseByOdometry(history, match.T_odom_robot, parameters_);
  match.T_map_laser = by_odometry.value_or(repeated);
  match.state = MatchState::kLost;
  if (critical.empty()) return match;

  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  const Eigen::Matrix2Xd critical_hits_m = Columns(hits_m, critical);
  const RaysInCells critical_rays = ToCells(critical_hits_m, geometry);
  Pose2 presumed = repeated;
  if (by_odometry) {
    // Motions that were matched are known better than those of wheels, unless the robot moves in another way now, or
    // the walls do not tell how far.
    constexpr double kClearly = 1.2;  // less is what two poses that are equally good may differ by
    const auto FitnessAt = [&](const Pose2& pose) { return field_.Evaluate(critical_rays, pose, geometry); };
    const bool known = history.back().state == MatchState::kOk;
    if (!known || FitnessAt(*by_odometry) > kClearly * FitnessAt(repeated)) presumed = *by_odometry;
  }
  // On a finished map it may be that nobody knows where the robot is, nor what fitness is usual there.
  const bool finished = IsFinishedMap(history);
  double usual = ComputeUsualFitness(history);
  const bool unknown = finished && usual == 0.0;
  const bool everywhere = IsGlobalSearchDue(history) && !(first && parameters_.start);
  if (everywhere) {
    const GlobalMatch found = SearchWholeMap(map_, field_, hits_m, critical_hits_m, geometry);
    match.evaluations = found.evaluations;
    if (!found.IsConvincing()) return match;
    presumed = found.T_map_laser;
  } else if (unknown && !first) {
    return match;
  }
  constexpr double kUsualFitness = 0.6;  // of a map that is of the same building still
  if (unknown) usual = kUsualFitness;

  // Where the walls do not tell, as along a corridor, the presumed pose does.
  double pull_per_m2 = parameters_.pull_per_m2;
  const auto Fitness = [&](const RaysInCells& seen, const Pose2& pose) {
    const double dx_m = pose.x_m - presumed.x_m;
    const double dy_m = pose.y_m - presumed.y_m;
    return field_.Evaluate(seen, pose, geometry) - pull_per_m2 * (dx_m * dx_m + dy_m * dy_m);
  };
  const auto CriticalFitness = [&](const Pose2& pose) { return Fitness(critical_rays, pose); };

  // What a good match has: as much as usual; of a scan that looks into the unknown only what the rest can give.
  const double enough = usual > 0.0 ? parameters_.good_ratio * usual : parameters_.satisfying_fitness;
  const auto Quality = [&](const Individual& found) {
    constexpr double kMinShare = 0.8;  // who looks into nothing but the unknown has no match
    const double share = ComputeExploredShare(map_, critical_hits_m, found.pose, geometry);
    const double expected = usual * std::max(share, kMinShare);
    return expected > 0.0 ? found.fitness / expected : 1.0;
  };

  // Lost once is better than a wrong wall in the map; lost for long, the scene may have changed, and less will do. On a
  // finished map the robot was carried away.
  const int num_lost = CountLost(history, 12);
  double acceptable = parameters_.lost_ratio;
  for (int i = 0; i < std::min(num_lost, 4) && !finished; ++i) acceptable *= 0.9;

  RrhcSearch search(parameters_, CriticalFitness, Random(parameters_.seed, static_cast<std::uint64_t>(utime)));
  Individual best = everywhere ? Individual{presumed, CriticalFitness(presumed)}
                               : search.Run(presumed, {parameters_.window_m, parameters_.window_rad}, 1,
                                            parameters_.num_evaluations, enough);
  if (!everywhere && Quality(best) < acceptable) {
    // The robot turned or was pushed: look further, and presume nothing. Lost for a scan or two, as when people pass
    // close by, it cannot have gone far; lost for longer, it can.
    constexpr int kPatience = 2;
    const double scale = 1.0 + 0.25 * std::max(0, num_lost - kPatience);
    const MotionBounds wide = scale * MotionBounds{parameters_.wide_window_m, parameters_.wide_window_rad};
    constexpr int kWideDraws = 30;  // most poses in so wide a window are not worth a climb
    pull_per_m2 = 0.0;
    best.fitness = CriticalFitness(best.pose);
    const Individual other = search.Run(presumed, wide, kWideDraws, parameters_.wide_evaluations, enough);
    if (other.fitness > best.fitness && Quality(other) >= acceptable) best = other;
  }
  match.evaluations += search.evaluations();
  match.best_evaluation = search.best_evaluation();

  const RaysInCells all_rays = ToCells(hits_m, geometry, ComputeWeights(rays, parameters_.spacing_cap_m));
  const auto AllFitness = [&](const Pose2& pose) {
    ++match.evaluations;
    return Fitness(all_rays, pose);
  };
  const auto ClimbWithAll = [&](const Pose2& from) {
    return FindSummit(from, geometry.cell_size_m(), parameters_.summit_rad, AllFitness);
  };
  if (parameters_.final_climb) best.pose = ClimbWithAll(best.pose);
  PoseUncertainty uncertainty = ComputeUncertainty(hits_m, best.pose, map_, geometry);
  if (uncertainty.degenerate && parameters_.axis_window_m > 0.0) {
    // Along a corridor a pose that was presumed too far back stays there, and each one after it, unless the few rays
    // that tell better are asked by themselves. Where nothing is wrong no place is better by so much.
    constexpr double kLeastGain = 0.02;
    pull_per_m2 = 0.0;
    const Pose2 better = LookAlong(best.pose, *uncertainty.degenerate, parameters_.axis_window_m,
                                   geometry.cell_size_m(), kLeastGain, AllFitness);
    if (better != best.pose) {
      best.pose = ClimbWithAll(better);
      uncertainty = ComputeUncertainty(hits_m, best.pose, map_, geometry);
    }
  }
  best.fitness = field_.Evaluate(critical_rays, best.pose, geometry);
  match.fitness = std::clamp(best.fitness, 0.0, 1.0);
  const bool explained = everywhere || unknown ? ScorePlace(map_, field_, hits_m, best.pose, geometry) >= kLeastScore
                                               : Quality(best) >= acceptable;
  if (!explained) {
    match.T_map_laser = first ? repeated : by_odometry.value_or(history.back().T_map_laser);
    return match;
  }

  match.T_map_laser = {best.pose.x_m, best.pose.y_m, WrapAngle(best.pose.yaw_rad)};
  SetUncertainty(match, uncertainty);
  return match;
}

}  // namespace crsm
