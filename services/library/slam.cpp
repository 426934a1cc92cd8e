#include "crsm_slam/slam.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <stdexcept>
#include <unordered_set>
#include <utility>

#include "common/diagnosis/verdict.hpp"
#include "common/graph/g2o.hpp"
#include "common/logs/map_files.hpp"
#include "common/math/format_number.hpp"
#include "common/math/nearest_name.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/scan/deskew.hpp"
#include "common/set_parameter.hpp"
#include "common/slam.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/move_aside.hpp"
#include "services/library/plain_png.hpp"
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
  Add("smooth_climb", settings.smooth_climb);
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

crsm::Parameters CheckedParameters(const Settings& settings, const crsm::ParameterTexts& made_with = {}) {
  try {
    return MakeParameters(settings, made_with);
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

/// name: of the argument.
std::optional<crsm::Pose2> FromPublic(const std::optional<Pose>& pose, const char* name) {
  if (!pose) return std::nullopt;
  const crsm::Pose2 same{pose->x_m, pose->y_m, pose->yaw_rad};
  if (!crsm::RoundOdometry(same)) {
    throw std::invalid_argument(std::string(name) + ": its numbers must be finite and within 1e6");
  }
  return same;
}

}  // namespace

std::vector<std::string> Presets() {
  const std::set<std::string> names = NamesOf(kPresetValues);
  return {names.begin(), names.end()};
}

std::string Version() { return CRSM_SLAM_VERSION; }

struct Slam::Impl {
  explicit Impl(const crsm::Parameters& of_map) : parameters(of_map), slam(of_map) {}

  void Hear(const std::vector<crsm::GraphUpdate>& updates) {
    for (const crsm::GraphUpdate& update : updates) loop_closed |= !update.closed.empty();
    if (finished) return;
    for (const crsm::GraphUpdate& update : updates) found.push_back({std::ssize(matched), update});
  }

  /// What is asked for is by all that the scans so far can tell.
  crsm::Slam& Await() {
    Hear(slam.AwaitLoops());
    return slam;
  }

  void Add(const crsm::ScanMatch& match, bool is_drawn) {
    matched.push_back(match);
    drawn.push_back(is_drawn);
    statistics.Add(match);
  }

  /// Without loops nothing else keeps the rays.
  void KeepRays(const crsm::CriticalRays& scan, const crsm::Twist& twist) {
    if (!slam.closes_loops() && !finished) rays.emplace_back(crsm::Deskew(scan, twist).rays);
  }

  /// What `use` makes of the map.
  template <class Use>
  auto WithMap(Use&& use) {
    return Await().closes_loops() ? use(slam.DrawPiece(1)) : use(slam.map());
  }
  crsm::DenseGrid DrawGrid() {
    return WithMap([](const crsm::ByteMap& map) { return map.ToDenseGrid(); });
  }

  /// By all that is known.
  crsm::ScanMatch BestMatch(std::int64_t scan) const {
    const crsm::ScanMatch& match = matched[static_cast<std::size_t>(scan)];
    return slam.closes_loops() ? slam.mapper().BestMatch(scan, match) : match;
  }

  /// As slam_offline keeps it, from what is known of the scans.
  void WriteJournal(const std::filesystem::path& folder) const {
    crsm::Journal journal(folder, {false, crsm::ListMapParameters(parameters)});
    const crsm::KeyframeGraph& graph = slam.graph();
    const std::vector<crsm::KeyframeId> keyframes = graph.ids();
    std::size_t num_drawn = 0;
    auto update = found.begin();
    for (std::size_t scan = 0; scan < matched.size(); ++scan) {
      for (; update != found.end() && std::cmp_less_equal(update->first, scan); ++update)
        Append(update->second, journal);
      crsm::CriticalRays rays_of_scan;
      rays_of_scan.utime = matched[scan].utime;
      if (drawn[scan]) {
        const auto& packed = keyframes.empty() ? rays[num_drawn] : graph.keyframe(keyframes[num_drawn]).rays;
        rays_of_scan.rays = packed.Unpack();
        ++num_drawn;
      }
      journal.Append(drawn[scan] ? &rays_of_scan : nullptr, matched[scan]);
    }
    for (; update != found.end(); ++update) Append(update->second, journal);
    if (const auto searched = slam.mapper().searched()) {
      journal.AppendSearched(*searched, slam.mapper().last_update(), graph.keyframe(*searched).utime);
    }
    journal.Finish();
  }
  void Append(const crsm::GraphUpdate& of_loop, crsm::Journal& journal) const {
    journal.Append(of_loop, slam.graph().keyframe(of_loop.keyframe).utime);
  }

  crsm::Parameters parameters;
  crsm::Slam slam;
  std::vector<crsm::ScanMatch> matched;  ///< as they were matched
  std::vector<bool> drawn;               ///< which of them
  std::vector<crsm::PackedRays> rays;    ///< of those that were drawn, without loops
  /// What loops brought, and how many scans there were.
  std::vector<std::pair<std::int64_t, crsm::GraphUpdate>> found;
  std::unordered_set<std::int64_t> utimes;
  crsm::RunStatistics statistics;
  bool loop_closed = false;                     ///< and not told yet
  bool finished = false;                        ///< the map
  std::set<std::filesystem::path> own_folders;  ///< to which it was saved, or from which it was loaded

  /// The map as it was told, and since which version each tile is as it is.
  struct Told {
    crsm::TileBytes cells;
    std::int64_t version;
  };
  std::map<crsm::TileIndex, Told> told;
  std::int64_t version = 0;

  void Tell(const crsm::ByteMap& map) {
    std::int64_t newest = version;
    const auto TellTile = [&](crsm::TileIndex index, const crsm::TileBytes& cells) {
      const auto [at, is_new] = told.try_emplace(index, Told{cells, version + 1});
      if (!is_new && at->second.cells == cells) return;
      at->second = {cells, version + 1};
      newest = version + 1;
    };
    for (const auto& [index, tile] : map.tiles().entries()) TellTile(index, tile->cells);
    for (const auto& [index, tile] : told) {
      if (!map.tiles().Find(index)) TellTile(index, crsm::kUnexploredBytes);
    }
    version = newest;
  }
};

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
                                ": this utime was used before; each scan has its own");
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
  crsm::RunStatistics statistics = impl_->statistics;
  statistics.ForgetMatches();
  for (std::int64_t scan = 0; scan < std::ssize(impl_->matched); ++scan) statistics.Add(impl_->BestMatch(scan));
  const crsm::MapPieces pieces = impl_->slam.closes_loops() ? impl_->slam.mapper().FindPieces() : crsm::MapPieces();
  crsm::Verdict verdict =
      impl_->WithMap([&](const crsm::ByteMap& map) { return crsm::Judge(statistics, map, pieces); });
  if (const auto wheels = impl_->slam.tracking().wheels().Learned()) crsm::JudgeWheels(*wheels, verdict);
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

