#include "services/stages/keyframe_answers.hpp"

#include <algorithm>
#include <utility>

#include "services/wire/graph_messages.hpp"

namespace crsm {

std::vector<pose_graph_t> KeyframeAnswers::Answer(const keyframe_t& message) {
  const KeyframeId id = FromMessage(message.id);
  const auto last_update = FromOptional(message.last_update);
  const bool went_back = last_update < known_to_owner_;  // by a power cut, say: what it had is not kept here
  if (message.epoch != epoch_ || went_back || !Fits(message)) Begin(message.epoch);
  newest_ = std::max(newest_, std::optional(id));
  if (!graph().Has(id)) {
    Keyframe keyframe = FromMessage(message);
    const bool is_next = FromOptional(message.previous) == graph().newest();
    if (!is_next || (keyframe.constraint && !graph().Has(keyframe.constraint->keyframe))) return {};
    const auto earlier = FindSearch(message);
    if (earlier && earlier->finding && !graph().Has(earlier->finding->older)) return {};
    if (!earlier) ++num_searched_;
    if (auto update = closer_->Add(std::move(keyframe), earlier)) {
      updates_.push_back(update->keyframe);
      kept_.push_back(std::move(*update));
    }
  }
  if (id < last_update) return {};  // sent once more for this closer alone
  known_to_owner_ = last_update;
  is_of_another_closer_ = known_to_owner_ && !std::binary_search(updates_.begin(), updates_.end(), *known_to_owner_);
  std::erase_if(kept_,
                [&](const GraphUpdate& update) { return is_of_another_closer_ || update.keyframe <= known_to_owner_; });
  if (is_of_another_closer_) return {};  // what was found here does not follow what was found there

  std::vector<pose_graph_t> answers;
  for (const GraphUpdate& update : kept_) {
    if (update.keyframe > id) break;
    const auto parts = MakeParts(update, graph().keyframe(update.keyframe).utime, epoch_);
    answers.insert(answers.end(), parts.begin(), parts.end());
  }
  const auto next = std::upper_bound(updates_.begin(), updates_.end(), id);
  const auto last = next == updates_.begin() ? std::nullopt : std::optional(*(next - 1));
  const bool owner_began_here = id == newest_ && last == id && last == known_to_owner_;  // with what a journal had
  if (last < id || owner_began_here) answers.push_back(MakeUnchanged(id, last, message.utime, epoch_));
  return answers;
}

std::optional<keyframe_request_t> KeyframeAnswers::NextRequest() const {
  constexpr std::size_t kMostRays = 8000;  // 64 KB: as much as the kernel surely keeps until it is read
  const auto after = graph().newest();
  if (newest_ <= after) return std::nullopt;
  const std::size_t rays = after ? graph().keyframe(*after).rays.size() : kMaxBeams;
  const std::size_t num = std::clamp<std::size_t>(kMostRays / std::max<std::size_t>(1, rays), 1, kMostKeyframesAtOnce);
  return keyframe_request_t{epoch_, ToMessage(after), static_cast<std::int32_t>(num), -1};
}

void KeyframeAnswers::Begin(std::int64_t epoch) {
  closer_ = make_closer_();
  epoch_ = epoch;
  newest_.reset();
  updates_.clear();
  kept_.clear();
  known_to_owner_.reset();
  is_of_another_closer_ = false;
}

/// Whether a keyframe that was there before is the same as then, and a new one follows the newest, if not at once.
bool KeyframeAnswers::Fits(const keyframe_t& message) const {
  const KeyframeId id = FromMessage(message.id);
  const auto previous = FromOptional(message.previous);
  if (!graph().Has(id)) return previous >= graph().newest();
  if (previous != graph().Before(id)) return false;
  const Keyframe& known = graph().keyframe(id);
  const Keyframe keyframe = FromMessage(message);
  return known.utime == keyframe.utime && known.T_previous_this == keyframe.T_previous_this &&
         known.rays == keyframe.rays;
}

}  // namespace crsm
