#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include "common/metrics/map_metrics.hpp"
#include "common/results/pictures.hpp"
#include "common/worlds/simulator.hpp"
#include "services/base/usage_error.hpp"
#include "services/slam_eval/commands.hpp"

namespace crsm {

namespace {

struct WorldOptions {
  std::string world;
  std::string out;
  double cell_size_m = 0.02;
};

/// The path that the simulated laser takes, as matches, which is what overviews draw.
std::vector<ScanMatch> DriveAlong(const World& world) {
  World blind = world;  // only its poses are wanted
  blind.walls.resize(1);
  Simulator simulator(blind, 0);
  std::vector<ScanMatch> path;
  while (const auto scan = simulator.Next()) {
    ScanMatch match;
    match.utime = scan->utime;
    match.T_map_laser = *simulator.TruePose();
    match.state = path.empty() ? MatchState::kFirst : MatchState::kOk;
    path.push_back(match);
  }
  return path;
}

void RunWorld(const WorldOptions& options) {
  const std::string text = LoadWorldText(options.world);
  const World world = ParseWorld(text, options.world);
  if (options.out.empty()) {
    fmt::print("{}", text);
    return;
  }
  if (!(options.cell_size_m >= 0.005 && options.cell_size_m <= 1.0)) {  // NaN too
    throw UsageError(fmt::format("--cell-size-m is {}, must be within 0.005 and 1", options.cell_size_m));
  }
  Results results;
  results.grid = DrawWorld(world, options.cell_size_m);
  results.matches = DriveAlong(world);
  const std::string picture = EncodeOverview(results);
  std::ofstream file(options.out, std::ios::binary);
  if (!(file << picture && file.flush())) {
    throw std::runtime_error(fmt::format("cannot write {}: {}", options.out, std::strerror(errno)));
  }
}

}  // namespace

void AddWorldCommand(Commands& commands) {
  const auto options = std::make_shared<WorldOptions>();
  commands
      .Add("world", "Prints the text of a simulated world, or draws the world and the laser's path",
           [options] { RunWorld(*options); })
      .AddWord("WORLD", options->world, "world file, or one of " + DescribeBuiltInWorlds())
      .AddOption("--out", options->out, "PNG file for the drawing")
      .AddOption("--cell-size-m", options->cell_size_m, "side of a cell of the picture [m]");
}

}  // namespace crsm
