#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/graph/pose_graph.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// A match on a part of the map that was drawn long ago: where the robot stands by it.
struct Tie {
  int keyframe = 0;  ///< the older one
  Pose2 T_keyframe_this;
  friend bool operator==(const Tie&, const Tie&) = default;
};

/// A scan that was drawn into the map.
struct Keyframe {
  std::int64_t utime = 0;
  ValidRays rays;
  Pose2 T_previous_this;    ///< the motion since the keyframe before, as matched; of no meaning in the first
  bool after_lost = false;  ///< scans were lost between the two
  bool begins = false;      ///< a trajectory: the motion since the keyframe before is a guess
  std::optional<Eigen::Vector2d> open_axis = std::nullopt;  ///< laser frame: along it the walls did not tell
  std::optional<Tie> tie = std::nullopt;
  bool tie_wrong = false;  ///< the map on which it was matched was found wrong since
  int as_of = -1;          ///< the last GraphUpdate in the map that it was matched on, by its keyframe; -1: none
};

/// Two keyframes that saw the same place, far apart along the path.
struct Loop {
  int older = 0;
  int newer = 0;
  Pose2 T_older_newer;
  friend bool operator==(const Loop&, const Loop&) = default;
};

/// What a keyframe has brought to the graph.
struct GraphUpdate {
  int keyframe = 0;                                   ///< the newest one then
  int previous = -1;                                  ///< keyframe of the update before this one; -1: it is the first
  std::vector<Loop> closed;                           ///< by it
  std::vector<Loop> taken_out;                        ///< which all others contradict
  std::optional<int> ties_wrong_from = std::nullopt;  ///< ties of this keyframe and of all newer ones so far are wrong
  int first_pose = 0;                                 ///< those before it stay where they were
  std::vector<Pose2> poses;                           ///< T_map_keyframe, from first_pose to keyframe
  friend bool operator==(const GraphUpdate&, const GraphUpdate&) = default;
};

/// Longer than anything that looks along the path.
inline constexpr double kBreak_m = 100.0;

/// Keyframes along the path, the motions between them, ties and loops: what is known of the poses.
///
/// A *trajectory* is an unbroken run of keyframes, each matched to what those before it drew. Where one ends and the
/// next begins nobody knows the motion. Trajectories that loops lead across hang together: they are one *component*, in
/// one frame. The poses of another component are in a frame of its own.
class KeyframeGraph {
 public:
  /// The next keyframe. Its pose follows from that of the one before; the first is the origin. Returns its index.
  int Add(Keyframe keyframe);

  void AddLoop(const Loop& loop);
  void DropLoop(const Loop& loop);  ///< nothing if it is not there

  /// Takes the ties of a keyframe and of all newer ones for wrong.
  void DropTies(int first);

  int size() const { return static_cast<int>(keyframes_.size()); }
  const Keyframe& keyframe(int index) const { return keyframes_[static_cast<std::size_t>(index)]; }
  const Pose2& pose(int index) const { return poses_[static_cast<std::size_t>(index)]; }  ///< T_map_keyframe
  const std::vector<Pose2>& poses() const { return poses_; }
  const std::vector<Loop>& loops() const { return loops_; }
  std::int64_t num_loops_dropped() const { return num_loops_dropped_; }
  /// Along the path, from the first keyframe [m]. Over a break it grows by kBreak_m, whatever the robot did.
  double path_m(int index) const { return path_m_[static_cast<std::size_t>(index)]; }
  /// The first keyframe so far along the path or further; the newest one if none is.
  int FindByPath(double path_m) const;

  int num_trajectories() const { return static_cast<int>(first_of_.size()); }
  /// The trajectory of a keyframe, counted from 0.
  int trajectory(int index) const { return trajectory_of_[static_cast<std::size_t>(index)]; }
  int FirstOf(int trajectory) const { return first_of_[static_cast<std::size_t>(trajectory)]; }
  int LastOf(int trajectory) const {
    return trajectory + 1 < num_trajectories() ? FirstOf(trajectory + 1) - 1 : size() - 1;
  }
  /// The component of a keyframe: its oldest trajectory.
  int component(int index) const { return components_[static_cast<std::size_t>(trajectory(index))]; }
  bool HangTogether(int a, int b) const { return component(a) == component(b); }
  bool is_one_component() const { return num_components_ <= 1; }

  /// For each trajectory its component, if these were all the loops.
  std::vector<int> FindComponents(const std::vector<Loop>& loops) const;

  /// Moves the younger component of the two ends of a loop to where the loop says; nothing if they are one.
  void Join(const Loop& loop);

  /// T_from_to along the path of one trajectory, by matched motions alone: what it says never changes.
  Pose2 Motion(int from, int to) const;

  /// How far each keyframe is that lies within `reach_m` of one along the motions, ties and loops [m]; by index.
  std::vector<std::pair<int, double>> FindWithin(int from, double reach_m) const;

  /// The poses and all that is known of the motions between them.
  PoseGraph MakePoseGraph() const;

  /// Moves the poses to where they agree best; the first ones that would move by less than a micrometre stay. Returns
  /// the loops that the others contradict, and takes them out.
  std::vector<Loop> Optimise();

  /// Takes over what another graph of the same keyframes has learned. Keyframes that it did not have yet follow the
  /// last one that it had, by their motions: it makes no difference whether they come before the update or after it.
  void Apply(const GraphUpdate& update);

  /// The same for poses of these keyframes alone.
  void PutRight(const GraphUpdate& update, std::vector<Pose2>& poses) const;

  /// Whether an update can be one of a graph that has no other keyframes than these.
  bool Fits(const GraphUpdate& update) const;

 private:
  GraphEdge MakeMotionEdge(int index) const;
  void UpdateComponents();
  void Link(int a, int b, double length_m);
  void Unlink(int a, int b, double length_m);

  std::vector<Keyframe> keyframes_;
  std::vector<int> trajectory_of_;
  std::vector<int> first_of_;    ///< keyframe, by trajectory
  std::vector<int> components_;  ///< by trajectory
  int num_components_ = 0;
  std::vector<double> path_m_;
  std::vector<Pose2> poses_;
  std::vector<Loop> loops_;
  std::int64_t num_loops_dropped_ = 0;
  std::vector<std::vector<std::pair<int, double>>> links_;  ///< by keyframe: to which, and how far
};

}  // namespace crsm
