#pragma once

#include <optional>

#include "services/base/backoff.hpp"
#include "services/bus/service.hpp"
#include "services/settings/command_line.hpp"
#include "services/stages/keyframe_answers.hpp"

namespace crsm {

/// What a process is that closes loops, whatever finds them: KEYFRAME -> POSE_GRAPH, KEYFRAME_REQUEST and, with --out,
/// the file graph.g2o.
///
/// A keyframe that comes once more gets its answer once more. Keyframes that are lacking, after a restart or a loss,
/// are asked for, so a loop closer that is started again comes to the same answers.
class LoopCloserStage {
 public:
  LoopCloserStage(const CommandLine& command_line, MakeLoopCloser make_closer);

  /// Until a signal asks to end.
  void Run();

  /// Names of the settings that become flags, for the command line.
  static std::vector<std::string> Settings() { return FlagsOfLoopCloser().settings; }

 private:
  void Answer(const keyframe_t& message);
  void Describe();
  void AskForMore();
  void Write();

  const crsm::Settings& settings_;
  Service service_;
  KeyframeAnswers answers_;
  std::optional<keyframe_request_t> asked_;
  int size_when_asked_ = 0;  ///< of the graph
  int last_size_ = 0;        ///< of the graph, when it was last looked whether what was asked for comes
  Backoff backoff_{std::chrono::milliseconds(50)};
  int written_ = 0;  ///< keyframes in graph.g2o
  Clock::time_point next_write_{};
};

}  // namespace crsm
