#include "services/map_updater/loop_closer_link.hpp"

#include <algorithm>
#include <utility>

namespace crsm {

LoopCloserLink::LoopCloserLink(Service& service, Mapper& mapper, int lag, std::function<void(const GraphUpdate&)> keep)
    : service_(service), mapper_(mapper), lag_(lag), keep_(std::move(keep)) {
  Count();
  Bus& bus = service.bus();
  bus.SubscribeToOne<pose_graph_t>(
      kPoseGraphChannel, [this](const pose_graph_t& message) { Take(message); }, SoleSender::kProbationOfAnswers);
  bus.Subscribe<keyframe_request_t>(kKeyframeRequestChannel,
                                    [this](const keyframe_request_t& request) { Answer(request); });
}

void LoopCloserLink::SendNewest() {
  Count();
  Send(mapper_.graph().size() - 1);
  backoff_.Restart(Clock::now());
}

void LoopCloserLink::Poll() {
  if (IsSettled() || !backoff_.Due(Clock::now())) return;
  service_.counters().Add("keyframes_resent");
  Send(mapper_.graph().size() - 1);
}

void LoopCloserLink::Count() {
  service_.counters().Set("keyframes", mapper_.graph().size());
  service_.counters().Set("loops_closed", mapper_.num_loops());
  service_.counters().Set("loops_taken_out", mapper_.num_loops_taken_out());
}

void LoopCloserLink::Send(int keyframe) {
  service_.bus().Publish(kKeyframeChannel,
                         ToMessage(mapper_.graph().keyframe(keyframe), {epoch_, keyframe, mapper_.last_update()}));
}

void LoopCloserLink::Answer(const keyframe_request_t& request) {
  if (request.epoch != epoch_) return;
  if (!request_limiter_.Admit(service_.bus().sender(), request.epoch, Clock::now())) {
    return service_.counters().Add("keyframe_requests_refused");
  }
  service_.counters().Add("keyframe_requests");
  const int num = std::min(request.num_keyframes, mapper_.graph().size() - request.first_keyframe);
  for (int i = 0; i < num; ++i) Send(request.first_keyframe + i);
}

void LoopCloserLink::Take(const pose_graph_t& message) {
  if (message.epoch != epoch_ || message.keyframe >= mapper_.graph().size()) {
    return service_.counters().Add("pose_graph_of_another_map");
  }
  if (message.previous != mapper_.last_update()) return;  // one is known already, or one before it was lost
  if (message.changed == 1) {
    const auto update = parts_.Add(message);
    if (!update) return;
    if (!mapper_.Offer(*update)) return service_.counters().Add("pose_graph_refused");
    Count();
    keep_(*update);
  }
  if (message.keyframe <= looked_through_) return;
  looked_through_ = message.keyframe;
  backoff_.Restart(Clock::now());
}

}  // namespace crsm
