#include "common/match/match_constants.hpp"

#include <functional>
#include <string>
#include <vector>

#include "catch.hpp"
#include "common/match/fit/optimum.hpp"
#include "common/match/fit/pose_uncertainty.hpp"
#include "common/match/guess/guess_covariance.hpp"
#include "common/match/guess/motion_prediction.hpp"
#include "common/match/judge/census.hpp"
#include "common/match/judge/known_rays.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "common/match/search/map_search.hpp"
#include "common/match/sweep.hpp"
#include "common/scan/hits.hpp"
#include "common/slam.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
const Pose2 kPlace{0.5, 0.5, 1.0};

/// One constant is varied, and something is computed by the struct that it belongs to.
struct Case {
  std::string name;
  std::function<void(MatchConstants&)> vary;
  std::function<double(const MatchConstants&)> compute;
};

ScanMatch MatchedX(std::int64_t utime, double x_m, const std::optional<Pose2>& T_odom_robot = std::nullopt) {
  ScanMatch match = MatchedAt(utime, {x_m, 0.0, 0.0});
  match.T_odom_robot = T_odom_robot;
  return match;
}

/// After scans a second apart, in which the robot drives on unevenly.
TrackingState AfterDrive(const MatchConstants& constants) {
  TrackingState tracking(constants);
  for (const double x_m : {0.0, 0.1, 0.3, 0.35, 0.6, 0.7}) {
    tracking.Add(MatchedX(tracking.num_scans() * kSecond_us, x_m, Pose2{x_m, 0.0, 0.0}));
  }
  return tracking;
}

/// A wall of one cell, 3 m ahead; free before it, unexplored behind.
ByteMap MakeWall() {
  ByteMap map(0.05);
  for (int x = 0; x <= 60; ++x) {
    for (int y = -40; y <= 40; ++y) map.Set({x, y}, x == 60 ? kOccupiedByte : kFreeByte);
  }
  return map;
}

