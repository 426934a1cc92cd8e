#pragma once

#include <optional>
#include <vector>

#include "common/graph/keyframe_graph.hpp"
#include "common/graph/loop_closer.hpp"
#include "common/map/byte_map.hpp"
#include "common/map/map_updater.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Draws the map that scans are matched to: without loops all that was seen, as MapUpdater does; with loops the *local
/// map*, what was drawn from keyframes within some way of the robot along the pose graph. What lies nearby on paper but
/// far in the graph may be metres off, and would draw the robot onto wrong walls.
///
/// With loops each scan hangs on its keyframe, so that its pose is put right with that of the keyframe.
class Mapper {
 public:
  Mapper(const UpdateParameters& drawing, const LoopParameters& loops);

  struct Step {
    MapDelta delta;                      ///< of the local map
    const Keyframe* keyframe = nullptr;  ///< what the scan has become, with loops; valid until the next call
  };

  /// Draws a scan as MapUpdater::Update and UpdateWithoutScan do. scan: nullptr where there is none to draw.
  Step Integrate(const CriticalRays* scan, const ScanMatch& match);

  /// What an update has changed.
  struct Correction {
    std::vector<TileChange> tiles;  ///< of the local map, in the version that there is
    Pose2 T_new_old;                ///< by which the robot and the map around it have moved
  };

  /// Puts right what a keyframe has shown to be wrong. Nothing if it has not.
  std::optional<Correction> Apply(const GraphUpdate& update);

  /// The map is finished: it is all that was seen, and stays as it is. Returns what that changes.
  std::vector<TileChange> Finish();

  const MapUpdater& local() const { return local_; }
  const KeyframeGraph& graph() const { return graph_; }

  /// All that was seen, where it belongs by a graph that knows more; with loops only.
  ByteMap DrawWhole(const KeyframeGraph& graph) const;

  /// T_map_laser of all scans so far, where they belong by such a graph.
  std::vector<Pose2> CorrectedPoses(const KeyframeGraph& graph) const;

 private:
  struct Anchored {
    int keyframe;
    Pose2 T_keyframe_laser;
  };

  void AddKeyframe(const ValidRays& rays, const ScanMatch& match);
  std::optional<Tie> FindTie(const Pose2& T_map_laser) const;
  std::vector<TileChange> Draw(const std::vector<int>& keyframes);
  std::vector<int> FindLocal() const;

  UpdateParameters drawing_;
  LoopParameters loops_;
  MapUpdater local_;
  KeyframeGraph graph_;
  std::vector<int> drawn_;    ///< keyframes in the local map
  double looked_at_m_ = 0.0;  ///< where on the path it was last looked which belong there
  bool lost_since_ = false;   ///< scans were, since the newest keyframe
  std::vector<Anchored> scans_;
};

}  // namespace crsm
