#pragma once

#include <optional>
#include <span>

#include "common/match/fit/scored_map.hpp"
#include "common/match/judge/expectation.hpp"
#include "common/match/judge/known_rays.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/matcher.hpp"
#include "common/match/search/rrhc_search.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// Finds the pose of a scan on the map by random restart hill climbing. Source: section 5, and what was added to it: an
/// initial guess from the last motions or odometry, a wider search where the first one fails, a climb with all rays,
/// and the courage to say that a scan is lost.
class RrhcMatcher : public Matcher {
 public:
  RrhcMatcher(const MatchParameters& parameters, double cell_size_m, const MatchConstants& constants = {})
      : parameters_(parameters), constants_(constants), map_(cell_size_m) {}

  bool Apply(std::span<const TileChange> changes) override { return map_.Apply(changes); }

  /// When the map is empty the scan becomes the origin of the map frame. Otherwise four steps:
  ///
  /// 1. Guess where the robot may be: by the velocity model, or by odometry where that fits clearly better, or the
  ///    last scan was lost or left open how far the robot went. On a map that was there before the first scan: at the
  ///    start that the parameters name, or where a search of the whole map finds the first scan, and again after ten
  ///    scans were lost in a row.
  /// 2. Search there by RRHC with the critical rays, short where the first climbs fit as well as the last scans did; in
  ///    a wider window where nothing fits.
  /// 3. Refine with all rays; where the walls leave the position open along an axis, a pose along it that fits clearly
  ///    better is taken instead.
  /// 4. Judge: OK, DEGENERATE (open along an axis), or LOST: nothing explains the scan, or it has no rays. Its pose is
  ///    then a guess, the last one or by odometry.
  ///
  /// The match keeps T_odom_robot for the next one.
  ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking,
                  const std::optional<Pose2>& T_odom_robot) const override {
    return Match(scan, tracking, T_odom_robot, true);
  }

  /// Without the wider window.
  ScanMatch MatchNear(const CriticalRays& scan, const TrackingState& tracking,
                      const std::optional<Pose2>& T_odom_robot) const override {
    return Match(scan, tracking, T_odom_robot, false);
  }

  /// By a search of the whole map: a fifth of a second in an office building, more than one where much is alike.
  std::optional<Pose2> Locate(const CriticalRays& scan) const override;

  const ByteMap& map() const override { return map_.cells(); }

 private:
  struct Rays;
  struct Guess;
  struct InitialGuess;
  struct Found;
  struct AxisHold;
  struct Refined;

  ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking, const std::optional<Pose2>& T_odom_robot,
                  bool wide) const;
  Guess GuessPose(const TrackingState& tracking, std::int64_t utime, const std::optional<Pose2>& T_odom_robot) const;
  bool PrefersWheels(const Rays& rays, const Guess& guess, const TrackingState& tracking) const;
  InitialGuess MakeInitialGuess(const Rays& rays, const Guess& guess, const TrackingState& tracking) const;
  Found Search(const Rays& rays, const InitialGuess& initial_guess, const TrackingState& tracking, std::int64_t utime,
               bool wide) const;
  RaysInCells SelectKnown(const Rays& rays, const Pose2& pose, const DegenerateAxis& axis) const;
  AxisHold FindHold(const Found& found, const InitialGuess& initial_guess, bool degenerate) const;
  Refined Refine(const Rays& rays, const Found& found, const InitialGuess& initial_guess, double steadiness) const;
  bool ContradictsWheels(const Guess& guess, const Pose2& T_map_laser, const TrackingState& tracking) const;
  void Judge(const Rays& rays, const Guess& guess, const InitialGuess& initial_guess, const Refined& refined,
             const TrackingState& tracking, ScanMatch& match) const;

  MatchParameters parameters_;
  MatchConstants constants_;
  ScoredMap map_;
};

}  // namespace crsm
