#include "crsm_slam/slam.hpp"

#include <cmath>
#include <set>
#include <span>
#include <stdexcept>
#include <unordered_set>
#include <utility>

#include "common/library/presets.hpp"
#include "common/set_parameter.hpp"
#include "common/slam.hpp"

namespace crsm_slam {
namespace {

void SetParameter(crsm::Parameters& parameters, const std::string& key, const std::string& text) {
  crsm::ValueSetter setter(key, {crsm::WrittenValue::Kind::kFlag, text});
  crsm::VisitParameters(parameters, setter);
  if (!setter.found()) throw std::runtime_error(key + ": no such key; slam_offline --help lists them, with - for _");
}

std::set<std::string> NamesOf(std::span<const PresetValue> values) {
  std::set<std::string> names;
  for (const PresetValue& value : values) names.emplace(value.name);
  return names;
}

void Apply(std::span<const PresetValue> values, const std::string& name, crsm::Parameters& parameters) {
  for (const PresetValue& value : values) {
    if (value.name == name) SetParameter(parameters, std::string(value.key), std::string(value.text));
  }
}

crsm::Parameters MakeParameters(const Settings& settings) {
  const std::set<std::string> presets = NamesOf(kPresetValues);
  std::set<std::string> profiles = NamesOf(kProfileValues);
  profiles.insert("default");
  const auto Check = [](const std::string& kind, const std::string& name, const std::set<std::string>& names) {
    if (name.empty() || names.contains(name)) return;
    throw std::runtime_error(kind + ": '" + name + "' is not one of " + crsm::JoinNames(names));
  };
  Check("preset", settings.preset, presets);
  Check("profile", settings.profile, profiles);
  crsm::Parameters parameters;
  Apply(kPresetValues, settings.preset, parameters);
  Apply(kProfileValues, settings.profile, parameters);
  for (const auto& [key, text] : settings.values) SetParameter(parameters, key, text);
  crsm::CheckConsistency(parameters);
  return parameters;
}

crsm::Parameters CheckedParameters(const Settings& settings) {
  try {
    return MakeParameters(settings);
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
}

/// Throws if it cannot be what a laser measured.
void Check(const Scan& scan) {
  const auto Refuse = [&](const std::string& what) {
    throw std::invalid_argument("scan of utime " + std::to_string(scan.utime) + ": " + what);
  };
  const std::size_t num_beams = scan.ranges_m.size();
  if (scan.utime < 0) Refuse("must be 0 or later");
  if (num_beams < crsm::kMinBeams || num_beams > crsm::kMaxBeams) {
    Refuse(std::to_string(num_beams) + " ranges, must be " + std::to_string(crsm::kMinBeams) + " to " +
           std::to_string(crsm::kMaxBeams));
  }
  const double sweep_rad = static_cast<double>(scan.angle_step_rad) * static_cast<double>(num_beams - 1);
  if (!crsm::IsWithinFullTurn(scan.angle_min_rad)) Refuse("angle_min_rad must be within a full turn");
  if (!crsm::IsWithinFullTurn(sweep_rad)) Refuse("angle_step_rad times its ranges must be within a full turn");
  if (scan.angle_step_rad == 0.0f) Refuse("angle_step_rad must not be 0");
}

Pose ToPublic(const crsm::Pose2& pose) { return {pose.x_m, pose.y_m, pose.yaw_rad}; }

std::optional<crsm::Pose2> FromPublic(const std::optional<Pose>& T_odom_robot) {
  if (!T_odom_robot) return std::nullopt;
  const auto pose = crsm::RoundOdometry({T_odom_robot->x_m, T_odom_robot->y_m, T_odom_robot->yaw_rad});
  if (!pose) throw std::invalid_argument("T_odom_robot: its numbers must be finite and within 1e6");
  return pose;
}

}  // namespace

std::vector<std::string> Presets() {
  const std::set<std::string> names = NamesOf(kPresetValues);
  return {names.begin(), names.end()};
}

std::string Version() { return CRSM_SLAM_VERSION; }

struct Slam::Impl {
  explicit Impl(const crsm::Parameters& parameters) : slam(parameters) {}

