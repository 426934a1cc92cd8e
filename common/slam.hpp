#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/graph/loop_closer.hpp"
#include "common/graph/mapper.hpp"
#include "common/match/matcher.hpp"
#include "common/parameters.hpp"
#include "common/scan/ray_selector.hpp"

namespace crsm {

/// The whole algorithm in one process. Without loops: what the five processes do together, step by step and bit for
/// bit.
class Slam {
 public:
  /// With the RrhcMatcher.
  explicit Slam(const Parameters& parameters);
  /// With another one.
  Slam(const Parameters& parameters, const MakeMatcher& make_matcher);

  /// What became of a scan.
  struct Step {
    CriticalRays scan;
    ScanMatch match;
    bool drawn = false;  ///< into the map
  };

  /// Selects the critical rays of a scan, matches them to the map so far, and draws the scan into the map.
  /// Scans come in the order in which they were taken; no utime may come twice. T_odom_robot: the odometry of the scan,
  /// where there is some.
  Step Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot = std::nullopt);

  /// Draws a matched scan into the map and remembers the match; true if the map was drawn. Also for scans of an earlier
  /// session, nullptr where one was not drawn: all of them one after the other make the same map, and the next scan is
  /// matched as it would have been then.
  bool Integrate(const CriticalRays* scan, const ScanMatch& match);

  /// Finishes the map: from now on scans are localised on it and change nothing. Where the first of them was taken is
  /// searched on the whole map.
  void FinishMap();

  /// Whether loops are looked for: not on a finished map.
  bool closes_loops() const { return loops_.loops && !tracking_.on_finished_map(); }

  /// The map that the next scan is matched to.
  const ByteMap& map() const { return matcher_->map(); }
  const TrackingState& tracking() const { return tracking_; }
  std::int64_t map_version() const { return mapper_.local().version(); }
  /// As of MapUpdater; with loops of the local map.
  std::int64_t num_scans_cut() const { return mapper_.local().num_scans_cut(); }

  /// With loops: all that is known when no more scans come.
  struct Outcome {
    ByteMap map;               ///< all that was seen
    std::vector<Pose2> poses;  ///< T_map_laser of all scans integrated
    KeyframeGraph graph;
  };
  Outcome Conclude() const;

 private:
  void CloseLoops(const Keyframe& keyframe);

  LoopParameters loops_;
  RaySelector selector_;
  std::unique_ptr<Matcher> matcher_;
  Mapper mapper_;
  LoopCloser loop_closer_;
  std::deque<GraphUpdate> updates_;  ///< that have not taken effect yet
  TrackingState tracking_;
};

}  // namespace crsm
