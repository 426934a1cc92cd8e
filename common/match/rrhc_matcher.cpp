#include "common/match/rrhc_matcher.hpp"

#include <algorithm>

#include "common/match/fit/objective.hpp"
#include "common/match/fit/optimum.hpp"
#include "common/match/fit/pose_uncertainty.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/guess/motion_prediction.hpp"
#include "common/match/judge/census.hpp"
#include "common/match/judge/known_rays.hpp"
#include "common/match/search/map_search.hpp"
#include "common/math/columns.hpp"
#include "common/scan/contour.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

/// Whether a scan is to be looked for on all of a finished map: the first ones until one is found, later every tenth
/// after ten were lost in a row. A robot that was not found in a hundred is likely nowhere on the map: it is searched
/// more and more seldom.
bool IsGlobalSearchDue(const TrackingState& tracking, const MatchConstants::FinishedMap& constants) {
  if (!tracking.on_finished_map()) return false;
  const std::int64_t every = constants.search_every, num_lost = tracking.num_lost();
  if (tracking.num_scans() < every) return num_lost == tracking.num_scans();
  const std::int64_t more_seldom = std::clamp<std::int64_t>(num_lost / (every * every), 1, every);
  return num_lost > 0 && num_lost % (every * more_seldom) == 0;
}

/// Whether scans follow each other so seldom that a robot may have gone further between them than random climbs find.
bool IsSparse(std::span<const ScanMatch> recent, std::int64_t utime, const MatchConstants::MapSearch& constants) {
  if (recent.size() < 2 || recent.back().state == MatchState::kLost) return false;
  const auto Since = [](std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); };
  const double usual_s = Since(recent.front().utime, recent.back().utime) / static_cast<double>(recent.size() - 1);
  return Since(recent.back().utime, utime) >= constants.close_s && usual_s >= constants.close_s;
}

/// How strongly the wheels hold along an axis that the walls leave open [1/m^2].
double FindPriorWeight(const WheelMotion& way, const MatchConstants::MotionPrior& constants) {
  return constants.wheels_per_sigma2 / (way.sigma_m * way.sigma_m);
}

/// How strongly the velocity model holds along an axis that the walls leave open [1/m^2]: the better it told the
/// motions so far, the more. A robot that drives evenly would else seem to slow down in a corridor whose end no beam
/// reaches.
double FindPriorWeight(const TrackingState& tracking, const MatchConstants::MotionPrior& constants) {
  const double by_error_per_m2 = constants.degenerate_per_m / std::max(tracking.motion_error_m(), 1e-6);
  return std::max(constants.degenerate_per_m2, std::min(by_error_per_m2, constants.degenerate_max_per_m2));
}

/// Whether a robot that is followed may have come from one pose to another.
bool IsNear(const Pose2& from, const Pose2& to, const MatchConstants::Search& constants) {
  return Distance(from, to) < constants.window_m &&
         std::abs(WrapAngle(to.yaw_rad - from.yaw_rad)) < constants.window_rad;
}

/// The pose that is as far along an axis as the initial guess.
Pose2 MoveBackAlong(const Eigen::Vector2d& axis, const Pose2& pose, const Pose2& initial_guess) {
  const Eigen::Vector2d step_m = WayFrom(pose, initial_guess).dot(axis) * axis;
  return {pose.x_m + step_m.x(), pose.y_m + step_m.y(), pose.yaw_rad};
}

}  // namespace

/// The rays of a scan, as the steps need them.
struct RrhcMatcher::Rays {
  Rays(const CriticalRays& scan, const ScoredMap& map, const MatchConstants& constants)
      : hits_m(ComputeHits(scan.rays)),
        gaps(hits_m),
        normals(ComputeNormals(hits_m, gaps, map.geometry().cell_size_m(), constants.uncertainty)),
        critical_hits_m(SelectColumns(hits_m, scan.critical)),
        critical(ToCells(critical_hits_m, map.geometry())),
        contour(TraceContour(scan.rays, hits_m, gaps, constants.final_climb.spacing_max_m)),
        all(ToCells(contour.points_m, map.geometry(), contour.weights)) {}

