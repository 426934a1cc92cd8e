// rrhc_matcher: CRITICAL_RAYS, the map so far and, with --odometry, ODOMETRY -> SCAN_MATCH and POSE.

#include "common/match/rrhc_matcher.hpp"
#include "services/stages/matcher_stage.hpp"

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "rrhc_matcher",
      "Matches each scan to the map by random restart hill climbing: CRITICAL_RAYS, MAP_DELTA -> SCAN_MATCH, POSE.",
      crsm::FlagsOfMatcher());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    const crsm::MatchParameters& parameters = command_line.parameters().match;
    crsm::MatcherStage(command_line, [&](double cell_size_m) {
      return std::make_unique<crsm::RrhcMatcher>(parameters, cell_size_m);
    }).Run();
  });
}
