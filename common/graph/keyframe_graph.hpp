#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/pose_graph.hpp"
#include "common/graph/wall_sigma.hpp"
#include "common/scan/packed_rays.hpp"
#include "common/scan/wheel_motion.hpp"

namespace crsm {

/// The name of a keyframe. Trajectories are numbered in the order in which they began, so older keyframes have lesser
/// names.
struct KeyframeId {
  int trajectory = 0;  ///< >= 0
  int number = 0;      ///< in its trajectory, >= 0
  friend auto operator<=>(const KeyframeId&, const KeyframeId&) = default;
};

/// T_map_keyframe, by trajectory and number: each in the frame of its component.
using KeyframePoses = std::vector<std::vector<Pose2>>;

inline const Pose2& At(const KeyframePoses& poses, KeyframeId id) {
  return poses[static_cast<std::size_t>(id.trajectory)][static_cast<std::size_t>(id.number)];
}

/// A match on a part of the map that was drawn long ago: where the robot stands by it.
struct ProximityConstraint {
  KeyframeId keyframe;  ///< the older one
  Pose2 T_keyframe_this;
  friend bool operator==(const ProximityConstraint&, const ProximityConstraint&) = default;
};

/// A scan that was drawn into the map.
struct Keyframe {
  std::int64_t utime = 0;
  PackedRays rays;
  /// The motion since the keyframe before, as matched. Where a trajectory begins, a guess: the place of its frame seen
  /// from the last keyframe of the trajectory before. Of no meaning in the first of all.
  Pose2 T_previous_this;
  /// The same by the wheels, where they are believed. Where a trajectory begins, they bridge the break.
  std::optional<WheelMotion> by_wheels = std::nullopt;
  bool after_lost = false;       ///< scans were lost between the two
  bool begins = false;           ///< a trajectory
  bool begins_anywhere = false;  ///< ... of another drive: nothing is known of its place
  /// Unit vector, laser frame: along it the walls did not tell.
  std::optional<std::array<double, 2>> degenerate_axis = std::nullopt;
  WallSigma walls = {};  ///< what they told of its match
  std::optional<ProximityConstraint> constraint = std::nullopt;
  bool constraint_wrong = false;                   ///< the map on which it was matched was found wrong since
  std::optional<KeyframeId> as_of = std::nullopt;  ///< keyframe of the last GraphUpdate in the map of its match

  /// Whether the wheels say something of its motion that its match does not know better.
  bool DoWheelsTell() const { return by_wheels && !begins && (degenerate_axis || after_lost); }
};

/// Two keyframes that saw the same place, far apart along the path or in two trajectories.
struct Loop {
  KeyframeId older;
  KeyframeId newer;
  Pose2 T_older_newer;
  friend bool operator==(const Loop&, const Loop&) = default;
};

/// The robot is where it was long ago, by what its laser saw on the last metres of its path.
struct LoopFinding {
  /// How it was found.
  enum class By {
    kDrift,   ///< where the poses may have drifted to
    kCheck,   ///< the graph vouches for that place, and matches were made on it already
    kSoon,    ///< in another component, near where the robot was before a short break: it can hardly be elsewhere
    kNearby,  ///< the same after a longer one
    kAnywhere,
  };

