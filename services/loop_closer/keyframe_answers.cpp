#include "services/loop_closer/keyframe_answers.hpp"

#include <algorithm>

#include "services/runtime/graph_messages.hpp"

namespace crsm {

std::vector<pose_graph_t> KeyframeAnswers::Answer(const keyframe_t& message) {
  const bool went_back = message.last_update < known_to_owner_;  // by a power cut, say: what it had is not kept here
  if (message.epoch != epoch_ || went_back || !Fits(message)) Begin(message.epoch);
  newest_ = std::max(newest_, message.keyframe);
  if (message.keyframe > graph().size()) return {};
  if (message.keyframe == graph().size()) {
    if (auto update = closer_.Add(FromMessage(message))) {
      updates_.push_back(update->keyframe);
      kept_.push_back(std::move(*update));
    }
  }
  if (message.keyframe < message.last_update) return {};  // sent once more for this closer alone
  known_to_owner_ = message.last_update;
  is_of_another_closer_ =
      known_to_owner_ >= 0 && !std::binary_search(updates_.begin(), updates_.end(), known_to_owner_);
  std::erase_if(kept_, [&](const GraphUpdate& update) {
    return is_of_another_closer_ || update.keyframe <= known_to_owner_;
  });
  if (is_of_another_closer_) return {};  // what was found here does not follow what was found there

  std::vector<pose_graph_t> answers;
  for (const GraphUpdate& update : kept_) {
    if (update.keyframe > message.keyframe) break;
    const auto parts = MakeParts(update, graph().keyframe(update.keyframe).utime, epoch_);
    answers.insert(answers.end(), parts.begin(), parts.end());
  }
  const auto next = std::upper_bound(updates_.begin(), updates_.end(), message.keyframe);
  const int last = next == updates_.begin() ? -1 : *(next - 1);
  if (last < message.keyframe) answers.push_back(MakeUnchanged(message.keyframe, last, message.utime, epoch_));
  return answers;
}

std::optional<keyframe_request_t> KeyframeAnswers::NextRequest() const {
  constexpr std::size_t kMostRays = 8000;  // 64 KB: as much as the kernel surely keeps until it is read
  if (newest_ < graph().size()) return std::nullopt;
  const std::size_t rays = graph().size() == 0 ? kMaxBeams : graph().keyframe(graph().size() - 1).rays.size();
  const std::size_t num = std::clamp<std::size_t>(kMostRays / std::max<std::size_t>(1, rays), 1, kMostKeyframesAtOnce);
  return keyframe_request_t{epoch_, graph().size(), static_cast<std::int32_t>(num)};
}

void KeyframeAnswers::Begin(std::int64_t epoch) {
  closer_ = LoopCloser(parameters_, drawing_);
  epoch_ = epoch;
  newest_ = -1;
  updates_.clear();
  kept_.clear();
  known_to_owner_ = -1;
  is_of_another_closer_ = false;
}

/// Whether a keyframe that was there before is the same as then.
bool KeyframeAnswers::Fits(const keyframe_t& message) const {
  if (message.keyframe >= graph().size()) return true;
  const Keyframe& known = graph().keyframe(message.keyframe);
  const Keyframe keyframe = FromMessage(message);
  return known.utime == keyframe.utime && known.T_previous_this == keyframe.T_previous_this &&
         known.rays == keyframe.rays;
}

}  // namespace crsm
