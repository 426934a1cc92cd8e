#include "common/graph/keyframe_edges.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/median.hpp"

namespace crsm {
namespace {

/// Of independent errors. std::hypot is not the same to the last bit everywhere.
double Add(double sigma, double other) { return std::sqrt(sigma * sigma + other * other); }

double SecondsBefore(const KeyframeGraph& graph, KeyframeId id) {
  const std::int64_t since_us = graph.keyframe(id).utime - graph.keyframe(*graph.Before(id)).utime;
  return 1e-6 * static_cast<double>(std::max<std::int64_t>(since_us, 0));
}

/// The pace of the robot where walls told how far it went; of all motions, if they never did [m/s].
double FindUsualPace(const KeyframeGraph& graph) {
  std::vector<double> told_m_s, all_m_s;
  for (const KeyframeId id : graph.ids()) {
    if (id.number == 0 || SecondsBefore(graph, id) == 0.0) continue;
    const Keyframe& at = graph.keyframe(id);
    all_m_s.push_back(Length(at.T_previous_this) / SecondsBefore(graph, id));
    if (!at.degenerate_axis) told_m_s.push_back(all_m_s.back());
  }
  if (!told_m_s.empty()) all_m_s = std::move(told_m_s);
  return all_m_s.empty() ? 0.0 : FindMedian(std::move(all_m_s));
}

class EdgeFinder {
 public:
  EdgeFinder(const KeyframeGraph& graph, const GraphConstants::Edges& constants)
      : graph_(graph), constants_(constants), usual_m_s_(FindUsualPace(graph)) {}

  std::vector<KeyframeEdge> FindAll() {
    for (const KeyframeId id : graph_.ids()) AddEdgesOf(id);
    for (const Loop& loop : graph_.loops()) edges_.push_back(MakeEdge(loop, constants_));
    return std::move(edges_);
  }

 private:
  void AddEdgesOf(KeyframeId id) {
    const Keyframe& at = graph_.keyframe(id);
    const auto before = graph_.Before(id);
    if (!before) return;
    const bool begins = id.number == 0;
    if (!begins) AddMatched(*before, id, at.T_previous_this, constants_.step, ToldBy::kMatch);
    const bool wheels_tell = begins ? graph_.IsBridged(id.trajectory) : at.DoWheelsTell();
    if (wheels_tell) {
      const auto& [T_from_to, sigma_m, sigma_rad] = *at.by_wheels;
      edges_.push_back({*before, id, T_from_to, {sigma_m, sigma_m, sigma_rad}, ToldBy::kWheels});
    }
    if (!at.constraint || at.constraint_wrong || !graph_.HangTogether(at.constraint->keyframe, id)) return;
    AddMatched(at.constraint->keyframe, id, at.constraint->T_keyframe_this, constants_.proximity, ToldBy::kProximity);
  }

  void AddMatched(KeyframeId older, KeyframeId id, const Pose2& T_older_this, MotionSigma sigma, ToldBy told_by) {
    const Keyframe& at = graph_.keyframe(id);
    const double share = constants_.walls;
    sigma = {Add(sigma.x_m, share * at.walls.sigma.x_m), Add(sigma.y_m, share * at.walls.sigma.y_m),
             Add(sigma.yaw_rad, share * at.walls.sigma.yaw_rad)};
    if (at.degenerate_axis) sigma.x_m = std::max(sigma.y_m, FindAlongSigma(id));
    if (at.after_lost) {
      const double times = constants_.across_lost;
      sigma = {times * sigma.x_m, times * sigma.y_m, times * sigma.yaw_rad};
    }
    edges_.push_back({older, id, T_older_this, sigma, told_by,
                      TurnAxis(at.degenerate_axis.value_or(at.walls.axis), T_older_this.yaw_rad)});
  }

  /// Along a degenerate direction: how the robot drives, and the little that its walls told. It starts from rest.
  double FindAlongSigma(KeyframeId id) const {
    const double way_m = Length(graph_.keyframe(id).T_previous_this);
    const bool drives = id.number > 1 && usual_m_s_ > 0.0;
    const double differs_m = drives ? std::abs(usual_m_s_ * SecondsBefore(graph_, id) - way_m) : 0.0;
    const double by_habit_m = std::max(constants_.uneven * way_m, differs_m);
    return 1.0 / std::sqrt(1.0 / std::max(by_habit_m * by_habit_m, 1e-18) + FindToldAlong(graph_.keyframe(id).walls));
  }

  /// What walls tell along a degenerate direction, without what the noise of their normals seems to tell [1/m^2].
  double FindToldAlong(const WallSigma& walls) const {
    const auto Told = [](double sigma_m) { return 1.0 / (sigma_m * sigma_m); };
    const double unknown_m = MatchConstants::Uncertainty().unknown_m;
    return std::max(0.0, Told(walls.sigma.x_m) - Told(unknown_m) - constants_.normals * Told(walls.sigma.y_m));
  }

  const KeyframeGraph& graph_;
  const GraphConstants::Edges& constants_;
  double usual_m_s_;
  std::vector<KeyframeEdge> edges_;
};

}  // namespace

KeyframeEdge MakeEdge(const Loop& loop, const GraphConstants::Edges& constants) {
  return {loop.older, loop.newer, loop.T_older_newer, constants.loop, ToldBy::kLoop};
}

GraphEdge ToGraphEdge(const KeyframeEdge& edge, int from, int to) {
  GraphEdge made = GraphEdge::Make(from, to, edge.T_older_newer, edge.sigma, edge.x_axis);
  made.may_be_wrong = edge.may_be_wrong();
  return made;
}

std::vector<KeyframeEdge> FindEdges(const KeyframeGraph& graph, const GraphConstants::Edges& constants) {
  return EdgeFinder(graph, constants).FindAll();
}

}  // namespace crsm