  KeyframeId older;     ///< the middle keyframe of the submap in which it was found
  KeyframeId newer;     ///< the newest keyframe
  Pose2 T_older_newer;  ///< to within a cell
  double score = 0.0;   ///< as of Place
  By by = By::kDrift;
  friend bool operator==(const LoopFinding&, const LoopFinding&) = default;
};

/// Poses of keyframes of one trajectory that follow each other.
struct PoseStretch {
  KeyframeId first;
  std::vector<Pose2> poses;  ///< T_map_keyframe
  KeyframeId last() const { return {first.trajectory, first.number + static_cast<int>(poses.size()) - 1}; }
  friend bool operator==(const PoseStretch&, const PoseStretch&) = default;
};

/// What was found at a keyframe, and what that has brought to the graph: maybe nothing yet.
struct GraphUpdate {
  KeyframeId keyframe;                                ///< the newest one then
  std::optional<KeyframeId> previous = std::nullopt;  ///< keyframe of the update before this one; none: it is the first
  /// None of a loop closer that does not tell.
  std::optional<LoopFinding> finding = std::nullopt;
  std::vector<Loop> closed;    ///< by it
  std::vector<Loop> rejected;  ///< which all others contradict
  /// Ties of this keyframe and of all newer ones so far are wrong.
  std::optional<KeyframeId> constraints_wrong_from = std::nullopt;
  std::vector<PoseStretch> moved;  ///< in the order of their names; all other keyframes stay where they were
  bool ChangesGraph() const { return !closed.empty() || !rejected.empty() || constraints_wrong_from || !moved.empty(); }
  friend bool operator==(const GraphUpdate&, const GraphUpdate&) = default;
};

/// Trajectories of keyframes, the motions in them, proximity constraints and loops: what is known of the poses.
///
/// A *trajectory* is an unbroken run of keyframes, each matched to what those before it drew. Where one ends and the
/// next begins nobody knows the motion, and there is no way from one to the other but over loops. Trajectories that
/// loops lead across hang together: they are one *component*, in one frame. The poses of another component are in a
/// frame of its own. Where the wheels *bridge* a break, components on both sides are one *piece*, in about one frame:
/// where they lie is not known so well that scans of one could be matched to the other.
class KeyframeGraph {
 public:
  explicit KeyframeGraph(const GraphConstants::Edges& constants = {}) : constants_(constants) {}

  /// The next keyframe: of the newest trajectory, or the first of a new one. Its pose follows from that of the one
  /// before; the first of all is the origin. Returns its name.
  KeyframeId Add(Keyframe keyframe);

  void AddLoop(const Loop& loop);
  void DropLoop(const Loop& loop);  ///< nothing if it is not there

  /// Takes the proximity constraints of a keyframe and of all newer ones for wrong.
  void DropConstraints(KeyframeId first);

  /// Keyframes, of all trajectories.
  int size() const { return size_; }
  int num_trajectories() const { return static_cast<int>(trajectories_.size()); }
  /// Keyframes of a trajectory, >= 1.
  int size(int trajectory) const { return static_cast<int>(of(trajectory).keyframes.size()); }
  bool Has(KeyframeId id) const;
  /// None in an empty graph.
  std::optional<KeyframeId> newest() const;
  /// The last one of a trajectory.
  KeyframeId LastOf(int trajectory) const { return {trajectory, size(trajectory) - 1}; }
  /// The one before, maybe of the trajectory before; none for the first of all.
  std::optional<KeyframeId> Before(KeyframeId id) const;
  /// The one after, maybe of the trajectory after; none for the newest.
  std::optional<KeyframeId> After(KeyframeId id) const;
  /// How many are newer.
  int CountAfter(KeyframeId id) const;
  /// The names of all, in their order.
  std::vector<KeyframeId> ids() const;

  const Keyframe& keyframe(KeyframeId id) const { return of(id.trajectory).keyframes[Index(id)]; }
  const Pose2& pose(KeyframeId id) const { return At(poses_, id); }  ///< T_map_keyframe
  const KeyframePoses& poses() const { return poses_; }
  /// By the names of their newer keyframes.
  const std::vector<Loop>& loops() const { return loops_; }
  std::int64_t num_loops_dropped() const { return num_loops_dropped_; }
  /// Along the trajectory, from its first keyframe [m].
  double path_m(KeyframeId id) const { return of(id.trajectory).path_m[Index(id)]; }
  /// The first keyframe of a trajectory so far along it or further; its last one if none is.
  KeyframeId FindByPath(int trajectory, double path_m) const;

  /// What was driven between two keyframes, without what nobody knows of [m]: the poses may have drifted apart over it.
  double ComputeDriven(KeyframeId older, KeyframeId newer) const;

  /// The component of a keyframe: its oldest trajectory.
  int component(KeyframeId id) const { return components_[static_cast<std::size_t>(id.trajectory)]; }
  bool HangTogether(KeyframeId a, KeyframeId b) const { return component(a) == component(b); }
  bool is_one_component() const { return num_components_ <= 1; }

