#include "services/map_updater/loop_closer_link.hpp"

#include <algorithm>
#include <utility>

namespace crsm {

LoopCloserLink::LoopCloserLink(Mapper& mapper, int lag, Counters& counters, Owner owner)
    : mapper_(mapper), lag_(lag), counters_(counters), owner_(std::move(owner)) {
  Count();
}

void LoopCloserLink::SendNewest(Clock::time_point now) {
  Count();
  Send(mapper_.graph().size() - 1);
  backoff_.Restart(now);
}

void LoopCloserLink::Poll(Clock::time_point now) {
  if (IsSettled() || !backoff_.Due(now)) return;
  counters_.Add("keyframes_resent");
  Send(mapper_.graph().size() - 1);
}

void LoopCloserLink::Count() {
  counters_.Set("keyframes", mapper_.graph().size());
  counters_.Set("loops_closed", mapper_.num_loops());
  counters_.Set("loops_taken_out", mapper_.num_loops_taken_out());
}

void LoopCloserLink::Send(int keyframe) {
  owner_.send(ToMessage(mapper_.graph().keyframe(keyframe), {epoch_, keyframe, mapper_.last_update()}));
}

void LoopCloserLink::Answer(const keyframe_request_t& request, const Sender& sender, Clock::time_point now) {
  if (request.epoch != epoch_) return;
  if (!request_limiter_.Admit(sender, request.epoch, now)) return counters_.Add("keyframe_requests_refused");
  counters_.Add("keyframe_requests");
  const int num = std::min(request.num_keyframes, mapper_.graph().size() - request.first_keyframe);
  for (int i = 0; i < num; ++i) Send(request.first_keyframe + i);
}

void LoopCloserLink::Take(const pose_graph_t& message, Clock::time_point now) {
  if (message.epoch != epoch_ || message.keyframe >= mapper_.graph().size()) {
    return counters_.Add("pose_graph_of_another_map");
  }
  if (message.previous != mapper_.last_update()) return;  // one is known already, or one before it was lost
  if (message.changed == 1) {
    const auto update = parts_.Add(message);
    if (!update && !parts_.empty()) return;  // others are to come
    if (!update || !mapper_.Offer(*update)) return counters_.Add("pose_graph_refused");
    Count();
    owner_.keep(*update);
  }
  if (message.keyframe <= looked_through_) return;
  looked_through_ = message.keyframe;
  backoff_.Restart(now);
}

}  // namespace crsm
