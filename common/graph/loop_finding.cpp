#include "common/graph/loop_finding.hpp"

#include <algorithm>
#include <cmath>

namespace crsm {

double BestFinding::LeastScore(double least) const {
  return std::max(least, best_ ? constants_.rival_share * best_->score : 0.0);
}

void BestFinding::Add(KeyframeId middle, const Place& place) {
  if (place.score == 0.0) return;
  rival_ = std::max(rival_, place.rival);
  const LoopFinding finding{middle, *graph_.newest(), place.pose, place.score, by_};
  if (best_ && AreApart(finding, *best_)) rival_ = std::max(rival_, std::min(place.score, best_->score));
  if (!best_ || place.score > best_->score) best_ = finding;
}

/// Whether they are two places. Of those of two components nobody knows.
bool BestFinding::AreApart(const LoopFinding& a, const LoopFinding& b) const {
  if (!graph_.HangTogether(a.older, b.older)) return false;
  const Pose2 apart = Inverse(graph_.pose(a.older) * a.T_older_newer) * (graph_.pose(b.older) * b.T_older_newer);
  return Length(apart) > constants_.same_place_m;
}

std::optional<LoopFinding> BestFinding::Unrivalled() const {
  return best_ && rival_ <= constants_.rival_share * best_->score ? best_ : std::nullopt;
}

}  // namespace crsm
