#include <fmt/format.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "common/logs/read_map.hpp"
#include "common/metrics/map_metrics.hpp"
#include "common/results/read_results.hpp"
#include "services/slam_eval/commands.hpp"

namespace crsm {

namespace {

struct MapOptions {
  std::string results;
  std::string world;
  bool json = false;
};

void PrintJson(const ObstacleError& obstacles, const CornerError& corners, double mean_fitness) {
  std::string list;
  for (const CornerMatch& corner : corners.corners) {
    list += fmt::format(R"({}{{"name": "{}", "dx_px": {}, "dy_px": {}, "likeness": {}}})", list.empty() ? "" : ", ",
                        corner.name, corner.dx_px, corner.dy_px, corner.likeness);
  }
  fmt::print("{{\"obstacles\": {}, \"omse_px2\": {}, \"cmse_px2\": {}, \"mean_fitness\": {}, \"corners\": [{}]}}\n",
             obstacles.num_obstacles, obstacles.omse_px2, corners.cmse_px2, mean_fitness, list);
}

void PrintTable(const ObstacleError& obstacles, const CornerError& corners, double mean_fitness) {
  fmt::print("OMSE {:.2f} px2, of {} obstacle cells\n", obstacles.omse_px2, obstacles.num_obstacles);
  fmt::print("CMSE {:.2f} px2, of {} corners\n", corners.cmse_px2, corners.corners.size());
  fmt::print("MFV {:.4f}\n", mean_fitness);
  fmt::print("{:<32}{:>8}{:>8}{:>10}\n", "corner", "dx [px]", "dy [px]", "likeness");
  for (const CornerMatch& corner : corners.corners) {
    fmt::print("{:<32}{:>8.2f}{:>8.2f}{:>10.2f}\n", corner.name, corner.dx_px, corner.dy_px, corner.likeness);
  }
}

void RunMap(const MapOptions& options) {
  const DenseGrid map = ReadMap(options.results);
  const World world = LoadWorld(options.world);
  const ObstacleError obstacles = EvaluateObstacles(map, world);
  const CornerError corners = EvaluateCorners(map, world);
  std::string missing;
  for (const CornerMatch& corner : corners.corners) {
    if (corner.found) continue;
    missing += fmt::format("{}{} (likeness {:.2f})", missing.empty() ? "" : ", ", corner.name, corner.likeness);
  }
  if (!missing.empty()) {
    throw std::runtime_error(fmt::format("{} of the {} corners of {} are not in the map of {}: {}; OMSE is {:.2f} px2",
                                         corners.num_missing, corners.corners.size(), options.world, options.results,
                                         missing, obstacles.omse_px2));
  }
  const double mean_fitness = ReadMeanFitness(options.results);
  options.json ? PrintJson(obstacles, corners, mean_fitness) : PrintTable(obstacles, corners, mean_fitness);
}

}  // namespace

void AddMapCommand(Commands& commands) {
  const auto options = std::make_shared<MapOptions>();
  commands.Add("map", "OMSE, CMSE and MFV of the map of a simulated world (section 3)", [options] { RunMap(*options); })
      .AddWord("RESULTS", options->results, "folder with map.png, map.yaml and summary.json")
      .AddWord("WORLD", options->world, "built-in world or world file")
      .AddFlag("--json", options->json, "print one JSON object");
}

}  // namespace crsm
