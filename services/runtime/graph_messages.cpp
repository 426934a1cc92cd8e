#include "services/runtime/graph_messages.hpp"

#include <algorithm>

#include "services/runtime/conversions.hpp"

namespace crsm {
namespace {

constexpr int kPosesInPart = 1000;  // 24 KB

loop_t ToMessage(const Loop& loop) { return {loop.older, loop.newer, crsm::ToMessage(loop.T_older_newer)}; }

Loop FromMessage(const loop_t& message) {
  return {message.older, message.newer, crsm::FromMessage(message.T_older_newer)};
}

std::vector<loop_t> ToMessages(const std::vector<Loop>& loops) {
  std::vector<loop_t> messages;
  for (const Loop& loop : loops) messages.push_back(ToMessage(loop));
  return messages;
}

std::vector<Loop> FromMessages(const std::vector<loop_t>& messages) {
  std::vector<Loop> loops;
  for (const loop_t& message : messages) loops.push_back(FromMessage(message));
  return loops;
}

}  // namespace

keyframe_t ToMessage(const Keyframe& keyframe, const KeyframeHead& head) {
  keyframe_t message{};
  message.utime = keyframe.utime;
  message.epoch = head.epoch;
  message.keyframe = head.index;
  message.last_update = head.last_update;
  message.num_rays = static_cast<std::int32_t>(keyframe.rays.size());
  message.angle_rad = keyframe.rays.angle_rad;
  message.range_m = keyframe.rays.range_m;
  message.T_previous_this = ToMessage(keyframe.T_previous_this);
  message.after_lost = keyframe.after_lost ? 1 : 0;
  message.begins = keyframe.begins ? 1 : 0;
  message.as_of = keyframe.as_of;
  if (keyframe.open_axis) {
    message.num_open_axes = 1;
    message.open_axis[0] = keyframe.open_axis->x();
    message.open_axis[1] = keyframe.open_axis->y();
  }
  if (keyframe.tie) {
    message.num_ties = 1;
    message.tied_to = keyframe.tie->keyframe;
    message.T_tied_this = ToMessage(keyframe.tie->T_keyframe_this);
  }
  return message;
}

Keyframe FromMessage(const keyframe_t& message) {
  Keyframe keyframe;
  keyframe.utime = message.utime;
  keyframe.rays = {message.angle_rad, message.range_m};
  keyframe.T_previous_this = FromMessage(message.T_previous_this);
  keyframe.after_lost = message.after_lost == 1;
  keyframe.begins = message.begins == 1;
  keyframe.as_of = message.as_of;
  if (message.num_open_axes == 1) keyframe.open_axis = Eigen::Vector2d(message.open_axis[0], message.open_axis[1]);
  if (message.num_ties == 1) keyframe.tie = Tie{message.tied_to, FromMessage(message.T_tied_this)};
  return keyframe;
}

std::vector<pose_graph_t> MakeParts(const GraphUpdate& update, std::int64_t utime, std::int64_t epoch) {
  const auto num_poses = static_cast<int>(update.poses.size());
  const int num_parts = std::max(1, (num_poses + kPosesInPart - 1) / kPosesInPart);
  std::vector<pose_graph_t> parts;
  for (int i = 0; i < num_parts; ++i) {
    pose_graph_t part = MakeUnchanged(update.keyframe, update.previous, utime, epoch);
    part.changed = 1;
    part.part = i;
    part.num_parts = num_parts;
    part.ties_wrong_from = update.ties_wrong_from.value_or(-1);
    if (i == 0) {
      part.closed = ToMessages(update.closed);
      part.num_closed = static_cast<std::int32_t>(part.closed.size());
      part.taken_out = ToMessages(update.taken_out);
      part.num_taken_out = static_cast<std::int32_t>(part.taken_out.size());
    }
    const int first = i * kPosesInPart;
    part.first_pose = update.first_pose + first;
    part.num_poses = std::min(num_poses - first, kPosesInPart);
    for (int k = first; k < first + part.num_poses; ++k) {
      part.poses.push_back(ToMessage(update.poses[static_cast<std::size_t>(k)]));
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

pose_graph_t MakeUnchanged(int keyframe, int previous, std::int64_t utime, std::int64_t epoch) {
  pose_graph_t message{};
  message.utime = utime;
  message.epoch = epoch;
  message.keyframe = keyframe;
  message.previous = previous;
  message.num_parts = 1;
  message.ties_wrong_from = -1;
  return message;
}

std::optional<GraphUpdate> GraphUpdateParts::Add(const pose_graph_t& part) {
  if (part.num_parts > part.keyframe / kPosesInPart + 1) return std::nullopt;  // more than poses are there
  if (!parts_.empty()) {
    const pose_graph_t& other = parts_.begin()->second;
    const bool same = part.epoch == other.epoch && part.keyframe == other.keyframe && part.previous == other.previous &&
                      part.num_parts == other.num_parts;
    if (!same) parts_.clear();
  }
  parts_[part.part] = part;
  if (static_cast<std::int32_t>(parts_.size()) < part.num_parts) return std::nullopt;

  const pose_graph_t& first = parts_.begin()->second;
  GraphUpdate update;
  update.keyframe = first.keyframe;
  update.previous = first.previous;
  update.closed = FromMessages(first.closed);
  update.taken_out = FromMessages(first.taken_out);
  if (first.ties_wrong_from >= 0) update.ties_wrong_from = first.ties_wrong_from;
  update.first_pose = first.first_pose;
  bool in_place = true;
  for (const auto& [number, each] : parts_) {
    in_place = in_place && each.first_pose == update.first_pose + static_cast<int>(update.poses.size());
    for (const pose2_t& pose : each.poses) update.poses.push_back(FromMessage(pose));
  }
  parts_.clear();
  return in_place ? std::optional(std::move(update)) : std::nullopt;
}

}  // namespace crsm
