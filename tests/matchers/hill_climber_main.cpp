// hill_climber: a process in the place of rrhc_matcher.

#include "services/stages/matcher_stage.hpp"
#include "tests/matchers/hill_climber.hpp"

int main(int argc, char** argv) {
  crsm::CommandLine command_line("hill_climber", "Matches each scan by one climb from where the last motion leads.", {},
                                 crsm::MatcherStage::Settings());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    crsm::MatcherStage(command_line, [](double cell_size_m) {
      return std::make_unique<crsm::HillClimber>(cell_size_m);
    }).Run();
  });
}
