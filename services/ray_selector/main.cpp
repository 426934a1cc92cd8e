// ray_selector: LASER -> CRITICAL_RAYS. Keeps the measurements of each scan and says which of them are critical.

#include "common/scan/ray_selector.hpp"
#include "services/stages/selector_stage.hpp"

int main(int argc, char** argv) {
  crsm::CommandLine command_line("ray_selector", "Picks the critical rays of each scan: LASER -> CRITICAL_RAYS.",
                                 crsm::FlagsOfSelector());
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    crsm::RaySelector selector(command_line.parameters());
    crsm::SelectorStage(command_line, [&](const crsm::LaserScan& scan) { return selector.Select(scan); }).Run();
  });
}
