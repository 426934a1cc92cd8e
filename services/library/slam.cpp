#include "crsm_slam/slam.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include "common/math/format_number.hpp"
#include "common/math/nearest_name.hpp"
#include "common/set_parameter.hpp"
#include "services/library/impl.hpp"
#include "services/library/presets.hpp"

namespace crsm_slam {
namespace {

void SetParameter(crsm::Parameters& parameters, const std::string& key, const std::string& text) {
  crsm::ValueSetter setter(key, {crsm::WrittenValue::Kind::kFlag, text});
  crsm::VisitParameters(parameters, setter);
  if (setter.found()) return;
  throw std::runtime_error(key + ": no such key; slam_offline --help lists them, with - for _" +
                           crsm::SuggestName(key, setter.keys()));
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

/// Those that are set one by one, as text.
std::map<std::string, std::string> ListSingle(const Settings& settings) {
  std::map<std::string, std::string> texts;
  const auto Add = [&](const char* key, const auto& value) {
    if (value) texts.emplace(key, crsm::FormatValue(crsm::ParameterValue(*value)));
  };
  const auto AddWhole = [&](const char* key, const std::optional<int>& value) {
    Add(key, value ? std::optional(std::int64_t{*value}) : std::nullopt);
  };
  Add("range_min_m", settings.range_min_m);
  Add("range_max_m", settings.range_max_m);
  Add("angle_scale", settings.angle_scale);
  Add("sweep_s", settings.sweep_s);
  Add("beam_times", settings.beam_times);
  AddWhole("rays_max", settings.rays_max);
  Add("seed", settings.seed);
  Add("cell_size_m", settings.cell_size_m);
  Add("update_distance_m", settings.update_distance_m);
  Add("update_angle_rad", settings.update_angle_rad);
  Add("loops", settings.loops);
  Add("local_map_m", settings.local_map_m);
  for (const auto& [key, text] : settings.values) texts[key] = text;
  return texts;
}

/// made_with: by which an earlier map was made; what is set one by one goes before.
crsm::Parameters MakeParameters(const Settings& settings, const crsm::ParameterTexts& made_with) {
  const std::set<std::string> presets = NamesOf(kPresetValues);
  std::set<std::string> profiles = NamesOf(kProfileValues);
  profiles.insert("default");
  const auto Check = [](const std::string& kind, const std::string& name, const std::set<std::string>& names) {
    if (name.empty() || names.contains(name)) return;
    throw std::runtime_error(kind + ": '" + name + "' is not one of " + crsm::JoinNames(names) +
                             crsm::SuggestName(name, {names.begin(), names.end()}));
  };
  Check("preset", settings.preset, presets);
  Check("profile", settings.profile, profiles);
  crsm::Parameters parameters;
  Apply(kPresetValues, settings.preset, parameters);
  Apply(kProfileValues, settings.profile, parameters);
  for (const auto& [key, text] : made_with) SetParameter(parameters, key, text);
  for (const auto& [key, text] : ListSingle(settings)) SetParameter(parameters, key, text);
  crsm::CheckConsistency(parameters);
  return parameters;
}

/// Throws if it cannot be what a laser measured.
void Check(const Scan& scan) {
  const auto Refuse = [&](const std::string& what) {
    throw std::invalid_argument("scan of utime " + std::to_string(scan.utime) + ": " + what);
  };
  const std::size_t num_beams = scan.ranges_m.size();
  if (scan.utime < 0) Refuse("utime must be 0 or later");
  if (num_beams < crsm::kMinBeams || num_beams > crsm::kMaxBeams) {
    Refuse(std::to_string(num_beams) + " ranges, must be " + std::to_string(crsm::kMinBeams) + " to " +
           std::to_string(crsm::kMaxBeams));
  }
  const double sweep_rad = static_cast<double>(scan.angle_step_rad) * static_cast<double>(num_beams - 1);
  if (!crsm::IsWithinFullTurn(scan.angle_min_rad)) {
    Refuse("angle_min_rad " + crsm::FormatNumber(scan.angle_min_rad) + " must be within a full turn: radians");
  }
  if (!crsm::IsWithinFullTurn(sweep_rad)) {
    Refuse("angle_step_rad " + crsm::FormatNumber(scan.angle_step_rad) + " times its ranges, " +
           std::to_string(num_beams) + ", must be within a full turn: radians");
  }
  if (scan.angle_step_rad == 0.0f) Refuse("angle_step_rad must not be 0");
  if (scan.times_s.empty()) return;
  if (scan.times_s.size() != num_beams) {
    Refuse(std::to_string(scan.times_s.size()) + " times_s, must be none or " + std::to_string(num_beams));
  }
  const auto IsTime = [](float time_s) { return std::abs(time_s) <= crsm::kLongestSweep_s; };
  if (!std::ranges::all_of(scan.times_s, IsTime))
    Refuse("times_s must be within 2 s of utime, from which they are counted");
}

Pose ToPublic(const crsm::Pose2& pose) { return {pose.x_m, pose.y_m, pose.yaw_rad}; }

}  // namespace

crsm::Parameters CheckedParameters(const Settings& settings, const crsm::ParameterTexts& made_with) {
  try {
    return MakeParameters(settings, made_with);
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
}

std::optional<crsm::Pose2> FromPublic(const std::optional<Pose>& pose, const char* name) {
  if (!pose) return std::nullopt;
  const crsm::Pose2 same{pose->x_m, pose->y_m, pose->yaw_rad};
  if (!crsm::RoundOdometry(same)) {
    throw std::invalid_argument(std::string(name) + ": its numbers must be finite and within 1e6");
  }
  return same;
}

std::vector<std::string> Presets() {
  const std::set<std::string> names = NamesOf(kPresetValues);
  return {names.begin(), names.end()};
}

std::string Version() { return CRSM_SLAM_VERSION; }

Slam::Slam(const Settings& settings) : impl_(std::make_unique<Impl>(CheckedParameters(settings))) {}
Slam::~Slam() = default;
Slam::Slam(Slam&&) noexcept = default;
Slam& Slam::operator=(Slam&&) noexcept = default;

Step Slam::Process(const Scan& scan, const std::optional<Pose>& T_odom_robot) {
  Check(scan);
  const auto unrounded = FromPublic(T_odom_robot, "T_odom_robot");
  const auto odometry = unrounded ? crsm::RoundOdometry(*unrounded) : std::nullopt;
  if (!impl_->utimes.insert(scan.utime).second) {
    throw std::invalid_argument("scan of utime " + std::to_string(scan.utime) +
                                ": this utime was used before; each scan has its own: where the clock begins anew, add "
                                "to the times of the drive what no drive before has");
  }
  const crsm::Pose2 T_local_map = impl_->slam.tracking().T_local_map();
  const crsm::Slam::Step step =
      impl_->slam.Process({scan.utime, scan.angle_min_rad, scan.angle_step_rad, scan.ranges_m, scan.times_s}, odometry);
  const crsm::ScanMatch& match = step.match;
  Step result{static_cast<State>(match.state),
              ToPublic(match.T_map_laser),
              ToPublic(T_local_map * match.T_map_laser),
              match.fitness,
              match.covariance,
              match.degenerate_axis,
              step.drawn};
  impl_->statistics.Add(scan.utime, step.scan.rays);
  impl_->last_scan = step.scan;
  impl_->Add(match, step.drawn);
  if (step.drawn) impl_->KeepRays(step.scan, match.twist);
  impl_->Hear(step.updates);
  result.loop_closed = std::exchange(impl_->loop_closed, false);
  result.on_map = impl_->slam.mapper().IsScanOnMap(std::ssize(impl_->matched) - 1);
  return result;
}

Map Slam::MakeMap() const {
  const crsm::DenseGrid grid = impl_->DrawGrid();
  return {grid.width_cells,
          grid.height_cells,
          grid.cell_size_m,
          {grid.origin_x_cells * grid.cell_size_m, grid.origin_y_cells * grid.cell_size_m, 0.0},
          grid.cells};
}

std::vector<StampedPose> Slam::Trajectory() const {
  const crsm::Slam& slam = impl_->Await();
  std::vector<StampedPose> trajectory;
  const std::vector<int> pieces = slam.mapper().FindPieceNumbers();
  const crsm::TrajectoryLog& trajectories = slam.mapper().trajectories();
  int next = 0;  // of them
  for (std::int64_t scan = 0; scan < std::ssize(impl_->matched); ++scan) {
    const crsm::ScanMatch& match = impl_->matched[static_cast<std::size_t>(scan)];
    const crsm::Pose2 pose = impl_->finished ? match.T_map_laser : slam.BestPose(scan, match.T_map_laser);
    trajectory.push_back({match.utime, ToPublic(pose), static_cast<State>(match.state)});
    if (impl_->finished) continue;
    while (next < trajectories.size() && trajectories.at(next).start.scan <= scan) ++next;
    if (next > 0) trajectory.back().piece = pieces[static_cast<std::size_t>(next) - 1];
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

MapChanges Slam::ChangesSince(std::int64_t version) {
  MapChanges changes;
  impl_->WithMap([&](const crsm::ByteMap& map) {
    impl_->Tell(map);
    changes.cell_size_m = map.geometry().cell_size_m();
  });
  changes.version = impl_->version;
  for (const auto& [index, tile] : impl_->told) {
    if (tile.version <= version) continue;
    changes.tiles.push_back({index.x * crsm::kTileSide, index.y * crsm::kTileSide, tile.cells});
  }
  return changes;
}

Verdict Slam::Judge() const {
  impl_->Await();
  const crsm::MapPieces pieces = impl_->FindPieces();
  const crsm::Verdict verdict = impl_->WithMap([&](const crsm::ByteMap& map) { return impl_->Judge(map, pieces); });
  return {static_cast<Trust>(verdict.trust), crsm::FormatVerdict(verdict), verdict.off_m};
}

void Slam::BeginDrive() {
  if (!impl_->matched.empty()) impl_->slam.BeginDrive();
}

void Slam::FinishMap() {
  if (impl_->finished) return;
  impl_->Await();
  impl_->slam.FinishMap();
  impl_->finished = true;
  impl_->matched.clear();
  impl_->drawn.clear();
  impl_->rays.clear();
  impl_->found.clear();
  impl_->utimes.clear();
  impl_->statistics = crsm::RunStatistics();
}

}  // namespace crsm_slam