  /// For each trajectory its component, if these were all the loops.
  std::vector<int> FindComponents(const std::vector<Loop>& loops) const;
  /// For each trajectory its piece, the oldest one with which it hangs together by these loops, or over breaks that the
  /// wheels bridge. Pieces are what is shown as one map.
  std::vector<int> FindPieces(const std::vector<Loop>& loops) const;

  /// Whether the wheels bridge the break before a trajectory.
  bool IsBridged(int trajectory) const;
  /// How well a keyframe is known as seen from an older one of its piece, by the bridges between: standard deviations.
  /// Nothing if there is none.
  std::optional<WheelMotion> SumBridges(KeyframeId older, KeyframeId newer) const;

  const std::vector<int>& components() const { return components_; }  ///< by trajectory
  const std::vector<int>& pieces() const { return pieces_; }          ///< by trajectory
  /// How many keyframes each component has. components: by trajectory.
  std::vector<int> CountKeyframes(const std::vector<int>& components) const;

  /// Of the keyframes before a trajectory that hang together with another one: the nearest to a place in its frame;
  /// nothing if none is nearer than `within_m`.
  std::optional<KeyframeId> FindNearest(const Pose2& T_map_place, KeyframeId with, int before_trajectory,
                                        double within_m) const;

  /// The loops between a trajectory and others.
  std::vector<Loop> FindLoopsAcross(int trajectory) const;

  /// Moves the younger component of the two ends of a loop to where the loop says; nothing if they are one.
  void Join(const Loop& loop);

  /// T_from_to along their trajectory, by matched motions alone: what it says never changes.
  Pose2 Motion(KeyframeId from, KeyframeId to) const;

  /// How far each keyframe is that lies within `reach_m` of one along the motions, constraints and loops [m]; by name.
  std::vector<std::pair<KeyframeId, double>> FindWithin(KeyframeId from, double reach_m) const;

  /// The poses and all that is known of the motions between them. Its poses are those of ids(), in that order.
  PoseGraph MakePoseGraph() const;

  /// Moves the poses to where they agree best; the first ones that would move by less than a micrometre stay. Returns
  /// the loops that the others contradict, and takes them out.
  std::vector<Loop> Optimise();

  /// Takes over what another graph of the same keyframes has learned. Keyframes that it did not have yet follow the
  /// last one that it had, by their motions: it makes no difference whether they come before the update or after it.
  void Apply(const GraphUpdate& update);

  /// The same for poses of these keyframes alone.
  void Correct(const GraphUpdate& update, KeyframePoses& poses) const;
  /// The same for its own poses, where it has the loops already.
  void Move(const GraphUpdate& update) { Correct(update, poses_); }

  /// Whether an update can be one of a graph that has no other keyframes than these.
  bool Fits(const GraphUpdate& update) const;

 private:
  using Links = std::vector<std::pair<KeyframeId, double>>;  ///< to which, and how far

  /// Each by number.
  struct Trajectory {
    std::vector<Keyframe> keyframes;
    std::vector<double> path_m;
    std::vector<Links> links;
  };

  static std::size_t Index(KeyframeId id) { return static_cast<std::size_t>(id.number); }
  const Trajectory& of(int trajectory) const { return trajectories_[static_cast<std::size_t>(trajectory)]; }
  Trajectory& of(int trajectory) { return trajectories_[static_cast<std::size_t>(trajectory)]; }
  void UpdateComponents();
  void Link(KeyframeId a, KeyframeId b, double length_m);
  void Unlink(KeyframeId a, KeyframeId b, double length_m);

  GraphConstants::Edges constants_;
  std::vector<Trajectory> trajectories_;
  KeyframePoses poses_;
  int size_ = 0;
  std::vector<int> components_;  ///< by trajectory
  int num_components_ = 0;
  std::vector<int> pieces_;  ///< by trajectory
  std::vector<Loop> loops_;
  std::int64_t num_loops_dropped_ = 0;
};

}  // namespace crsm