  Eigen::Matrix2Xd hits_m;           ///< laser frame
  Gaps gaps;                         ///< between the hits
  Eigen::Matrix2Xd normals;          ///< of the surfaces on which they lie, laser frame
  Eigen::Matrix2Xd critical_hits_m;  ///< laser frame
  RaysInCells critical;
  Contour contour;  ///< the hits and points between them, weighted by their spacing
  RaysInCells all;  ///< that contour
};

/// Where the laser is by what is known without the scan.
struct RrhcMatcher::Guess {
  Pose2 by_motion;                 ///< the start, the last pose, or the last motions repeated
  std::optional<Pose2> by_wheels;  ///< where the wheels are believed
  std::optional<WheelMotion> way;  ///< ... their motion since the last scan that was matched

  Pose2 best() const { return by_wheels.value_or(by_motion); }
};

/// Where the search begins.
struct RrhcMatcher::InitialGuess {
  Pose2 T_map_laser;
  bool by_wheels = false;                   ///< it is the wheels' pose
  std::optional<Pose2> by_reliable_wheels;  ///< that pose, whether or not it is guessed
  std::optional<WheelMotion> way;           ///< of the wheels, as of Guess
  bool by_first_scan = false;               ///< no motion is known yet
  bool known = true;                        ///< false: the robot may be anywhere, and was not found
  bool found_on_whole_map = false;          ///< nothing is left to be searched
  Pose2 if_lost;                            ///< the guess that a lost scan gets
  double degenerate_per_m2 = 0.0;           ///< how strongly it holds along an axis that the walls leave open
  int evaluations = 0;
};

/// What the search found.
struct RrhcMatcher::Found {
  Pose2 pose;
  Pose2 initial_guess;
  bool is_near_guess = true;  ///< false where a window was searched, unless what is near explains the scan
  int evaluations = 0;
  int best_evaluation = 0;
};

/// Where the laser is held along an axis.
struct RrhcMatcher::AxisHold {
  Pose2 T_map_laser;
  std::optional<WheelMotion> way;  ///< where the wheels hold it
};

struct RrhcMatcher::Refined {
  Pose2 pose;
  bool is_near_guess = true;  ///< as of Found
  PoseUncertainty uncertainty;
  int evaluations = 0;
};

/// wide: the wider window is searched, where nothing fits near the guess.
ScanMatch RrhcMatcher::Match(const CriticalRays& scan, const TrackingState& tracking,
                             const std::optional<Pose2>& T_odom_robot, bool wide) const {
  ScanMatch match;
  match.utime = scan.utime;
  match.num_critical = static_cast<std::int32_t>(scan.critical.size());
  match.T_odom_robot = T_odom_robot;
  if (map_.cells().empty()) return match;

  match.state = MatchState::kLost;
  const Guess guess = GuessPose(tracking, scan.utime, match.T_odom_robot);
  match.T_map_laser = guess.best();
  if (scan.critical.empty()) return match;

  const Rays rays(scan, map_, constants_);
  const InitialGuess initial_guess = MakeInitialGuess(rays, guess, tracking);
  match.evaluations = initial_guess.evaluations;
  if (!initial_guess.known) return match;

  const Found found = Search(rays, initial_guess, tracking, scan.utime, wide);
  const Refined refined =
      Refine(rays, found, initial_guess, ComputeSteadiness(tracking.recent(), scan.utime, constants_.prior));
  match.evaluations += found.evaluations + refined.evaluations;
  match.best_evaluation = found.best_evaluation;
  Judge(rays, guess, initial_guess, refined, tracking, match);
  return match;
}

std::optional<Pose2> RrhcMatcher::Locate(const CriticalRays& scan) const {
  const Eigen::Matrix2Xd hits_m = ComputeHits(scan.rays);
  const FoundOnMap found = SearchWholeMap(map_, hits_m, constants_);
  return found.IsConvincing(constants_.map_search) ? std::optional(found.T_map_laser) : std::nullopt;
}

RrhcMatcher::Guess RrhcMatcher::GuessPose(const TrackingState& tracking, std::int64_t utime,
                                          const std::optional<Pose2>& T_odom_robot) const {
  Guess guess;
  if (tracking.empty()) {
    guess.by_motion = parameters_.start.value_or(Pose2{});
    return guess;
  }
  const auto recent = tracking.recent();
  guess.by_motion = PredictPose(recent, constants_.prediction);
  const auto step = tracking.wheels().Predict(recent, utime, T_odom_robot);
  if (!step) return guess;
  guess.by_wheels = recent.back().T_map_laser * step->T_from_to;
  guess.way = FindWayByWheels(recent, step);
  return guess;
}

