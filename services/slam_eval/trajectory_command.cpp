#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "common/metrics/trajectory_error.hpp"
#include "services/slam_eval/commands.hpp"

namespace crsm {

namespace {

struct TrajectoryOptions {
  std::string trajectory;
  std::string truth;
  bool align = false;
  bool json = false;
};

void RunTrajectory(const TrajectoryOptions& options) {
  const std::filesystem::path path(options.trajectory);
  const bool folder = std::filesystem::is_directory(path);
  const std::filesystem::path beside = (folder ? path : path.parent_path()) / "truth.tum";
  const std::string truth = options.truth.empty() ? beside.string() : options.truth;
  Trajectory trajectory = ReadTrajectory(folder ? (path / "trajectory.tum").string() : options.trajectory);
  const Trajectory true_trajectory = ReadTrajectory(truth);
  if (options.align) trajectory = Align(trajectory, true_trajectory);
  const TrajectoryError error = EvaluateTrajectory(trajectory, true_trajectory);
  if (options.json) {
    fmt::print("{{\"poses\": {}, \"mean_m\": {}, \"median_m\": {}, \"max_m\": {}, \"rmse_m\": {}, \"max_rad\": {}}}\n",
               error.num_poses, error.mean_m, error.median_m, error.max_m, error.rmse_m, error.max_rad);
  } else {
    fmt::print("error of {} poses: mean {:.4f}, median {:.4f}, max {:.4f}, rmse {:.4f} m; max {:.4f} rad\n",
               error.num_poses, error.mean_m, error.median_m, error.max_m, error.rmse_m, error.max_rad);
  }
}

}  // namespace

void AddTrajectoryCommand(Commands& commands) {
  const auto options = std::make_shared<TrajectoryOptions>();
  commands.Add("trajectory", "Absolute error against the true poses", [options] { RunTrajectory(*options); })
      .AddWord("TRAJECTORY", options->trajectory, "TUM file, or a folder that holds trajectory.tum")
      .AddOptionalWord("TRUTH", options->truth, "TUM file; without it: truth.tum beside the trajectory")
      .AddFlag("--align", options->align, "first align the whole trajectory to the true poses")
      .AddFlag("--json", options->json, "print one JSON object");
}

}  // namespace crsm
