// loop_closer: KEYFRAME -> POSE_GRAPH. Finds where the path comes back to where it was, and says where the keyframes
// are now.

#include "common/graph/default_loop_closer.hpp"
#include "services/stages/loop_closer_stage.hpp"

int main(int argc, char** argv) {
  crsm::CommandLine command_line("loop_closer",
                                 "Finds loop closures and corrects the pose graph: KEYFRAME -> POSE_GRAPH.",
                                 crsm::FlagsOfLoopCloser());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    const crsm::Parameters& parameters = command_line.parameters();
    crsm::LoopCloserStage(command_line, crsm::DefaultLoopCloser(parameters.loops, parameters.update)).Run();
  });
}