/// Whether the wheels' pose is guessed: where it fits no worse than that of the velocity model, or the walls did not
/// tell how far the robot went before.
bool RrhcMatcher::PrefersWheels(const Rays& rays, const Guess& guess, const TrackingState& tracking) const {
  if (tracking.recent().back().state != MatchState::kOk) return true;
  return map_.Fitness(rays.critical, *guess.by_wheels) >= map_.Fitness(rays.critical, guess.by_motion);
}

/// Step 1. "The presumed new robot transformation" of section 5.3, and on a finished map a search of all of it.
RrhcMatcher::InitialGuess RrhcMatcher::MakeInitialGuess(const Rays& rays, const Guess& guess,
                                                        const TrackingState& tracking) const {
  InitialGuess initial_guess;
  initial_guess.T_map_laser = guess.by_motion;
  initial_guess.degenerate_per_m2 = FindPriorWeight(tracking, constants_.prior);
  initial_guess.if_lost =
      tracking.empty() ? guess.by_motion : guess.by_wheels.value_or(tracking.recent().back().T_map_laser);
  if (guess.by_wheels && PrefersWheels(rays, guess, tracking)) {
    initial_guess.T_map_laser = *guess.by_wheels;
    initial_guess.by_wheels = true;
  }
  if (guess.way && tracking.wheels().IsReliable()) initial_guess.by_reliable_wheels = guess.by_wheels;
  initial_guess.way = guess.way;
  initial_guess.by_first_scan = tracking.recent().size() < 2;
  const bool start_is_told = tracking.empty() && parameters_.start;
  if (IsGlobalSearchDue(tracking, constants_.finished_map) && !start_is_told) {
    const FoundOnMap found = SearchWholeMap(map_, rays.hits_m, constants_);
    initial_guess.evaluations = found.evaluations;
    initial_guess.found_on_whole_map = found.IsConvincing(constants_.map_search);
    if (initial_guess.found_on_whole_map) initial_guess.T_map_laser = found.T_map_laser;
  }
  const bool is_placed = initial_guess.found_on_whole_map || start_is_told;
  initial_guess.known = is_placed || !Expectation(tracking, constants_).unknown();
  return initial_guess;
}

/// Step 2. Section 5.3 with the critical rays, where the robot is guessed; while it is lost it stands still. Where
/// nothing fits there, a search of a window around it.
RrhcMatcher::Found RrhcMatcher::Search(const Rays& rays, const InitialGuess& initial_guess,
                                       const TrackingState& tracking, std::int64_t utime, bool wide) const {
  const Pose2& start = initial_guess.T_map_laser;
  if (initial_guess.found_on_whole_map) return {start, start, true, 0, 0};

  const Expectation expected(tracking, constants_);
  const auto Explains = [&](const ScoredPose& pose) {
    return expected.IsMetBy(pose, false, rays.critical_hits_m, map_.cells());
  };
  Random random(parameters_.seed, static_cast<std::uint64_t>(utime));
  const MatchConstants::Search& search = constants_.search;
  const MotionBounds window{search.window_m, search.window_rad};
  const auto SearchAround = [&](const Pose2& around) {
    const Objective objective{map_, rays.critical, around, constants_.prior.per_m2};
    return RrhcSearch(search, objective, random)
        .Run({around, window, search.restart_draws, search.num_evaluations, expected.enough()});
  };
  const SearchResult near = SearchAround(start);
  const bool explains = Explains(near.best);
  const bool is_sparse = !initial_guess.by_wheels && IsSparse(tracking.recent(), utime, constants_.map_search);
  const bool may_be_elsewhere = is_sparse && near.best.fitness < expected.enough();
  if (explains && !may_be_elsewhere) return {near.best.pose, start, true, near.evaluations, near.best_evaluation};

  // The robot turned, was pushed, or went further than random climbs find.
  int evaluations = near.evaluations;
  if (wide || is_sparse) {
    const auto [reach_m, reach_rad] = FindReach(tracking.recent(), utime, constants_.map_search);
    const FoundOnMap found = SearchMap(map_, rays.hits_m, {start, reach_m, reach_rad}, constants_);
    evaluations += found.evaluations;
    if (found.score > 0.0) {
      const SearchResult there = SearchAround(found.T_map_laser);
      evaluations += there.evaluations;
      if (there.best.fitness > near.best.fitness && Explains(there.best)) {
        return {there.best.pose, found.T_map_laser, false, evaluations, near.evaluations + there.best_evaluation};
      }
    }
  }
  const bool is_near_guess = explains || expected.IsMetBy(near.best, true, rays.critical_hits_m, map_.cells());
  return {near.best.pose, start, is_near_guess, evaluations, near.best_evaluation};
}

