#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/fleet/fleet_constants.hpp"
#include "common/fleet/fleet_graph.hpp"
#include "common/graph/loop_closer.hpp"
#include "common/map/map_updater.hpp"
#include "common/parameters.hpp"

namespace crsm {

class FleetSearch;

/// What the search on other maps came to at a keyframe when it was done.
struct EarlierFleetSearch {
  std::optional<FleetFinding> finding;  ///< none: nothing was found
};

/// The common map of several robots, each of which maps for itself.
///
/// What a robot's own loop closer has found is taken over. What it cannot know is searched: where robots were in the
/// same place. As in one map, a wrong join is worse than none: two findings have to agree that share nothing of what
/// was seen, no other place may fit as well, and a join that later evidence contradicts is rejected.
///
/// The same keyframes in the same order give the same common map, to the last bit, and what an earlier search has found
/// need not be searched again.
class Fleet {
 public:
  Fleet(const LoopParameters& loops, const DrawingRules& drawing, const FleetConstants& constants = {});
  ~Fleet();
  Fleet(const Fleet&) = delete;

  /// A robot has begun a map. Returns its number.
  int BeginMap();

  /// Whether a keyframe can be the next one of a map: what it names is there.
  bool Fits(int map, const Keyframe& keyframe, const std::optional<LoopFinding>& own) const;
  /// Whether a finding can be one of the next keyframe of a map.
  bool Fits(int map, const FleetFinding& finding) const;

  /// The next keyframe of a map. own: what the robot's loop closer has found there. earlier: what was found on other
  /// maps, if that was searched already. Returns what was found on other maps.
  std::optional<FleetFinding> Add(int map, Keyframe keyframe, const std::optional<LoopFinding>& own,
                                  const std::optional<EarlierFleetSearch>& earlier);

  const FleetGraph& graph() const { return graph_; }
  /// Moves the poses to where all agree best, where something new asks for it.
  void Solve() { graph_.Solve(); }

  int num_maps() const { return graph_.num_maps(); }
  /// Keyframes of all maps, in the order in which they were added.
  const std::vector<FleetKeyframeId>& keyframes() const { return keyframes_; }
  /// Keyframes at which other maps were searched.
  std::int64_t num_searched() const { return num_searched_; }

 private:
  struct Remembered {
    FleetFinding finding;
    bool is_loop = false;
  };
  /// What is watched after a join: a wrong one shows where a robot sees walls in what others saw to be free.
  struct Watch {
    int trajectory = -1;  ///< that is watched; -1: none
    double joined_m = 0.0;
    double next_m = 0.0;
    std::optional<double> contradicted_m = std::nullopt;
  };
  struct Member {
    std::unique_ptr<LoopCloser> closer;  ///< is told what the robot's own has found, and searches nothing
    double next_elsewhere_m = 0.0;       ///< on the newest trajectory
    double next_near_m = 0.0;
    double known_m = 0.0;  ///< up to where on it is known how it lies to others
    std::vector<Remembered> findings = {};
    Watch watch = {};
  };

  Member& member(int map) { return members_[static_cast<std::size_t>(map)]; }
  bool IsContradicted(int map);
  std::optional<FleetFinding> Search(int map, const std::optional<EarlierFleetSearch>& earlier);
  void Confirm(const FleetFinding& finding);
  bool Agree(const FleetFinding& earlier, const FleetFinding& later) const;
  bool AreApart(const FleetFinding& earlier, const FleetFinding& later) const;
  bool SaysNothingNew(const FleetFinding& finding) const;
  std::optional<FleetLoop> MakeLoop(const FleetFinding& finding) const;
  void WatchFrom(const FleetKeyframeId& at);

  LoopParameters loops_;
  DrawingRules drawing_;
  FleetConstants constants_;
  std::vector<Member> members_;
  FleetGraph graph_;
  std::unique_ptr<FleetSearch> search_;
  std::vector<FleetKeyframeId> keyframes_;
  std::int64_t num_searched_ = 0;
};

}  // namespace crsm
