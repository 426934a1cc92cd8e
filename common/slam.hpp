#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/graph/background_loop_closer.hpp"
#include "common/graph/mapper.hpp"
#include "common/match/default_matcher.hpp"
#include "common/match/match_scan.hpp"
#include "common/match/matcher.hpp"
#include "common/parameters.hpp"
#include "common/scan/ray_selector.hpp"

namespace crsm {

/// The whole algorithm in one process: what the processes do together, step by step and bit for bit.
class Slam {
 public:
  /// Selection, matcher and loop closer of others; ours where they are empty.
  struct Parts {
    SelectCritical select = {};
    MakeMatcher make_matcher = {};
    MakeLoopCloser make_loop_closer = {};
  };

  /// Of our parts and those of the paper, for tests and studies.
  struct Constants {
    SelectionConstants selection = {};
    MatchConstants match = {};
    DrawingConstants drawing = {};
    GraphConstants graph = {};
    PaperMatchConstants paper_match = {};
    PaperDrawingConstants paper_drawing = {};
  };

  explicit Slam(const Parameters& parameters) : Slam(parameters, Parts{}, Constants{}) {}
  Slam(const Parameters& parameters, const Parts& parts) : Slam(parameters, parts, Constants{}) {}
  Slam(const Parameters& parameters, const Parts& parts, const Constants& constants);

  /// What became of a scan.
  struct Step {
    CriticalRays scan;
    ScanMatch match;
    bool drawn = false;                ///< into the map
    std::vector<GraphUpdate> updates;  ///< of the graph: what loops that were found some keyframes ago have brought
  };

  /// Selects the critical rays of a scan, matches them to the map so far, and draws the scan into the map.
  /// Scans come in the order in which they were taken; no utime may come twice. T_odom_robot: the odometry of the scan,
  /// where there is some.
  Step Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot = std::nullopt);

  /// A matched scan of an earlier session, nullptr where it was not drawn: all of them one after the other make the
  /// same map, and the next scan is matched as it would have been then. With loops the map is drawn by AwaitLoops, or
  /// before the next scan.
  bool Restore(const CriticalRays* scan, const ScanMatch& match);

  /// What was known of the graph in the earlier session, between its scans as it was then. False if it does not fit
  /// them.
  bool Restore(const GraphUpdate& update);

  /// After the scans of an earlier session: the next one is the first of this session.
  /// T_map_laser: about where the robot stands now; else it may stand where the earlier session ended.
  void Resume(const std::optional<Pose2>& T_map_laser = std::nullopt);

  /// Another drive begins with the next scan: the robot may be anywhere. A trajectory begins; on a finished map the
  /// whole map is searched.
  void BeginDrive();

  /// Up to a keyframe of the earlier session all loops were found: they are not searched again.
  bool RestoreSearched(KeyframeId keyframe);

  /// To be called where an earlier session ends, and where this one does: waits until all loops are found that the
  /// scans so far close. What that brings to the graph. give_up: asked now and then; where it says so, what was found
  /// until then is returned, and the rest is searched by the next call.
  std::vector<GraphUpdate> AwaitLoops(const BackgroundLoopCloser::GiveUp& give_up = {});

  /// Finishes the map: from now on scans are localised on it and change nothing. Where the first of them was taken is
  /// searched on the whole map. give_up: as of AwaitLoops; the map lacks loops then.
  void FinishMap(const BackgroundLoopCloser::GiveUp& give_up = {});

  /// Whether loops are looked for: not on a finished map.
  bool closes_loops() const { return mapper_.closes_loops(); }

  /// The map that the next scan is matched to.
  const ByteMap& map() const { return matcher_->map(); }
  /// With loops: what was taken up.
  const KeyframeGraph& graph() const { return mapper_.graph(); }
  /// With loops: all that is known.
  KeyframeGraph MakeBestGraph() const { return mapper_.MakeBestGraph(); }
  /// As of Mapper.
  Pose2 BestPose(std::int64_t scan, const Pose2& T_map_laser) const { return mapper_.BestPose(scan, T_map_laser); }
  const TrackingState& tracking() const { return tracking_; }
  /// Keyframes at which loops were searched: of an earlier session only those of which it did not tell what was found.
  std::int64_t num_searched() const { return num_searched_; }
  /// With loops: how the map hangs together.
  const Mapper& mapper() const { return mapper_; }
  std::int64_t map_version() const { return mapper_.local().version(); }
  /// As of MapUpdater; with loops of the local map.
  std::int64_t num_scans_cut() const { return mapper_.local().num_scans_cut(); }

  /// With loops: all that is known when no more scans come.
  struct Outcome {
    ByteMap map;  ///< all that was seen by the component with the most keyframes
    KeyframeGraph graph;
    std::vector<PlacedLoop> loops;
  };
  /// matches: of all scans, in their order; each is moved to where it belongs. Those of other components float.
  Outcome Finalize(std::span<ScanMatch> matches);
  /// With loops, after Finalize: all that was seen on the piece of that number, as of Mapper::FindComponent.
  ByteMap DrawPiece(int number) const;

 private:
  bool Take(const Mapper::Step& step, const ScanMatch& match);
  void DrawRestored();
  void SearchUpTo(std::optional<KeyframeId> last, const GraphUpdate* update = nullptr,
                  const BackgroundLoopCloser::GiveUp& give_up = {});
  std::vector<GraphUpdate> AcceptFound(int num_left, const BackgroundLoopCloser::GiveUp& give_up = {});

  DrawingRules drawing_;
  MatchOptions matching_;
  RaySelector selector_;
  std::unique_ptr<Matcher> matcher_;
  Mapper mapper_;
  std::unique_ptr<BackgroundLoopCloser> loop_closer_;
  std::optional<KeyframeId> given_;  ///< the newest keyframe that the loop closer has
  std::int64_t num_searched_ = 0;
  TrackingState tracking_;
};

}  // namespace crsm