/// The rays that are known around a pose; all rays where those are too few to say where the laser is.
RaysInCells RrhcMatcher::SelectKnown(const Rays& rays, const Pose2& pose, const DegenerateAxis& axis) const {
  const double cell_size_m = map_.geometry().cell_size_m();
  RaysInCells selected =
      SelectRays(map_, rays.contour, FindKnownRays(map_.cells(), rays.contour.points_m, pose, axis, cell_size_m));
  const auto least = constants_.final_climb.known_share_min * static_cast<double>(rays.all.total_weight());
  return static_cast<double>(selected.total_weight()) > least ? selected : rays.all;
}

/// What holds along an axis that the walls leave open: wheels that are reliable, if the search ended near them, or what
/// was guessed.
RrhcMatcher::AxisHold RrhcMatcher::FindHold(const Found& found, const InitialGuess& initial_guess,
                                            bool degenerate) const {
  const auto& wheels = initial_guess.by_reliable_wheels;
  if (degenerate && wheels && Distance(*wheels, found.pose) < constants_.prior.wheels_near_m)
    return {*wheels, initial_guess.way};
  const bool by_wheels = initial_guess.by_wheels && found.initial_guess == initial_guess.T_map_laser;
  return {found.initial_guess, by_wheels ? initial_guess.way : std::nullopt};
}

/// Step 3. A climb with all rays, weighted by their spacing, to a fraction of a cell. Along an axis that the walls
/// leave open the initial guess holds in a second one, as far as the motion is steady, unless another look finds what
/// they do tell.
RrhcMatcher::Refined RrhcMatcher::Refine(const Rays& rays, const Found& found, const InitialGuess& initial_guess,
                                         double steadiness) const {
  Refined refined{found.pose, found.is_near_guess, {}, 0};
  const double cell_size_m = map_.geometry().cell_size_m();
  const auto Climb = [&](const Pose2& from, const Objective& objective) {
    const auto Differentiate = [&](const Pose2& pose) {
      ++refined.evaluations;
      return objective.Differentiate(pose);
    };
    refined.pose =
        FindOptimum(from, cell_size_m, constants_.final_climb.optimum_rad, Differentiate, constants_.optimum);
    refined.uncertainty =
        ComputeUncertainty(rays.hits_m, rays.normals, refined.pose, map_.cells(), constants_.uncertainty);
  };
  const Objective all_rays{map_, rays.all, found.initial_guess, found.is_near_guess ? constants_.prior.per_m2 : 0.0};
  if (!found.is_near_guess) {
    // Newton's method climbs the hill on which it begins. In the wide window the search ends some cells beside it.
    const auto Evaluate = [&](const Pose2& pose) {
      ++refined.evaluations;
      return all_rays(pose);
    };
    refined.pose = ClimbToOptimum(found.pose, cell_size_m, constants_.optimum.longest_step_rad, 1, Evaluate).pose;
  }
  Climb(refined.pose, all_rays);
  const PoseUncertainty& known = refined.uncertainty;
  const AxisHold hold = FindHold(found, initial_guess, known.degenerate());
  const auto AxisNow = [&] {
    return DegenerateAxis{known.degenerate_axis, hold.way.has_value(), constants_.known_rays, constants_.census};
  };
  const bool holds = found.is_near_guess && known.degeneracy > constants_.prior.degeneracy_min &&
                     Distance(found.pose, found.initial_guess) <= constants_.search.window_m;
  if (holds) {
    const DegenerateAxis axis = AxisNow();
    const double openness = std::min(known.degeneracy, 1.0);
    const double by_motion_per_m2 = initial_guess.degenerate_per_m2;
    const double per_m2 = hold.way ? std::max(FindPriorWeight(*hold.way, constants_.prior), by_motion_per_m2)
                                   : steadiness * by_motion_per_m2;
    const Pose2 begin = MoveBackAlong(axis.direction, refined.pose, hold.T_map_laser);
    const RaysInCells known_rays = SelectKnown(rays, begin, axis);
    Climb(begin, {map_, known_rays, hold.T_map_laser, constants_.prior.per_m2, axis.direction, openness * per_m2});
  }
  if (!known.degenerate()) return refined;

  // A robot that has become faster or slower is guessed at the wrong place, scan after scan: look without the prior.
  const MatchConstants::FinalClimb& constants = constants_.final_climb;
  const Objective free{map_, rays.all, found.initial_guess, 0.0};
  const Pose2 here = refined.pose;
  const double as_known_within_m = (constants.look_same_rays_cells + 0.5) * cell_size_m;
  FitGain gain(map_, rays.contour, AxisNow(), here);
  const double reach_m = initial_guess.by_first_scan ? constants.look_along_first_m : constants_.search.window_m;
  const Pose2 better =
      LookAlong(here, known.degenerate_axis, reach_m, cell_size_m, constants.look_gain, [&](const Pose2& there) {
        refined.evaluations += 2;
        return gain.Near(there, as_known_within_m);
      });
  const bool surely = better != here && gain.At(better) > constants.look_gain;
  if (surely) Climb(better, free);
  return refined;
}

