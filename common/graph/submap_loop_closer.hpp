#pragma once

#include <optional>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/join_check.hpp"
#include "common/graph/join_search.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/loop_closer.hpp"
#include "common/graph/loop_finding.hpp"
#include "common/map/map_updater.hpp"
#include "common/match/match_constants.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// Searches the hits of the last metres in submaps of older parts of the path.
///
/// A wrong loop is worse than none. A place has to fit, and clearly better than any other; then a second finding, some
/// metres later, has to agree with the first one; in the graph a loop that contradicts all others counts for nothing
/// (Geman and McClure's loss), and is rejected, until more that say the same outweigh them; and where what the robot
/// sees next contradicts a join, the component falls apart again.
class SubmapLoopCloser : public LoopCloser {
 public:
  SubmapLoopCloser(const LoopParameters& parameters, const DrawingRules& drawing, const GraphConstants& constants = {},
                   const MatchConstants& match = {})
      : parameters_(parameters),
        drawing_(drawing),
        constants_(constants),
        match_(match),
        graph_(constants.edges),
        joins_(constants, match),
        join_check_(constants) {}

  std::optional<GraphUpdate> Add(Keyframe keyframe, const std::optional<EarlierSearch>& earlier) override;

  const KeyframeGraph& graph() const override { return graph_; }

 private:
  struct Remembered {
    LoopFinding finding;
    bool is_loop = false;
  };

  bool ContradictsBridges(const LoopFinding& finding) const;
  bool AgreesWithGraph(KeyframeId older, KeyframeId newer, const Pose2& T_older_newer, double sigmas) const;
  bool AreApart(const LoopFinding& earlier, const LoopFinding& later) const;
  bool Agree(const LoopFinding& earlier, const LoopFinding& later) const;
  std::vector<Loop> Confirm(const LoopFinding& finding, const GraphUpdate* earlier);
  void TakeApart(GraphUpdate& update);
  bool CanWait(const std::vector<Loop>& loops) const;
  void Solve(GraphUpdate& update, const GraphUpdate* earlier);
  void JudgeTogether(GraphUpdate& update);
  bool SayTheSame(const Loop& loop, const Loop& other) const;
  double ComputeWayElsewhere() const;
  std::vector<KeyframeId> PlacesFoundBefore() const;
  std::optional<LoopFinding> Search(const std::optional<EarlierSearch>& earlier);

  LoopParameters parameters_;
  DrawingRules drawing_;
  GraphConstants constants_;
  MatchConstants match_;
  KeyframeGraph graph_;
  JoinSearch joins_;
  JoinCheck join_check_;
  std::vector<Remembered> findings_;  ///< of the last metres
  std::vector<Loop> contradicted_;    ///< loops that were rejected because all others contradict them
  int solved_size_ = 0;               ///< keyframes, when the graph was last solved
  double next_search_m_ = 0.0;        ///< on the newest trajectory
  double next_thorough_m_ = 0.0;
  double next_elsewhere_m_ = 0.0;
  KeyframeId verified_;               ///< the last keyframe of which it is known that it is where the graph says
  std::optional<KeyframeId> update_;  ///< keyframe of the last update
  /// Keyframe of the last update that took proximity constraints for wrong: those that were matched on a map before it
  /// are, too.
  std::optional<KeyframeId> constraints_wrong_before_;
};

}  // namespace crsm
