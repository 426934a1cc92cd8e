#include "common/match/guess/tracking_state.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/match/guess/motion_prediction.hpp"

namespace crsm {
namespace {

/// Appends to a list of bounded length: the oldest gives way.
template <class Item>
void Append(std::vector<Item>& items, const Item& item, std::size_t most) {
  if (items.size() == most) items.erase(items.begin());
  items.push_back(item);
}

template <class Item>
void KeepLast(std::vector<Item>& items, std::size_t most) {
  if (items.size() > most) items.erase(items.begin(), items.end() - static_cast<std::ptrdiff_t>(most));
}

}  // namespace

TrackingState::TrackingState(Parts parts)
    : num_scans_(parts.num_scans),
      num_lost_(parts.num_lost),
      newest_utime_(parts.newest_utime),
      on_finished_map_(parts.on_finished_map),
      fitnesses_(std::move(parts.fitnesses)),
      recent_(std::move(parts.recent)),
      T_local_map_(parts.T_local_map),
      onset_(parts.onset),
      T_map_guess_(parts.T_map_guess),
      trajectory_(parts.trajectory),
      floating_(parts.floating),
      wheels_(parts.wheels),
      motion_error_m_(parts.motion_error_m) {
  KeepLast(fitnesses_, kUsual);
  KeepLast(recent_, kRecent);
}

TrackingState::TrackingState(const MatchConstants& constants)
    : constants_(constants.tracking), prediction_(constants.prediction), wheels_(constants) {}

TrackingState TrackingState::OnFinishedMap(const MatchConstants& constants) {
  TrackingState state(constants);
  state.on_finished_map_ = true;
  return state;
}

TrackingState TrackingState::MovedTo(const Pose2& T_map_laser) const {
  TrackingState moved = *this;
  if (recent_.empty()) return moved;
  moved.recent_.erase(moved.recent_.begin(), moved.recent_.end() - 1);
  moved.recent_.back().T_map_laser = T_map_laser;
  moved.recent_.back().state = MatchState::kOk;
  moved.num_lost_ = 0;
  return moved;
}

void TrackingState::Add(const ScanMatch& match, const AfterMatch& after) {
  wheels_.Add(recent_, match);
  LearnMotionError(match);
  ++num_scans_;
  num_lost_ = match.state == MatchState::kLost ? num_lost_ + 1 : 0;
  newest_utime_ = std::max(newest_utime_, match.utime);
  if (match.state == MatchState::kFirst) fitnesses_.clear();  // a new map
  const bool matched = match.state == MatchState::kOk || match.state == MatchState::kDegenerate;
  if (matched) Append(fitnesses_, match.fitness, kUsual);
  Append(recent_, match, kRecent);
  if (match.state != MatchState::kLost) {
    onset_ = Onset::kGoesOn;
    T_map_guess_ = {};
  }
  trajectory_ = after.trajectory;
  floating_ = after.floating;
  if (after.T_new_old) Move(*after.T_new_old);
}

/// Of scans whose place the walls tell along both axes, while the robot drives.
void TrackingState::LearnMotionError(const ScanMatch& match) {
  if (match.state != MatchState::kOk || recent_.size() < 2 || !IsMotionMatched(recent_.back(), match) ||
      !IsMotionMatched(recent_[recent_.size() - 2], recent_.back())) {
    return;
  }
  const Pose2 predicted = PredictPose(recent_, prediction_);
  const Pose2& last = recent_.back().T_map_laser;
  const double match_m = constants_.match_m;
  if (Distance(last, match.T_map_laser) < match_m && Distance(last, predicted) < match_m) return;
  motion_error_m_ += constants_.follow * (Distance(predicted, match.T_map_laser) - motion_error_m_);
}

void TrackingState::BeginSession(Onset onset) {
  if (empty()) return;
  onset_ = onset;
  if (onset == Onset::kAnywhere) T_map_guess_ = recent_.back().T_map_laser;
}

void TrackingState::BeginSessionNear(const Pose2& T_map_laser) {
  if (empty()) return;
  onset_ = Onset::kNear;
  T_map_guess_ = T_map_laser;
}

void TrackingState::Move(const Pose2& T_new_old) {
  for (ScanMatch& match : recent_) match.T_map_laser = T_new_old * match.T_map_laser;
  wheels_.Move(T_new_old);
  T_local_map_ = T_local_map_ * Inverse(T_new_old);
  if (onset_ == Onset::kNear || onset_ == Onset::kAnywhere) T_map_guess_ = T_new_old * T_map_guess_;
}

double TrackingState::baseline_fitness() const {
  if (fitnesses_.empty()) return 0.0;
  // The newest first: the order of a sum decides its last bit.
  return std::accumulate(fitnesses_.rbegin(), fitnesses_.rend(), 0.0) / static_cast<double>(fitnesses_.size());
}

const ScanMatch* TrackingState::FindRecent(std::int64_t utime) const {
  const auto found =
      std::find_if(recent_.begin(), recent_.end(), [&](const ScanMatch& match) { return match.utime == utime; });
  return found == recent_.end() ? nullptr : &*found;
}

}  // namespace crsm