/// Whether a match is far from where the wheels say, which were right so far.
bool RrhcMatcher::ContradictsWheels(const Guess& guess, const Pose2& T_map_laser, const TrackingState& tracking) const {
  const MatchConstants::Wheels& constants = constants_.wheels;
  if (!guess.way || !tracking.wheels().IsReliable()) return false;
  const Pose2 off = Inverse(*guess.by_wheels) * T_map_laser;
  const double sigmas = constants_.wheel_model.slip;
  return Length(off) > sigmas * guess.way->sigma_m + constants.match_error_m ||
         std::abs(off.yaw_rad) > sigmas * guess.way->sigma_rad + constants.match_error_rad;
}

/// Step 4. What the critical rays say there decides; where nobody knew where the robot is, all rays and their ways. On
/// a finished map those have a say in every scan: a place that was found wrongly must not live on by its own low
/// fitness.
void RrhcMatcher::Judge(const Rays& rays, const Guess& guess, const InitialGuess& initial_guess, const Refined& refined,
                        const TrackingState& tracking, ScanMatch& match) const {
  const MatchConstants::FinishedMap& finished_map = constants_.finished_map;
  const Expectation expected(tracking, constants_);
  const double fitness = map_.Fitness(rays.critical, refined.pose);
  match.fitness = std::clamp(fitness, 0.0, 1.0);
  const auto Score = [&] { return ScorePlace(map_, rays.hits_m, refined.pose, constants_); };
  const bool explained =
      initial_guess.found_on_whole_map || expected.unknown()
          ? Score() >= constants_.map_search.least_found_score
          : expected.IsMetBy({refined.pose, fitness}, refined.is_near_guess, rays.critical_hits_m, map_.cells()) &&
                (!tracking.on_finished_map() ||
                 Score() >= (expected.followed() && IsNear(initial_guess.if_lost, refined.pose, constants_.search)
                                 ? finished_map.least_followed_score
                                 : finished_map.least_tracked_score));
  match.T_map_laser = initial_guess.if_lost;
  if (!explained) return;
  const bool is_proven = fitness >= constants_.wheels.proven * tracking.baseline_fitness();
  if (!is_proven && ContradictsWheels(guess, refined.pose, tracking)) return;

  match.T_map_laser = {refined.pose.x_m, refined.pose.y_m, WrapAngle(refined.pose.yaw_rad)};
  const Eigen::Matrix3d& c = refined.uncertainty.covariance;
  match.covariance = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
  match.state = MatchState::kOk;
  if (refined.uncertainty.degenerate()) {
    match.state = MatchState::kDegenerate;
    match.degenerate_axis = {refined.uncertainty.degenerate_axis.x(), refined.uncertainty.degenerate_axis.y()};
  }
}

}  // namespace crsm
