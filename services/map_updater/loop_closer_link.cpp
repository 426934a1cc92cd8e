#include "services/map_updater/loop_closer_link.hpp"

#include <utility>

namespace crsm {

LoopCloserLink::LoopCloserLink(Mapper& mapper, Counters& counters, Owner owner)
    : mapper_(mapper), counters_(counters), owner_(std::move(owner)), request_limiter_(owner_.is_loop_closer) {}

void LoopCloserLink::SendNewest(Clock::time_point now) {
  Send(*mapper_.graph().newest());
  backoff_.Restart(now);
}

void LoopCloserLink::Poll(Clock::time_point now) {
  if (IsSettled() || !backoff_.Due(now)) return;
  counters_.Add("keyframes_resent");
  Send(*mapper_.graph().newest());
}

void LoopCloserLink::Send(KeyframeId id) {
  const KeyframeGraph& graph = mapper_.graph();
  owner_.send(
      ToMessage(graph.keyframe(id), {epoch_, id, graph.Before(id), mapper_.last_update(), mapper_.FindSearch(id)}));
}

void LoopCloserLink::Answer(const keyframe_request_t& request, const Sender& sender, Clock::time_point now) {
  const bool is_unknown = request.epoch == 0;
  if (!is_unknown && request.epoch != epoch_) return;
  if (!request_limiter_.Admit(sender, request.epoch, now)) return counters_.Add("keyframe_requests_refused");
  counters_.Add("keyframe_requests");
  const KeyframeGraph& graph = mapper_.graph();
  if (!is_unknown && request.marks_held >= 0) owner_.tell_marks(request.marks_held);
  if (is_unknown) return graph.newest() ? Send(*graph.newest()) : void();
  const auto after = FromOptional(request.after);
  if (after && !graph.Has(*after)) return;
  auto next = after ? graph.After(*after) : KeyframeId{};
  for (int i = 0; i < request.num_keyframes && next && graph.Has(*next); ++i, next = graph.After(*next)) Send(*next);
}

void LoopCloserLink::Take(const pose_graph_t& message, Clock::time_point now) {
  const KeyframeId keyframe = FromMessage(message.keyframe);
  if (message.epoch != epoch_ || !mapper_.graph().Has(keyframe)) {
    return counters_.Add("pose_graph_of_another_map");
  }
  const bool is_next = FromOptional(message.previous) == mapper_.last_update();
  if (!is_next) return;  // one is known already, or one before it was lost
  if (message.changed == 1) {
    if (message.num_parts > MostParts(mapper_.graph().size())) return counters_.Add("pose_graph_refused");
    const auto update = parts_.Add(message);
    if (!update && !parts_.empty()) return;  // others are to come
    if (!update || !mapper_.Accept(*update)) return counters_.Add("pose_graph_refused");
    owner_.keep(*update);
  }
  if (keyframe <= looked_through_) return;
  looked_through_ = keyframe;
  mapper_.NoteSearched(keyframe);
  owner_.keep_searched(keyframe);
  backoff_.Restart(now);
}

}  // namespace crsm
