#pragma once

#include <array>
#include <compare>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/fleet/fleet_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/map_error.hpp"

namespace crsm {

/// A keyframe of a fleet. Maps are numbered in the order in which they were begun: a robot that has begun a new map has
/// several.
struct FleetKeyframeId {
  int map = 0;
  KeyframeId id;
  friend auto operator<=>(const FleetKeyframeId&, const FleetKeyframeId&) = default;
};

/// A robot is where another one was, by what its laser saw on the last metres of its path. Two of them that agree make
/// loops.
struct FleetFinding {
  FleetKeyframeId older;  ///< the middle of the part of the path where it was found
  FleetKeyframeId newer;
  Pose2 T_older_newer;    ///< to within a cell
  double score = 0.0;     ///< as of Place
  bool anywhere = false;  ///< nothing was known of where the two lie to each other
  friend bool operator==(const FleetFinding&, const FleetFinding&) = default;
};

/// Keyframes of two maps that saw the same place.
struct FleetLoop {
  FleetKeyframeId older;  ///< which was there first
  FleetKeyframeId newer;
  Pose2 T_older_newer;
  friend bool operator==(const FleetLoop&, const FleetLoop&) = default;
};

/// xx, xy, x yaw, yy, y yaw, yaw yaw [m2, m rad, rad2].
using PoseCovariance = std::array<double, 6>;

/// The pose graphs of several maps as one: what each map knows of itself, and loops between them.
///
/// Trajectories that hang together by the loops of their own map, by its wheels, or by loops between maps are one
/// *piece*, in one frame: that of its oldest map. A piece of one map alone has the poses that the map itself has.
class FleetGraph {
 public:
  explicit FleetGraph(const FleetConstants& constants = {}) : constants_(constants) {}

  /// A new map, which is to outlive this. Returns its number.
  int AddMap(const KeyframeGraph& map);
  /// The map has a new keyframe, its newest one, and nothing else is new of it.
  void AddNewest(int map);
  /// What a map's own loop closer has found: its loops hold from now on. Poses are to move where those of the map did.
  void TakeOver(int map, const GraphUpdate& update);
  /// Of a map's own loops some were rejected, or its poses have moved.
  void Refresh() {
    FindPieces();
    needs_solving_ = true;
  }
  /// A loop between two maps. Moves the younger piece where they are not one yet.
  void AddLoop(const FleetLoop& loop);
  /// Drops all loops between a trajectory and other maps.
  void DropLoopsOf(const FleetKeyframeId& keyframe);

  int num_maps() const { return static_cast<int>(maps_.size()); }
  const KeyframeGraph& map(int number) const { return *maps_[static_cast<std::size_t>(number)].graph; }
  const Pose2& pose(const FleetKeyframeId& at) const {
    return At(maps_[static_cast<std::size_t>(at.map)].poses, at.id);
  }
  FleetKeyframeId newest(int map) const { return {map, *this->map(map).newest()}; }
  const std::vector<FleetLoop>& loops() const { return loops_; }
  const std::vector<FleetLoop>& rejected() const { return rejected_; }

  /// Map and number in it of each trajectory, in the order in which they were begun.
  const std::vector<std::pair<int, int>>& trajectories() const { return trajectories_; }
  /// The place of a trajectory in that list.
  int TrajectoryOf(const FleetKeyframeId& at) const {
    return maps_[static_cast<std::size_t>(at.map)].trajectories[static_cast<std::size_t>(at.id.trajectory)];
  }
  /// The piece of a keyframe: its oldest trajectory.
  int piece(const FleetKeyframeId& at) const { return pieces_[static_cast<std::size_t>(TrajectoryOf(at))]; }
  const std::vector<int>& pieces() const { return pieces_; }  ///< by trajectory
  bool HangTogether(const FleetKeyframeId& a, const FleetKeyframeId& b) const { return piece(a) == piece(b); }

  /// Whether there is something new by which poses are to move.
  bool needs_solving() const { return needs_solving_; }
  /// Moves the keyframes to where all loops agree best, and rejects loops that all others contradict. Costs some
  /// factorisations of all that hangs together.
  void Solve();
  /// How often poses have moved, or other pieces hang together.
  std::int64_t num_layouts() const { return num_layouts_; }

  /// How well the newest keyframe of a map is known in the frame of its piece, as of the last Solve: all 0 where the
  /// frame is the map's own.
  const PoseCovariance& covariance(int map) const { return maps_[static_cast<std::size_t>(map)].covariance; }

  /// What is known of the poses of a piece.
  KnownMotions CollectMotions(int piece) const;

  /// Where the frame of a map lies in that of the piece of its newest keyframe.
  Pose2 FindFrame(int map) const;

 private:
  struct Map {
    const KeyframeGraph* graph;
    KeyframePoses poses;            ///< in the frame of the piece of each
    std::vector<int> trajectories;  ///< places in trajectories_
    PoseCovariance covariance{};
  };

  void FindPieces();
  void Join(const FleetKeyframeId& a, const FleetKeyframeId& b, const Pose2& T_a_b);
  void TakeOwnPoses(int piece);
  void SolveTogether(int piece, const std::set<int>& maps);
  PoseGraph MakePoseGraph(const std::set<int>& maps, std::vector<int>& first_pose) const;
  void EstimateCovariances(const PoseGraph& solved, int piece, const std::vector<int>& first_pose);
  bool RejectContradicted(const PoseGraph& solved, const std::vector<int>& first_pose);
  GraphEdge MakeEdge(const FleetLoop& loop, const std::vector<int>& first_pose) const;
  std::set<int> MapsOf(int piece) const;

  FleetConstants constants_;
  std::vector<Map> maps_;
  std::vector<std::pair<int, int>> trajectories_;
  std::vector<int> pieces_;
  std::vector<FleetLoop> loops_;
  std::vector<FleetLoop> rejected_;
  bool needs_solving_ = false;
  std::int64_t num_layouts_ = 0;
};

}  // namespace crsm
