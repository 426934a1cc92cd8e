#pragma once

#include <array>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/graph/background_drawing.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/loop_closer.hpp"
#include "common/graph/map_error.hpp"
#include "common/graph/moving_objects.hpp"
#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/map_updater.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/match/match_constants.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Draws the map that scans are matched to: without loops all that was seen, as MapUpdater does; with loops the *local
/// map*, what was drawn from keyframes within some way of the robot along the pose graph. What lies nearby on paper but
/// far in the graph may be metres off, and would draw the robot onto wrong walls.
///
/// What a loop has moved is drawn anew beside, while scans are matched to the map as it was; some keyframes later the
/// new map takes its place. No scan waits for drawing, and nothing depends on how fast that is.
///
/// With loops each scan hangs on its keyframe, so that its pose is corrected with that of the keyframe.
class Mapper {
 public:
  Mapper(const DrawingRules& drawing, const LoopParameters& loops, const GraphConstants& constants = {},
         const MatchConstants& match = {});

  /// Keyframes until what a loop has brought is taken up: it has to be known by then. Some more, and it takes effect.
  int lag() const { return constants_.lag; }

  struct Step {
    MapDelta delta;                      ///< of the local map
    AfterMatch after = {};               ///< by what has taken effect on it
    const Keyframe* keyframe = nullptr;  ///< what the scan has become, with loops; valid until the next call
  };

  /// Draws a scan as MapUpdater::Update and UpdateWithoutScan do. scan: nullptr where there is none to draw. Where it
  /// has become a keyframe, the updates of keyframes that are `lag` older are taken up.
  /// On known ground a scan may stay out of the map.
  Step Integrate(const CriticalRays* scan, const ScanMatch& match);
  /// The same for what an earlier session has integrated. scan: nullptr where it was not drawn.
  Step Restore(const CriticalRays* scan, const ScanMatch& match);

  /// What comes now was integrated in an earlier session: it is drawn all at once in the end, which gives the same map,
  /// and much of it need not be drawn at all. Nothing without loops. To be called first.
  void PutOffDrawing();
  /// Draws it, and from now on all that comes. Returns what that changes.
  std::vector<TileChange> DrawPutOff();

  /// What a keyframe of this mapper's has brought to the graph. It is taken up some keyframes later, `lag` of them if
  /// it comes before: so loops can be searched while the robot drives on. False, and nothing is done, if it is not the
  /// one that follows the last.
  bool Accept(const GraphUpdate& update);

  /// No more updates come of this keyframe and those before it. False, and nothing is done, if it is not there.
  bool NoteSearched(KeyframeId keyframe);
  /// The newest keyframe up to which all updates were offered; none: of no keyframe is that known.
  std::optional<KeyframeId> searched() const { return searched_; }
  /// What the search at a keyframe has come to, if it is known.
  std::optional<EarlierSearch> FindSearch(KeyframeId keyframe) const;

  /// Keyframe of the last update offered.
  std::optional<KeyframeId> last_update() const { return last_update_; }
  /// How often what is shown has changed other than by a new scan: keyframes were moved, or another component became
  /// the largest.
  std::int64_t num_layouts() const { return num_layouts_; }

  /// The map is finished: it is all that was seen, and stays as it is. Returns what that changes.
  std::vector<TileChange> Finish();

  /// Whether keyframes are kept, and corrected: with loops, until the map is finished.
  bool closes_loops() const { return loops_.loops; }

  const MapUpdater& local() const { return local_; }
  /// Keyframes in the local map.
  int num_drawn() const { return static_cast<int>(drawn_.size()); }
  /// What was taken up.
  const KeyframeGraph& graph() const { return graph_; }
  /// Whether that is to take effect yet.
  bool is_drawing() const { return coming_.has_value(); }

  /// All that is known.
  KeyframeGraph MakeBestGraph() const;
  /// T_map_keyframe by all that is known.
  const KeyframePoses& best_poses() const { return best_poses_; }
  /// T_map_laser of a scan by all that is known. scan: 0 for the first that was integrated. T_map_laser: where it was
  /// matched.
  Pose2 BestPose(std::int64_t scan, const Pose2& T_map_laser) const;
  /// The keyframe on which a scan hangs: the newest one then; none where no keyframe came before it, and on a finished
  /// map. scan: as of BestPose.
  std::optional<KeyframeId> FindKeyframe(std::int64_t scan) const;
  /// Whether a keyframe is of the component with the most keyframes: the map that is shown. By all that is known.
  bool IsKeyframeOnMap(KeyframeId keyframe) const;
  /// The same of a scan's keyframe. scan: as of BestPose.
  bool IsScanOnMap(std::int64_t scan) const;
  /// A match as it belongs on its component: moved, and floating if that is not the map that is shown. scan: as of
  /// BestPose.
  ScanMatch BestMatch(std::int64_t scan, ScanMatch match) const;
  /// The newest loops by all that is known, those that hold first: only those on the map that is shown.
  std::vector<PlacedLoop> PlaceLoops() const;

