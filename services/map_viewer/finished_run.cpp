#include "services/map_viewer/finished_run.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "common/graph/mapper.hpp"
#include "common/graph/whole_map.hpp"
#include "common/map/byte_map.hpp"
#include "services/runtime/command_line.hpp"
#include "services/sources/earlier_results.hpp"
#include "services/sources/journal.hpp"
#include "services/sources/map_parameters.hpp"

namespace crsm {
namespace {

/// Those that the map was made with; the others do not matter here.
Parameters ReadParameters(const std::filesystem::path& folder) {
  using enum ParameterGroup;
  CommandLine of_map("map_viewer", "", {kScan, kUpdate, kLoops}, {});
  AdoptMapParameters(folder, of_map);
  return of_map.parameters();
}

/// What a journal brings back.
class Run {
 public:
  Run(const std::filesystem::path& folder, const Parameters& parameters)
      : drawing_(parameters.update), mapper_(parameters.update, parameters.loops) {
    ReadJournal(folder, {false, ListMapParameters(parameters)}, OnDamage::kRefuse,
                {[this](const CriticalRays* scan, const ScanMatch& match) { Add(scan, match); },
                 [this](const GraphUpdate& update) { return mapper_.Offer(update); }});
  }

  void Show(std::int64_t epoch, Scene& scene) const {
    ShowMap(epoch, scene.map());
    ShowPath(scene);
    std::vector<SceneLoop> loops;
    const KeyframeGraph graph = mapper_.MakeBestGraph();
    for (const Loop& loop : graph.loops()) {
      loops.push_back({PoseOf(loop.older), PoseOf(loop.newer)});
    }
    scene.SetLoops(std::move(loops));
  }

 private:
  void Add(const CriticalRays* scan, const ScanMatch& match) {
    mapper_.Integrate(scan, match);
    matches_.push_back(match);
    if (!scan) return;
    last_scan_ = *scan;
    of_last_scan_ = matches_.size() - 1;
  }

  const Pose2& PoseOf(int keyframe) const { return mapper_.best_poses()[static_cast<std::size_t>(keyframe)]; }

  void ShowMap(std::int64_t epoch, SceneMap& shown) const {
    constexpr int kAll = 1 << 30;
    WholeMap whole(drawing_);
    if (mapper_.closes_loops()) whole.Draw(mapper_.graph(), mapper_.best_poses(), mapper_.local().version(), kAll);
    const MapUpdater& drawn = mapper_.closes_loops() ? whole.map() : mapper_.local();
    ByteMap map(drawn.geometry().cell_size_m());
    for (std::size_t tile = 0; tile < drawn.num_tiles(); ++tile) {
      if (const auto change = drawn.TileSince(tile, -1)) map.Apply(*change);
    }
    shown.Begin(map.geometry().cell_size_m());
    for (const auto& [index, tile] : map.tiles().entries()) shown.Set(index, tile->cells, drawn.version());
    shown.SetVersion(epoch, drawn.version());
  }

  void ShowPath(Scene& scene) const {
    PathSketch path;
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      ScanMatch match = matches_[i];
      match.T_map_laser = mapper_.BestPose(static_cast<std::int64_t>(i));
      path.Add(match);
      scene.AddSample({match.utime, static_cast<float>(match.fitness), match.state});
      if (i == of_last_scan_) scene.SetRobot({match, last_scan_});
    }
    scene.SetPath(path, true);
    const nlohmann::json info{{"live", false}, {"scans", path.num_matches()}, {"lost", path.num_lost()}};
    scene.SetInfo(info.dump());
  }

  UpdateParameters drawing_;
  Mapper mapper_;
  std::vector<ScanMatch> matches_;
  CriticalRays last_scan_;  ///< that was drawn
  std::size_t of_last_scan_ = 0;
};

}  // namespace

std::unique_ptr<Scene> ReadFinishedRun(const std::string& results) {
  const std::filesystem::path folder = FindJournal(results).parent_path();
  const auto head = ReadHead(folder);
  if (!head) throw std::runtime_error(fmt::format("{}: its journal has no scans", results));
  if (head->subject.finished_map) {
    throw std::runtime_error(fmt::format("{}: its scans were localised on the map of another run; show that", results));
  }
  auto scene = std::make_unique<Scene>(results);
  Run(folder, ReadParameters(folder)).Show(head->epoch, *scene);
  return scene;
}

}  // namespace crsm
