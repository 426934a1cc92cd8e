#include "services/wire/graph_messages.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

constexpr int kPosesInPart = 1000;  // 24 KB; the head of a stretch counts as one of them

loop_t ToMessage(const Loop& loop) {
  return {crsm::ToMessage(loop.older), crsm::ToMessage(loop.newer), crsm::ToMessage(loop.T_older_newer)};
}

Loop FromMessage(const loop_t& message) {
  return {crsm::FromMessage(message.older), crsm::FromMessage(message.newer), crsm::FromMessage(message.T_older_newer)};
}

std::vector<loop_finding_t> ToMessages(const std::optional<LoopFinding>& finding) {
  if (!finding) return {};
  return {{crsm::ToMessage(finding->older), crsm::ToMessage(finding->T_older_newer), finding->score,
           static_cast<std::int8_t>(finding->by)}};
}

/// newer: the keyframe at which it was found.
std::optional<LoopFinding> FromMessages(const std::vector<loop_finding_t>& messages, const keyframe_id_t& newer) {
  if (messages.empty()) return std::nullopt;
  const loop_finding_t& message = messages.front();
  return LoopFinding{crsm::FromMessage(message.older), crsm::FromMessage(newer),
                     crsm::FromMessage(message.T_older_this), message.score, static_cast<LoopFinding::By>(message.by)};
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

/// The poses of an update, some of them in each part: stretches are cut where a part ends.
std::vector<std::vector<pose_stretch_t>> Split(const std::vector<PoseStretch>& moved) {
  std::vector<std::vector<pose_stretch_t>> parts(1);
  int room = kPosesInPart;
  for (const PoseStretch& stretch : moved) {
    KeyframeId id = stretch.first;
    for (const Pose2& pose : stretch.poses) {
      const bool is_cut = room == 0;
      if (is_cut || (id == stretch.first && room == 1)) {
        parts.emplace_back();
        room = kPosesInPart;
      }
      if (is_cut || id == stretch.first) {
        parts.back().push_back({ToMessage(id), 0, {}});
        --room;
      }
      pose_stretch_t& last = parts.back().back();
      last.poses.push_back(ToMessage(pose));
      ++last.num_poses;
      ++id.number;
      --room;
    }
  }
  return parts;
}

/// Adds a stretch to those before it. One that was cut is whole again.
void Append(const pose_stretch_t& message, std::vector<PoseStretch>& moved) {
  const KeyframeId first = FromMessage(message.first);
  const auto goes_on = [&](const PoseStretch& stretch) {
    const KeyframeId last = stretch.last();
    return first == KeyframeId{last.trajectory, last.number + 1};
  };
  if (moved.empty() || !goes_on(moved.back())) moved.push_back({first, {}});
  for (const pose2_t& pose : message.poses) moved.back().poses.push_back(FromMessage(pose));
}

}  // namespace

keyframe_id_t ToMessage(KeyframeId id) { return {id.trajectory, id.number}; }

KeyframeId FromMessage(const keyframe_id_t& message) { return {message.trajectory, message.number}; }

keyframe_id_t ToMessage(std::optional<KeyframeId> id) { return ToMessage(id.value_or(KeyframeId{-1, -1})); }

std::optional<KeyframeId> FromOptional(const keyframe_id_t& message) {
  return message.trajectory < 0 ? std::nullopt : std::optional(FromMessage(message));
}

keyframe_t ToMessage(const Keyframe& keyframe, const KeyframeHead& head) {
  keyframe_t message{};
  message.utime = keyframe.utime;
  message.epoch = head.epoch;
  message.id = ToMessage(head.id);
  message.previous = ToMessage(head.previous);
  message.last_update = ToMessage(head.last_update);
  message.num_rays = static_cast<std::int32_t>(keyframe.rays.size());
  ValidRays rays = keyframe.rays.Unpack();
  message.angle_rad = std::move(rays.angle_rad);
  message.range_m = std::move(rays.range_m);
  message.T_previous_this = ToMessage(keyframe.T_previous_this);
  message.by_wheels = crsm::ToMessages(keyframe.by_wheels);
  message.num_by_wheels = static_cast<std::int32_t>(message.by_wheels.size());
  message.after_lost = keyframe.after_lost ? 1 : 0;
  message.begins_anywhere = keyframe.begins_anywhere ? 1 : 0;
  message.as_of = ToMessage(keyframe.as_of);
  if (keyframe.degenerate_axis) {
    std::ranges::copy(*keyframe.degenerate_axis, message.degenerate_axis);
  }
  const auto& [axis, sigma] = keyframe.walls;
  std::ranges::copy(axis, message.walls_axis);
  std::ranges::copy(std::array{sigma.x_m, sigma.y_m, sigma.yaw_rad}, message.walls_sigma);
  if (const auto& constraint = keyframe.constraint) {
    message.num_constraints = 1;
    message.constraints = {{ToMessage(constraint->keyframe), ToMessage(constraint->T_keyframe_this)}};
  }
  if (head.search) {
    message.searched = 1;
    message.findings = ToMessages(head.search->finding);
    message.num_findings = static_cast<std::int32_t>(message.findings.size());
  }
  return message;
}