void Slam::Save(const std::string& folder) const {
  if (impl_->finished) throw std::logic_error("Save: the map is finished: it can only be saved before that");
  const crsm::Slam& slam = impl_->Await();
  crsm::DenseGrid grid = impl_->DrawGrid();
  if (grid.cells.empty()) grid = crsm::MakeUnexploredCell(grid.cell_size_m);
  namespace fs = std::filesystem;
  const fs::path journal = crsm::JournalFolder(folder);
  const fs::path half = fs::path(folder) / "journal.tmp";
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(folder);
  if (impl_->own_folders.count(canonical) == 0 && crsm::HoldsResults(folder)) crsm::MoveAside(folder);
  impl_->own_folders.insert(canonical);
  fs::create_directories(journal, error);
  if (error) throw std::runtime_error("Save: cannot make the folder " + folder + ": " + error.message());
  fs::remove(crsm::JournalPath(half), error);
  impl_->WriteJournal(half);

  crsm::Replacement files(folder);
  files.Write("map.png", crsm::EncodePlainMap(grid));
  files.Write("map.pgm", [&](const crsm::Sink& sink) { crsm::FormatPgm(grid, sink); });
  files.Write("map.yaml", crsm::FormatMapYaml(grid));
  std::string text;
  for (std::int64_t scan = 0; scan < std::ssize(impl_->matched); ++scan) {
    const crsm::ScanMatch match = impl_->BestMatch(scan);
    crsm::AppendPose({match.utime, match.T_map_laser}, text);
  }
  files.Write("trajectory.tum", text);
  if (slam.closes_loops()) files.Write("graph.g2o", crsm::FormatG2o(slam.MakeBestGraph().MakePoseGraph()));
  files.Rename();
  fs::rename(crsm::JournalPath(half), crsm::JournalPath(journal), error);
  if (error) throw std::runtime_error("Save: cannot write " + journal.string() + ": " + error.message());
  fs::remove(half, error);
}

Slam Slam::Load(const std::string& folder, const Settings& settings, const std::optional<Pose>& T_map_laser) {
  const std::filesystem::path journal = crsm::JournalFolder(folder);
  if (!std::filesystem::exists(crsm::JournalPath(journal))) {
    throw std::runtime_error("there is no saved map in " + folder + ": it has no journal");
  }
  const auto head = crsm::ReadHead(journal);
  if (!head) throw std::runtime_error(folder + ": there is no scan in its journal");
  crsm::Parameters parameters = CheckedParameters(settings, head->subject.parameters);
  parameters.match.start = FromPublic(T_map_laser, "T_map_laser");
  const auto differences = crsm::FindDifferences(head->subject.parameters, crsm::ListMapParameters(parameters));
  for (const auto& [key, other, text] : differences) {
    throw std::invalid_argument(key + ": the map in " + folder + " was made with " + other + ", not with " + text);
  }
  auto impl = std::make_unique<Impl>(parameters);
  const auto Restore = [&](const crsm::CriticalRays* scan, const crsm::ScanMatch& match) {
    impl->slam.Restore(scan, match);
    impl->Add(match, scan != nullptr);
    impl->utimes.insert(match.utime);
    if (!scan) return;
    impl->statistics.Add(scan->utime, scan->rays);
    impl->KeepRays(*scan, match.twist);
  };
  const auto Update = [&](const crsm::GraphUpdate& update) {
    if (!impl->slam.Restore(update)) return false;
    impl->found.push_back({std::ssize(impl->matched), update});
    return true;
  };
  const auto Searched = [&](crsm::KeyframeId keyframe) { return impl->slam.RestoreSearched(keyframe); };
  crsm::ReadJournal(journal, {false, head->subject.parameters}, crsm::OnDamage::kRefuse, {Restore, Update, Searched});
  impl->Await();
  impl->slam.Resume(parameters.match.start);
  impl->own_folders.insert(std::filesystem::weakly_canonical(folder));
  Slam loaded;
  loaded.impl_ = std::move(impl);
  return loaded;
}

}  // namespace crsm_slam
