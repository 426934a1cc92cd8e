#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "common/metrics/relations.hpp"
#include "common/metrics/trajectory.hpp"
#include "services/base/usage_error.hpp"
#include "services/slam_eval/commands.hpp"

namespace crsm {

namespace {

struct RelationsOptions {
  std::string trajectory;
  std::string relations;
  double laser_x_m = 0.0;
  bool json = false;
};

void PrintJson(const RelationErrors& errors) {
  const auto Format = [](const ErrorStatistics& s) {
    return fmt::format(R"({{"mean": {}, "std": {}, "median": {}, "max": {}}})", s.mean, s.standard_deviation, s.median,
                       s.max);
  };
  fmt::print("{{\"relations_used\": {}, \"relations_missing\": {}, \"translation_m\": {}, \"rotation_rad\": {}}}\n",
             errors.num_used, errors.num_missing, Format(errors.translation_m), Format(errors.rotation_rad));
}

void PrintTable(const RelationErrors& errors) {
  const auto PrintRow = [](const char* name, const ErrorStatistics& s, double scale) {
    fmt::print("{:<17}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}\n", name, s.mean * scale, s.standard_deviation * scale,
               s.median * scale, s.max * scale);
  };
  fmt::print("relations used {}, missing {}\n", errors.num_used, errors.num_missing);
  fmt::print("{:<17}{:>10}{:>10}{:>10}{:>10}\n", "error", "mean", "std", "median", "max");
  PrintRow("translation [m]", errors.translation_m, 1.0);
  PrintRow("rotation [rad]", errors.rotation_rad, 1.0);
  PrintRow("rotation [deg]", errors.rotation_rad, 180.0 / kPi);
}

void RunRelations(const RelationsOptions& options) {
  if (!(std::abs(options.laser_x_m) <= 10.0)) {  // NaN too
    throw UsageError(fmt::format("--laser-x-m is {}, must be within -10 and 10", options.laser_x_m));
  }
  const std::filesystem::path path(options.trajectory);
  const Trajectory trajectory =
      ReadTrajectory(std::filesystem::is_directory(path) ? (path / "trajectory.tum").string() : options.trajectory);
  const RelationErrors errors =
      EvaluateRelations(ReadRelations(options.relations), trajectory, {options.laser_x_m, 0.0, 0.0});
  options.json ? PrintJson(errors) : PrintTable(errors);
}

}  // namespace

void AddRelationsCommand(Commands& commands) {
  const auto options = std::make_shared<RelationsOptions>();
  commands
      .Add("relations", "Error against known relations of the robot's poses (Kuemmerle et al. 2009)",
           [options] { RunRelations(*options); })
      .AddWord("TRAJECTORY", options->trajectory, "TUM file, or a folder that holds trajectory.tum")
      .AddWord("RELATIONS", options->relations, "lines of t1 t2 x y z roll pitch yaw")
      .AddOption("--laser-x-m", options->laser_x_m,
                 "how far the laser is mounted ahead of the robot's centre [m]; -0.04 for fr079")
      .AddFlag("--json", options->json, "print one JSON object");
}

}  // namespace crsm
