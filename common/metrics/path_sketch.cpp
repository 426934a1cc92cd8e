#include "common/metrics/path_sketch.hpp"

#include <cmath>
#include <utility>

namespace crsm {
namespace {

constexpr std::size_t kMostKept = 8192;
constexpr double kWidestSpacing_m = 1e6;  // beyond it there are more trajectories than may be kept: one of each stays
constexpr std::size_t kMostRecent = 16;   // the last scan that was seen is one of them

}  // namespace

void PathSketch::Add(const ScanMatch& match) {
  const Kept next{num_matches(), match};
  counts_.Add(match);
  recent_.push_back(next);
  if (recent_.size() > kMostRecent) recent_.pop_front();
  if (!TellsMore(match)) return;
  Keep(next);
  if (kept_.size() > kMostKept) Thin();
}

std::vector<ScanMatch> PathSketch::Matches() const {
  std::vector<ScanMatch> matches;
  for (const Kept& kept : kept_) {
    if (kept.number < recent_.front().number) matches.push_back(kept.match);
  }
  for (const Kept& recent : recent_) matches.push_back(recent.match);
  return matches;
}

bool PathSketch::TellsMore(const ScanMatch& match) const {
  const auto found = last_matched_.find(match.trajectory);
  const auto last_matched = found == last_matched_.end() ? std::nullopt : std::optional(found->second);
  const std::optional<Pose2>& last = match.state == MatchState::kLost ? last_lost_ : last_matched;
  const Pose2& pose = match.T_map_laser;
  return !last || std::hypot(pose.x_m - last->x_m, pose.y_m - last->y_m) >= spacing_m_;
}

void PathSketch::Keep(const Kept& kept) {
  if (kept.match.state == MatchState::kLost) {
    last_lost_ = kept.match.T_map_laser;
  } else {
    last_matched_[kept.match.trajectory] = kept.match.T_map_laser;
  }
  kept_.push_back(kept);
}

/// Takes larger steps, until half of what may be kept is free again.
void PathSketch::Thin() {
  ++num_thinnings_;
  while (kept_.size() > kMostKept / 2 && spacing_m_ < kWidestSpacing_m) {
    spacing_m_ *= 2.0;
    const std::vector<Kept> all = std::exchange(kept_, {});
    last_matched_.clear();
    last_lost_.reset();
    for (const Kept& kept : all) {
      if (TellsMore(kept.match)) Keep(kept);
    }
  }
}

}  // namespace crsm