  void Hear(const std::vector<crsm::GraphUpdate>& updates) {
    for (const crsm::GraphUpdate& update : updates) loop_closed |= !update.closed.empty();
  }

  /// What is asked for is by all that the scans so far can tell.
  crsm::Slam& Await() {
    Hear(slam.AwaitLoops());
    return slam;
  }

  crsm::Slam slam;
  std::vector<StampedPose> matched;  ///< as they were matched
  std::unordered_set<std::int64_t> utimes;
  bool loop_closed = false;  ///< and not told yet
};

Slam::Slam(const Settings& settings) : impl_(std::make_unique<Impl>(CheckedParameters(settings))) {}
Slam::~Slam() = default;
Slam::Slam(Slam&&) noexcept = default;
Slam& Slam::operator=(Slam&&) noexcept = default;

Step Slam::Process(const Scan& scan, const std::optional<Pose>& T_odom_robot) {
  Check(scan);
  const auto odometry = FromPublic(T_odom_robot);
  if (!impl_->utimes.insert(scan.utime).second) {
    throw std::invalid_argument("scan of utime " + std::to_string(scan.utime) + ": this utime was there before");
  }
  const crsm::Slam::Step step =
      impl_->slam.Process({scan.utime, scan.angle_min_rad, scan.angle_step_rad, scan.ranges_m}, odometry);
  const crsm::ScanMatch& match = step.match;
  Step result{static_cast<State>(match.state),
              ToPublic(match.T_map_laser),
              match.fitness,
              match.covariance,
              match.degenerate_axis,
              step.drawn};
  impl_->Hear(step.updates);
  result.loop_closed = std::exchange(impl_->loop_closed, false);
  result.on_map = impl_->slam.mapper().IsScanOnMap(std::ssize(impl_->matched));
  impl_->matched.push_back({scan.utime, result.T_map_laser, result.state});
  return result;
}

Map Slam::MakeMap() const {
  crsm::Slam& slam = impl_->Await();
  const crsm::DenseGrid grid = slam.closes_loops() ? slam.Finalize({}).map.ToDenseGrid() : slam.map().ToDenseGrid();
  return {grid.width_cells,
          grid.height_cells,
          grid.cell_size_m,
          {grid.origin_x_cells * grid.cell_size_m, grid.origin_y_cells * grid.cell_size_m, 0.0},
          grid.cells};
}

std::vector<StampedPose> Slam::Trajectory() const {
  const crsm::Slam& slam = impl_->Await();
  std::vector<StampedPose> trajectory = impl_->matched;
  const std::vector<int> pieces = slam.mapper().FindPieceNumbers();
  const crsm::TrajectoryLog& trajectories = slam.mapper().trajectories();
  int next = 0;  // of them
  std::int64_t scan = 0;
  for (StampedPose& at : trajectory) {
    const auto& [x_m, y_m, yaw_rad] = at.T_map_laser;
    at.T_map_laser = ToPublic(slam.BestPose(scan, {x_m, y_m, yaw_rad}));
    while (next < trajectories.size() && trajectories.at(next).start.scan <= scan) ++next;
    if (next > 0) at.piece = pieces[static_cast<std::size_t>(next) - 1];
    ++scan;
  }
  return trajectory;
}

std::vector<Loop> Slam::Loops() const {
  const crsm::KeyframeGraph graph = impl_->Await().MakeBestGraph();
  std::vector<Loop> loops;
  for (const crsm::Loop& loop : graph.loops()) {
    loops.push_back({graph.keyframe(loop.older).utime, graph.keyframe(loop.newer).utime, ToPublic(loop.T_older_newer)});
  }
  return loops;
}

}  // namespace crsm_slam
