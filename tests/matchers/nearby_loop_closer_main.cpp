// nearby_loop_closer: a process in the place of loop_closer.

#include "services/stages/loop_closer_stage.hpp"
#include "tests/matchers/nearby_loop_closer.hpp"

int main(int argc, char** argv) {
  crsm::CommandLine command_line("nearby_loop_closer", "Matches each place to the nearest one of long ago.", {},
                                 crsm::LoopCloserStage::Settings());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    crsm::LoopCloserStage(command_line, [] { return std::make_unique<crsm::NearbyLoopCloser>(); }).Run();
  });
}
