#include "services/stages/loop_closer_stage.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <utility>

#include "common/graph/g2o.hpp"
#include "common/logs/replacement.hpp"

namespace crsm {

LoopCloserStage::LoopCloserStage(const CommandLine& command_line, MakeLoopCloser make_closer)
    : settings_(command_line.settings()), service_(command_line), answers_(std::move(make_closer)) {
  service_.TakeRole(kLoopCloserRole);
  service_.bus().SubscribeToOne<keyframe_t>(kKeyframeChannel, kMapOwnerRole,
                                            [this](const keyframe_t& message) { Answer(message); });
}

void LoopCloserStage::Run() {
  if (!settings_.out.empty()) std::filesystem::create_directories(settings_.out);
  constexpr int kPeriod_ms = 20;  // of requests for keyframes that do not come
  service_.Run(
      [this] {
        AskForMore();
        if (Clock::now() >= next_write_) Write();
        return true;
      },
      kPeriod_ms);
  Write();
}

void LoopCloserStage::Answer(const keyframe_t& message) {
  if (StopRequested()) return;  // a search takes long, and more keyframes may wait: they come again
  const auto start = Clock::now();
  const int size_before = answers_.graph().size();
  for (const pose_graph_t& answer : answers_.Answer(message)) service_.bus().Publish(kPoseGraphChannel, answer);
  if (answers_.graph().size() == size_before) return service_.counters().Add("resent");
  service_.RecordLatency(start);
  service_.counters().Set("keyframes", answers_.graph().size());
  service_.counters().Set("keyframes_searched", answers_.num_searched());
  service_.counters().Set("loops_closed", static_cast<std::int64_t>(answers_.graph().loops().size()));
  service_.counters().Set("loops_rejected", answers_.graph().num_loops_dropped());
  Describe();
}

void LoopCloserStage::Describe() {
  if (!answers_.is_of_another_closer()) return service_.SetState("looking for loops");
  constexpr const char* kOther = "the map was corrected by another loop closer, or with other parameters";
  if (service_.MakeStatus().state != kOther) {
    Say(fmt::format("{}: {}: this loop closer does not correct it any further", service_.name(), kOther));
  }
  service_.SetState(kOther);
}

/// What was asked for comes, or is asked for again after a while.
void LoopCloserStage::AskForMore() {
  const auto request = answers_.NextRequest();
  if (!request) return asked_.reset();
  const auto now = Clock::now();
  const int size = answers_.graph().size();
  const bool is_coming = asked_ && asked_->epoch == request->epoch && size >= size_when_asked_ &&
                         size < size_when_asked_ + asked_->num_keyframes;
  if (!is_coming || std::exchange(last_size_, size) != size) backoff_.Restart(now);
  if (is_coming && !backoff_.Due(now)) return;
  asked_ = request;
  size_when_asked_ = last_size_ = size;
  service_.counters().Add("keyframe_requests");
  service_.bus().Publish(kKeyframeRequestChannel, *request);
}

/// The graph, in g2o's text, where it has grown.
void LoopCloserStage::Write() {
  next_write_ = Clock::now() + std::chrono::seconds(5);
  const int size = answers_.graph().size();
  if (settings_.out.empty() || size == written_) return;
  try {
    Replacement files(settings_.out);
    files.Write("graph.g2o", FormatG2o(answers_.graph().MakePoseGraph()));
    files.Rename();
    written_ = size;
  } catch (const std::runtime_error& error) {
    service_.Complain("write_failed", fmt::format("{}: {}", service_.name(), error.what()));
  }
}

}  // namespace crsm