Keyframe FromMessage(const keyframe_t& message) {
  Keyframe keyframe;
  keyframe.utime = message.utime;
  keyframe.rays = ValidRays{message.angle_rad, message.range_m};
  keyframe.T_previous_this = FromMessage(message.T_previous_this);
  keyframe.by_wheels = crsm::FromMessages(message.by_wheels);
  keyframe.after_lost = message.after_lost == 1;
  keyframe.begins_anywhere = message.begins_anywhere == 1;
  keyframe.begins = message.id.number == 0;
  keyframe.as_of = FromOptional(message.as_of);
  const std::array<double, 2> axis = std::to_array(message.degenerate_axis);
  if (axis != std::array{0.0, 0.0}) keyframe.degenerate_axis = axis;
  const auto& [sigma_x_m, sigma_y_m, sigma_yaw_rad] = message.walls_sigma;
  keyframe.walls = {std::to_array(message.walls_axis), {sigma_x_m, sigma_y_m, sigma_yaw_rad}};
  for (const proximity_constraint_t& constraint : message.constraints) {
    keyframe.constraint = ProximityConstraint{FromMessage(constraint.older), FromMessage(constraint.T_older_this)};
  }
  return keyframe;
}

std::optional<EarlierSearch> FindSearch(const keyframe_t& message) {
  if (message.searched == 0) return std::nullopt;
  return EarlierSearch{FromMessages(message.findings, message.id)};
}

std::vector<pose_graph_t> MakeParts(const GraphUpdate& update, std::int64_t utime, std::int64_t epoch) {
  std::vector<std::vector<pose_stretch_t>> moved = Split(update.moved);
  const auto num_parts = static_cast<int>(moved.size());
  std::vector<pose_graph_t> parts;
  for (int i = 0; i < num_parts; ++i) {
    pose_graph_t part = MakeUnchanged(update.keyframe, update.previous, utime, epoch);
    part.changed = 1;
    part.part = i;
    part.num_parts = num_parts;
    part.constraints_wrong_from = ToMessage(update.constraints_wrong_from);
    if (i == 0) {
      part.findings = ToMessages(update.finding);
      part.num_findings = static_cast<std::int32_t>(part.findings.size());
      part.closed = ToMessages(update.closed);
      part.num_closed = static_cast<std::int32_t>(part.closed.size());
      part.rejected = ToMessages(update.rejected);
      part.num_rejected = static_cast<std::int32_t>(part.rejected.size());
    }
    part.moved = std::move(moved[static_cast<std::size_t>(i)]);
    part.num_moved = static_cast<std::int32_t>(part.moved.size());
    parts.push_back(std::move(part));
  }
  return parts;
}

pose_graph_t MakeUnchanged(KeyframeId keyframe, std::optional<KeyframeId> previous, std::int64_t utime,
                           std::int64_t epoch) {
  pose_graph_t message{};
  message.utime = utime;
  message.epoch = epoch;
  message.keyframe = ToMessage(keyframe);
  message.previous = ToMessage(previous);
  message.num_parts = 1;
  message.constraints_wrong_from = ToMessage(std::optional<KeyframeId>());
  return message;
}

int MostParts(int num_keyframes) { return 2 * num_keyframes / (kPosesInPart - 1) + 1; }

std::optional<GraphUpdate> GraphUpdateParts::Add(const pose_graph_t& part) {
  if (!parts_.empty()) {
    const pose_graph_t& other = parts_.begin()->second;
    const bool same = part.epoch == other.epoch && FromMessage(part.keyframe) == FromMessage(other.keyframe) &&
                      FromOptional(part.previous) == FromOptional(other.previous) && part.num_parts == other.num_parts;
    if (!same) parts_.clear();
  }
  parts_[part.part] = part;
  if (static_cast<std::int32_t>(parts_.size()) < part.num_parts) return std::nullopt;

  const pose_graph_t& first = parts_.begin()->second;
  GraphUpdate update;
  update.keyframe = FromMessage(first.keyframe);
  update.previous = FromOptional(first.previous);
  update.finding = FromMessages(first.findings, first.keyframe);
  update.closed = FromMessages(first.closed);
  update.rejected = FromMessages(first.rejected);
  update.constraints_wrong_from = FromOptional(first.constraints_wrong_from);
  for (const auto& [number, each] : parts_) {
    for (const pose_stretch_t& stretch : each.moved) Append(stretch, update.moved);
  }
  parts_.clear();
  return update;
}

}  // namespace crsm
