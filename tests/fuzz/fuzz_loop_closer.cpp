// KEYFRAME, as loop_closer takes it: its answers must be ones that the map's owner believes.

#include <cstdlib>

#include "common/graph/default_loop_closer.hpp"
#include "input.hpp"
#include "services/stages/keyframe_answers.hpp"
#include "services/wire/graph_messages.hpp"
#include "tame_pose.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 10.0};
constexpr int kMostKeyframes = 56;  // a search takes some milliseconds
constexpr int kMostMessages = 120;

void Check(pose_graph_t answer) {
  for (pose_stretch_t& stretch : answer.moved) {
    for (pose2_t& pose : stretch.poses) Tame(pose);
  }
  for (loop_finding_t& finding : answer.findings) Tame(finding.T_older_this);
  for (loop_t& loop : answer.closed) Tame(loop.T_older_newer);
  for (loop_t& loop : answer.rejected) Tame(loop.T_older_newer);
  if (!Decode<pose_graph_t>(Encode(answer))) std::abort();
}

/// Who gets the answers puts updates together that fit the keyframes.
void CheckUpdates(const std::vector<pose_graph_t>& messages, const KeyframeGraph& graph) {
  GraphUpdateParts parts;
  for (const pose_graph_t& message : messages) {
    if (message.changed == 0) continue;
    const auto update = parts.Add(message);
    if (update && !graph.Fits(*update)) std::abort();
  }
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  KeyframeAnswers answers(DefaultLoopCloser(kLoops, UpdateParameters{}));
  MessageReader messages({data, size});
  for (int i = 0; i < kMostMessages; ++i) {
    const auto bytes = messages.Next();
    if (!bytes || answers.graph().size() == kMostKeyframes) break;
    const auto keyframe = Decode<keyframe_t>(*bytes);
    if (!keyframe) continue;
    const auto answer = answers.Answer(*keyframe);
    for (const pose_graph_t& message : answer) Check(message);
    CheckUpdates(answer, answers.graph());
    const auto request = answers.NextRequest();
    if (request && !Decode<keyframe_request_t>(Encode(*request))) std::abort();
  }
  return 0;
}
