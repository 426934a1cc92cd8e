#include "services/fleet_mapper/robot_link.hpp"

#include <algorithm>
#include <utility>

#include "common/fleet/fleet_marks.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

/// So many keyframes of 360 rays make 24 KB: a burst that a slow network takes within a quarter of a second.
constexpr std::int32_t kAtOnce = 8;

bool IsSame(const Keyframe& known, const keyframe_t& message) {
  return known.utime == message.utime && known.rays == FromMessage(message).rays;
}

}  // namespace

void RobotLink::Take(const keyframe_t& message, Clock::time_point now, std::int64_t utime_now) {
  if (message.epoch != epoch_ && !IsOfCurrentMap(message)) return;
  next_probe_ = now + kSilence;
  const KeyframeId id = FromMessage(message.id);
  if (id == KeyframeId{} && !is_identified_) Identify(message);
  if (is_identified_ && ContradictsGiven(message)) {  // the robot has lost the end of its map, and went on from there
    map_.reset();
    given_.reset();
    waiting_.clear();
    backoff_.RestartAtOnce();
  }
  known_ = std::max(known_, std::optional(id));
  if (is_identified_ && id <= given_) return;
  const auto found = waiting_.find(id);
  if (found != waiting_.end()) {
    if (message.searched == 1) found->second.message = message;
    return;
  }
  if (waiting_.size() == kMostWaiting) {  // those that come first are of use first
    if (waiting_.rbegin()->first <= id) return;
    waiting_.erase(std::prev(waiting_.end()));
  }
  waiting_.emplace(id, Waiting{message, utime_now});
}

/// A robot that has begun another epoch is heard from now on. What comes late of an earlier one is left out.
bool RobotLink::IsOfCurrentMap(const keyframe_t& message) {
  if (std::ranges::find(epochs_before_, message.epoch) != epochs_before_.end()) return false;
  if (epochs_before_.size() >= kMostMaps) return false;
  BeginEpoch(message.epoch);
  return true;
}

void RobotLink::BeginEpoch(std::int64_t epoch) {
  if (epoch_ != 0) epochs_before_.push_back(epoch_);
  epoch_ = epoch;
  is_identified_ = false;
  map_.reset();
  given_.reset();
  known_.reset();
  waiting_.clear();
  marks_told_.reset();
  next_marks_ = {};
  backoff_.RestartAtOnce();
}

/// Whether it goes on with the robot's last map: its host was started again, say.
void RobotLink::Identify(const keyframe_t& first) {
  is_identified_ = true;
  if (maps_.empty() || !IsSame(fleet_.graph().map(maps_.back()).keyframe({}), first)) return;
  map_ = maps_.back();
  given_ = fleet_.graph().map(*map_).newest();
  std::erase_if(waiting_, [&](const auto& one) { return one.first <= given_; });
}

/// Whether a keyframe that was given out is another one now.
bool RobotLink::ContradictsGiven(const keyframe_t& message) const {
  const KeyframeId id = FromMessage(message.id);
  return map_ && id <= given_ && !IsSame(fleet_.graph().map(*map_).keyframe(id), message);
}

void RobotLink::Take(const pose_graph_t& message) {
  if (message.epoch != epoch_ || message.part != 0) return;
  const KeyframeId keyframe = FromMessage(message.keyframe);
  const auto previous = FromOptional(message.previous);
  // Between the update before and this one nothing was found.
  for (auto& [id, waiting] : waiting_) {
    const bool is_told = previous < id && (id < keyframe || id == keyframe);
    if (!is_told || waiting.message.searched == 1) continue;
    waiting.message.searched = 1;
    if (id != keyframe || message.changed == 0) continue;
    waiting.message.findings = message.findings;
    waiting.message.num_findings = message.num_findings;
  }
}

std::optional<fleet_marks_t> RobotLink::Take(const robot_marks_t& message, Clock::time_point now) {
  if (message.epoch != epoch_ || !is_identified_ || !map_) return std::nullopt;
  std::int64_t& held = marks_held_[*map_];
  const bool is_same = message.checksum == held;
  const bool is_whole = message.num_marks > 0 || message.checksum == 0;  // else one for who holds what we do not
  if (!is_same && (!is_whole || !FleetMarks::Fits(fleet_.graph(), *map_, FromMessage(message)))) return std::nullopt;
  marks_told_ = now;
  if (is_same) return std::nullopt;
  held = message.checksum;
  return fleet_marks_t{*map_, message};
}

bool RobotLink::HasToldMarks(Clock::time_point now) {
  constexpr auto kMoment = std::chrono::seconds(1);
  if (!map_ || (marks_told_ && now - *marks_told_ < kMoment)) return true;
  constexpr auto kAgain = std::chrono::milliseconds(200);
  if (next_marks_ > now + kAgain) next_marks_ = now;
  return false;
}

std::optional<RobotLink::Told> RobotLink::Next(Clock::time_point now) {
  if (!is_identified_ || waiting_.empty()) return std::nullopt;
  const auto next = waiting_.begin();
  const auto& [message, heard_utime] = next->second;
  if (FromOptional(message.previous) != given_ || message.searched == 0) return std::nullopt;
  Told told{map_, message, heard_utime};
  given_ = next->first;
  waiting_.erase(next);
  const bool is_lacking =
      is_behind() && (waiting_.empty() || FromOptional(waiting_.begin()->second.message.previous) != given_);
  is_lacking ? backoff_.RestartAtOnce() : backoff_.Restart(now);
  return told;
}

void RobotLink::Begin(int map, std::int64_t epoch) {
  if (epoch_ != 0 && epoch_ != epoch) epochs_before_.push_back(epoch_);
  epoch_ = epoch;
  is_identified_ = true;
  map_ = map;
  if (std::ranges::find(maps_, map) == maps_.end()) maps_.push_back(map);
  given_ = fleet_.graph().map(map).newest();
  known_ = std::max(known_, given_);
}

bool RobotLink::waits_for_loop_closer() const {
  return is_identified_ && !waiting_.empty() && waiting_.begin()->second.message.searched == 0 &&
         FromOptional(waiting_.begin()->second.message.previous) == given_;
}

std::optional<keyframe_request_t> RobotLink::NextRequest(Clock::time_point now) {
  if (epoch_ == 0) {  // whichever map it has
    if (!backoff_.Due(now)) return std::nullopt;
    return keyframe_request_t{0, ToMessage(std::optional<KeyframeId>()), 1, -1};
  }
  if (!is_identified_) {
    if (!backoff_.Due(now)) return std::nullopt;
    return keyframe_request_t{epoch_, ToMessage(std::optional<KeyframeId>()), 1, -1};
  }
  if (map_ && now >= next_marks_) {
    next_marks_ = now + kMarksPeriod;
    return keyframe_request_t{epoch_, ToMessage(given_), 1, marks_held_[*map_]};
  }
  if (!is_behind() && now >= next_probe_) {
    next_probe_ = now + kSilence;
    return keyframe_request_t{0, ToMessage(std::optional<KeyframeId>()), 1, -1};
  }
  if (!is_behind() || !backoff_.Due(now)) return std::nullopt;
  return keyframe_request_t{epoch_, ToMessage(given_), kAtOnce, -1};
}

}  // namespace crsm
