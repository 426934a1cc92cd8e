// rrhc_matcher: CRITICAL_RAYS, the map so far and ODOMETRY, if there is any -> SCAN_MATCH and POSE.

#include "common/match/default_matcher.hpp"
#include "services/stages/matcher_stage.hpp"

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "rrhc_matcher",
      "Matches each scan to the map by random restart hill climbing: CRITICAL_RAYS, MAP_DELTA -> SCAN_MATCH, POSE.",
      crsm::FlagsOfMatcher());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    crsm::MatcherStage(command_line, crsm::DefaultMatcher(command_line.parameters())).Run();
  });
}
