#include "services/slam_eval/commands.hpp"

int main(int argc, char** argv) {
  crsm::Commands commands("slam_eval", "Measures how good a map or a trajectory is, and draws floor plans.");
  crsm::AddExportCommand(commands);
  crsm::AddMapCommand(commands);
  crsm::AddTrajectoryCommand(commands);
  crsm::AddRelationsCommand(commands);
  crsm::AddPlanCommand(commands);
  crsm::AddSummaryCommand(commands);
  crsm::AddWorldCommand(commands);
  return commands.Run(argc, argv);
}