/// A point on a map of two hits that are 1.2 m apart: what the second place scores.
double RivalOfTwo(const MatchConstants& constants) {
  const HitPyramid pyramid((Eigen::Matrix2Xd(2, 2) << 1.0, 2.2, 0.0, 0.0).finished(), 0.1);
  const Eigen::Matrix2Xd point_m = Eigen::Vector2d(1.0, 0.0);
  return FindPlace(pyramid, point_m, {{}, 2.0, 0.0}, {15.0, 0.5, 0.9, 10'000, constants.map_search.other_place}).rival;
}

const ScoredMap& Niche() {
  static const ScoredMap map(PaintMap(-1, 1, NicheByte));
  return map;
}

const Eigen::Matrix2Xd& NicheHits() {
  static const Eigen::Matrix2Xd hits_m = ComputeHits(FindValidRays(ScanNiche(kPlace), TestParameters().scan));
  return hits_m;
}

double SpectrumAt90(const MatchConstants& constants) {
  const Eigen::Matrix2Xd points_m = (Eigen::Matrix2Xd(2, 3) << 0.0, 1.0, 2.0, 0.0, 0.3, 0.0).finished();
  return ComputeLineSpectrum(points_m, constants.line_spectrum)[90];
}

/// Always 0.05 rad further than the last time; counts how often it is asked.
class TurningMatcher : public Matcher {
 public:
  bool Apply(std::span<const TileChange>) override { return true; }
  ScanMatch Match(const CriticalRays& scan, const TrackingState&, const std::optional<Pose2>&) const override {
    ScanMatch match = MatchedAt(scan.utime, {0.0, 0.0, 0.05 * ++num_asked});
    match.fitness = 1.0;
    return match;
  }
  const ByteMap& map() const override { return map_; }

  mutable int num_asked = 0;

 private:
  ByteMap map_{0.05};
};

double NumMatchesOfSweep(const MatchConstants& constants) {
  CriticalRays scan = AllRays(ScanRoom({}, 2 * kSecond_us));
  scan.rays.time_s.assign(scan.rays.size(), 0.0f);
  scan.rays.time_s.back() = 0.1f;
  TrackingState tracking;
  for (const std::int64_t tenths : {18, 19}) tracking.Add(MatchedAt(tenths * kSecond_us / 10, {}));
  const TurningMatcher matcher;
  MatchSweep(matcher, scan, tracking, std::nullopt, constants);
  return matcher.num_asked;
}

/// Fitness evaluations of the climb to an optimum.
double NumOfClimb(const MatchConstants& constants) {
  int num = 0;
  ClimbByNewton(
      {0.3, -0.2, 0.1}, 0.05,
      [&](const Pose2& pose) {
        ++num;
        const Eigen::Vector3d at(pose.x_m, pose.y_m, pose.yaw_rad);
        return FitnessDerivatives{-at.squaredNorm(), -2.0 * at, -2.0 * Eigen::Matrix3d::Identity()};
      },
      constants.optimum);
  return num;
}

const std::vector<Case> kOfFunctions{
    {"map_search", [](auto& c) { c.map_search.least_m = 0.5; },
     [](const auto& c) { return FindReach(AfterDrive({}).recent(), 6 * kSecond_us, c.map_search).reach_m; }},
    {"breaks in SearchMap", [](auto& c) { c.breaks.fewest_rays = 1000; },
     [](const auto& c) {
       return SearchMap(Niche(), NicheHits(), {kPlace, 0.5, 0.1}, c).score;
     }},
    {"map_search of another place", [](auto& c) { c.map_search.other_place.m = 9.0; }, RivalOfTwo},
    {"map_search of a whole map", [](auto& c) { c.map_search.rival_share = 0.5; },
     [](const auto& c) { return SearchWholeMap(Niche(), NicheHits(), c).evaluations; }},
    {"map_search of a convincing place", [](auto& c) { c.map_search.least_found_score = 0.7; },
     [](const auto& c) {
       return FoundOnMap{{}, 0.6, 0.0, 1}.IsConvincing(c.map_search) ? 1.0 : 0.0;
     }},
    {"census", [](auto& c) { c.census.tolerance_m = 0.4; },
     [](const auto& c) { return CountRays(MakeWall(), Eigen::Vector2d(3.3, 0.0), {}, c.census).fits; }},
    {"census in ScorePlace", [](auto& c) { c.census.tolerance_m = 0.4; },
     [](const auto& c) {
       return ScorePlace(Niche(), NicheHits(), {0.8, 0.5, 1.0}, c);
     }},
    {"known_rays", [](auto& c) { c.known_rays.behind_wall_cells = 0; },
     [](const auto& c) {
       const DegenerateAxis axis{{0.0, 1.0}, false, c.known_rays, c.census};
       return FindKnownRays(MakeWall(), Eigen::Vector2d(3.1, 0.1), {}, axis).count();
     }},
    {"census in known_rays", [](auto& c) { c.census.least_cells = 1; },
     [](const auto& c) {
       const DegenerateAxis axis{{0.0, 1.0}, false, c.known_rays, c.census};
       return FindKnownRays(MakeWall(), Eigen::Vector2d(5.0, 0.1), {}, axis).count();
     }},
    {"optimum", [](auto& c) { c.optimum.most_passes = 3; }, NumOfClimb},
    {"uncertainty", [](auto& c) { c.uncertainty.unknown_m = 2.0; },
     [](const auto& c) {
       const Eigen::Matrix2Xd none(2, 0);
       return ComputeUncertainty(none, none, {}, MakeWall(), c.uncertainty).covariance(0, 0);
     }},
    {"guess_window", [](auto& c) { c.guess_window.m = 0.9; },
     [](const auto& c) {
       ScanMatch lost = MatchedX(6 * kSecond_us, 0.7);
       lost.state = MatchState::kLost;
       return ComputeGuessCovariance(lost, AfterDrive({}), c.guess_window)[0];
     }},
    {"wheel_model", [](auto& c) { c.wheel_model.prior_noise = 0.2; },
     [](const auto& c) {
       const TrackingState tracking = AfterDrive(c);
       return tracking.wheels().Predict(tracking.recent(), 6 * kSecond_us, Pose2{0.9, 0.0, 0.0})->sigma_m;
     }},
    {"tracking", [](auto& c) { c.tracking.follow = 0.5; },
     [](const auto& c) { return AfterDrive(c).motion_error_m(); }},
    {"prediction in tracking", [](auto& c) { c.prediction.motions = 1; },
     [](const auto& c) { return AfterDrive(c).motion_error_m(); }},
    {"sweep", [](auto& c) { c.sweep.most_matches = 2; }, NumMatchesOfSweep},
    {"line_spectrum", [](auto& c) { c.line_spectrum.apart_m = 0.5; }, SpectrumAt90},
};

/// A run in the niche: it drives on, and at last sees nothing.
std::vector<Slam::Step> Run(const MatchConstants& constants) {
  Slam slam(TestParameters(), {}, {.match = constants});
  std::vector<Slam::Step> steps;
  for (int k = 0; k < 4; ++k) {
    const Pose2 robot{0.1 * k, 0.0, 0.0};
    steps.push_back(slam.Process(ScanNiche(robot, (k + 1) * kSecond_us), robot));
  }
  LaserScan blind = ScanNiche({}, 5 * kSecond_us);
  blind.ranges_m.assign(blind.ranges_m.size(), 0.0f);
  steps.push_back(slam.Process(blind));
  return steps;
}

const std::vector<Case> kOfRuns{
    {"uncertainty", [](auto& c) { c.uncertainty.map_rad = 0.05; },
     [](const auto& c) { return Run(c)[2].match.covariance[5]; }},
    {"wheel_model", [](auto& c) { c.wheel_model.prior_noise = 0.2; },
     [](const auto& c) { return Run(c)[2].match.by_wheels->sigma_m; }},
    {"guess_window", [](auto& c) { c.guess_window.m = 0.9; },
     [](const auto& c) { return Run(c)[4].match.covariance[0]; }},
    {"optimum", [](auto& c) { c.optimum.widths = 1; }, [](const auto& c) { return Run(c)[2].match.evaluations; }},
    {"tracking", [](auto& c) { c.tracking.first_motion_error_m = 0.1; },
     [](const auto& c) { return Slam(Parameters{}, {}, {.match = c}).tracking().motion_error_m(); }},
    {"tracking on a finished map", [](auto& c) { c.tracking.first_motion_error_m = 0.1; },
     [](const auto& c) {
       Slam slam(Parameters{}, {}, {.match = c});
       slam.FinishMap();
       return slam.tracking().motion_error_m();
     }},
};

}  // namespace

TEST_CASE("what is computed goes by the constants that it is given") {
  for (const std::vector<Case>& cases : {kOfFunctions, kOfRuns}) {
    for (const Case& one : cases) {
      CAPTURE(one.name);
      MatchConstants varied;
      one.vary(varied);
      CHECK(one.compute(varied) != one.compute(MatchConstants{}));
    }
  }
}

}  // namespace crsm