  /// How the map hangs together by all that is known.
  MapPieces FindPieces() const;
  /// The same, and the slip that loops have put right.
  MapPieces FindPiecesAndSlip() const;
  /// The same, and how far off the map that is shown may be: takes as long as some optimisations of the graph.
  MapPieces FindPiecesAndError() const;
  /// From which that follows.
  KnownMotions CollectMotions() const;
  /// The component that is the piece of that number, its oldest trajectory; -1: there is none. 1 is the map that is
  /// shown.
  int FindComponent(int piece) const;
  bool IsKeyframeOf(int component, KeyframeId keyframe) const;
  /// The scans of a component, lost ones too, as runs from a first scan up to an end.
  struct ScanRun {
    std::int64_t first;
    std::int64_t end;
  };
  std::vector<ScanRun> FindScans(int component) const;
  /// How many they are.
  std::int64_t CountScans(int component) const;
  /// For each trajectory the number of its piece.
  std::vector<int> FindPieceNumbers() const;
  /// For each trajectory its component, by all that is known.
  const std::vector<int>& best_components() const { return best_components_; }
  const TrajectoryLog& trajectories() const { return trajectories_; }

 private:
  /// The keyframe that scans hang on, from one of them on, and where it stood when they were matched.
  struct Anchor {
    std::int64_t first_scan;
    KeyframeId keyframe;
    Pose2 T_map_keyframe;
  };

  using PlacedKeyframe = std::pair<KeyframeId, Pose2>;

  /// As of ScanBatch.
  struct PutOff {
    bool anew;
    std::vector<PlacedKeyframe> scans;
  };

  /// The local map that is being drawn. Until it is there, scans are matched where keyframes were before.
  struct Coming {
    KeyframeId begun_at;  ///< the newest keyframe then
    std::vector<PlacedKeyframe> drawn;
    KeyframePoses poses_before;  ///< T_map_keyframe on the map that is matched, of the keyframes since then too
  };

  using PlaceOnMap = std::array<int, 4>;  ///< component, and which square and direction of it

  PlaceOnMap PlaceOf(const Pose2& T_map_laser) const;
  CriticalRays WithoutMoving(const CriticalRays& scan, const Pose2& T_map_laser) const;
  bool IsOnKnownGround(const ScanMatch& match) const;
  std::vector<TileChange> FollowGraph(bool begins);
  void AddKeyframe(const ValidRays& rays, const ScanMatch& match, bool begins);
  void Follow(KeyframeId before, KeyframeId newest);
  void AnchorScan(std::int64_t scan);
  const Anchor* FindAnchor(std::int64_t scan) const;
  void CountComponents();
  std::vector<int> SortComponents() const;
  std::vector<bool> FindShown() const;
  std::set<int> FindJoins() const;
  void CountNewest(bool begins);
  bool IsDue(int lag) const { return !pending_.empty() && graph_.CountAfter(pending_.front().keyframe) >= lag; }
  bool ApplyDue(int lag);
  const Pose2& MatchedPose(KeyframeId keyframe) const {
    return coming_ ? At(coming_->poses_before, keyframe) : graph_.pose(keyframe);
  }
  bool Floats() const;
  std::optional<ProximityConstraint> FindConstraint(const Pose2& T_map_laser) const;
  std::vector<PlacedKeyframe> Place(const std::vector<KeyframeId>& keyframes) const;
  std::vector<PlacedScan> ScansOf(const std::vector<PlacedKeyframe>& keyframes) const;
  BackgroundDrawing& drawing();
  void BeginDrawing(const std::vector<KeyframeId>& keyframes, KeyframePoses poses_before);
  std::vector<TileChange> TakeDueDrawing();
  std::vector<TileChange> Redraw(const std::vector<KeyframeId>& keyframes);
  std::vector<TileChange> DrawMissing();
  std::vector<KeyframeId> ThinOut(const std::vector<KeyframeId>& local) const;

  DrawingRules rules_;
  LoopParameters loops_;
  GraphConstants constants_;
  MapUpdater local_;
  MovingObjectFilter moving_objects_;
  KeyframeGraph graph_;
  std::deque<GraphUpdate> pending_;           ///< that were not taken up yet
  std::optional<KeyframeId> taken_up_;        ///< keyframe of the last one that the graph has
  std::optional<KeyframeId> applied_update_;  ///< ... and of the last one that has taken effect
  std::optional<Coming> coming_;
  std::unique_ptr<BackgroundDrawing> drawing_;  ///< of it, if it is not put off
  std::optional<KeyframeId> last_update_;
  std::optional<KeyframeId> searched_;
  std::map<KeyframeId, LoopFinding> findings_;
  std::int64_t num_layouts_ = 0;
  std::vector<int> best_components_;  ///< by trajectory
  std::vector<int> component_sizes_;  ///< keyframes, by component
  int largest_ = 0;                   ///< component
  TrajectoryLog trajectories_;
  std::vector<Loop> loops_closed_;  ///< by them all
  std::vector<Loop> loops_rejected_;
  KeyframePoses best_poses_;
  std::vector<KeyframeId> drawn_;   ///< keyframes in the local map
  std::deque<KeyframeId> missing_;  ///< that belong there, too, and are drawn on the way
  double looked_at_m_ = 0.0;        ///< where on the newest trajectory it was last looked which belong there
  std::optional<std::vector<PutOff>> put_off_;
  bool floats_ = false;                      ///< the newest keyframe: it is not on the map that is shown
  bool lost_since_ = false;                  ///< scans were, since the newest keyframe
  std::optional<WheelMotion> by_wheels_;     ///< since the newest keyframe, where the wheels are believed
  MatchConstants::Uncertainty uncertainty_;  ///< of matches
  std::vector<Anchor> anchors_;
  std::map<PlaceOnMap, int> num_keyframes_at_;  ///< where they were matched
};

}  // namespace crsm
