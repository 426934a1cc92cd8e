#include "services/map_viewer/finished_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/graph/mapper.hpp"
#include "common/graph/whole_map.hpp"
#include "common/logs/read_map.hpp"
#include "common/map/byte_map.hpp"
#include "common/results/json_text.hpp"
#include "common/scan/deskew.hpp"
#include "services/base/process.hpp"
#include "services/journal/earlier_results.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/map_viewer/join_news.hpp"
#include "services/map_viewer/run_facts.hpp"
#include "services/settings/command_line.hpp"

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
  /// after_scan: called after each.
  Run(const std::string& results, const std::function<void(const Run&)>& after_scan) {
    const std::filesystem::path folder = FindJournal(results).parent_path();
    const auto head = ReadHead(folder);
    if (!head) throw std::runtime_error(fmt::format("{}: its journal has no scans", results));
    epoch_ = head->epoch;
    const Parameters parameters = ReadParameters(folder);
    drawing_ = parameters.update;
    mapper_.emplace(parameters.update, parameters.loops);
    if (head->subject.finished_map) {
      finished_map_ = ReadByteMap(results);
      mapper_->Finish();
    }
    const std::string notice =
        ReadJournal(folder, {head->subject.finished_map, ListMapParameters(parameters)}, OnDamage::kRefuse,
                    {[&](const CriticalRays* scan, const ScanMatch& match) {
                       Add(scan, match);
                       after_scan(*this);
                     },
                     [this](const GraphUpdate& update) { return mapper_->Accept(update); }});
    if (!notice.empty()) Say(fmt::format("map_viewer: {}", notice));
  }

  std::size_t num_scans() const { return matches_.size(); }
  const Mapper& mapper() const { return *mapper_; }

  /// The scan that was read last; one that was not drawn is not in the journal.
  void ShowRobot(Scene& scene) const {
    scene.SetRobot({matches_.back(), of_last_scan_ + 1 == matches_.size() ? LastScan() : CriticalRays()});
  }

  /// All that is known of the map and the path.
  void ShowMapAndPath(Scene& scene) const {
    ShowMap(scene.map());
    PathSketch path;
    for (std::size_t i = 0; i < matches_.size(); ++i) path.Add(BestMatch(i));
    scene.SetPath(path, true);
  }

  /// The scan that was read last.
  void AddTo(Timeline& timeline) const {
    const bool is_kept = last_scan_.rays.size() > 0 && of_last_scan_ + 1 == matches_.size();
    const CriticalRays scan = is_kept ? LastScan() : CriticalRays();
    timeline.Add(matches_.back(), is_kept ? &scan : nullptr);
  }

  void ShowTimeline(Timeline timeline, Scene& scene) const {
    for (std::size_t i = 0; i < matches_.size(); ++i) timeline.SetMatch(i, BestMatch(i));
    scene.SetTimeline(std::move(timeline));
  }

  /// All else that is to be seen of a run that has ended.
  void ShowEnd(const std::filesystem::path& results, Scene& scene) const {
    for (const ScanMatch& match : matches_) {
      scene.AddSample({match.utime, static_cast<float>(match.fitness), match.state});
    }
    if (last_scan_.rays.size() > 0) {
      scene.SetRobot({BestMatch(of_last_scan_), LastScan()});
    } else if (!matches_.empty()) {
      ShowRobot(scene);
    }
    scene.SetLoops(mapper_->PlaceLoops());
    const PathSketch& path = scene.path();
    const MapPieces pieces = mapper_->FindPieces();
    nlohmann::json info = ReadRunFacts(results, matches_.size());
    info.update({{"live", false},
                 {"scans", path.num_matches()},
                 {"lost", path.num_lost()},
                 {"loops_closed", pieces.num_closed},
                 {"localised", finished_map_.has_value()}});
    if (!matches_.empty()) info["truth"] = ReadTruth(results, BestMatch(0));
    for (const Break& at : pieces.breaks) {
      info["breaks"].push_back({{"scan", at.scan}, {"joined", at.joined()}});
    }
    scene.SetInfo(ToText(info));
  }

 private:
  void Add(const CriticalRays* scan, const ScanMatch& match) {
    mapper_->Restore(scan, match);
    matches_.push_back(match);
    if (!scan) return;
    last_scan_ = *scan;
    of_last_scan_ = matches_.size() - 1;
  }

  CriticalRays LastScan() const { return Deskew(last_scan_, matches_[of_last_scan_].twist); }

  ScanMatch BestMatch(std::size_t scan) const {
    return mapper_->BestMatch(static_cast<std::int64_t>(scan), matches_[scan]);
  }

  void ShowMap(SceneMap& shown) const {
    constexpr int kAll = 1 << 30;
    const MapUpdater& local = mapper_->local();
    if (finished_map_) {
      shown.Replace(*finished_map_, local.version());
      return shown.SetVersion(epoch_, local.version());
    }
    WholeMap whole(drawing_);
    if (mapper_->closes_loops()) whole.Draw(*mapper_, kAll);
    const MapUpdater& drawn = mapper_->closes_loops() ? whole.map() : local;
    ByteMap map(drawn.geometry().cell_size_m());
    for (std::size_t tile = 0; tile < drawn.num_tiles(); ++tile) {
      if (const auto change = drawn.TileSince(tile, -1)) map.Apply(*change);
    }
    shown.Replace(map, drawn.version());
    shown.SetVersion(epoch_, drawn.version());
  }

  std::int64_t epoch_ = 0;
  UpdateParameters drawing_;
  std::optional<Mapper> mapper_;
  std::optional<ByteMap> finished_map_;  ///< of another run, on which this one was localised
  std::vector<ScanMatch> matches_;
  CriticalRays last_scan_;  ///< that was drawn
  std::size_t of_last_scan_ = 0;
};

}  // namespace

std::unique_ptr<Scene> ReadFinishedRun(const std::string& results) {
  auto scene = std::make_unique<Scene>(results);
  Timeline timeline;
  const Run run(results, [&](const Run& so_far) { so_far.AddTo(timeline); });
  run.ShowMapAndPath(*scene);
  run.ShowEnd(results, *scene);
  run.ShowTimeline(std::move(timeline), *scene);
  return scene;
}

void ReplayRun(const std::string& results, Scene& scene, const std::function<void()>& changed) {
  constexpr std::size_t kTimes = 50;
  const std::size_t num_scans = Run(results, [](const Run&) {}).num_scans();
  const std::size_t step = std::max<std::size_t>(1, num_scans / kTimes);
  JoinNews join_news;
  std::vector<int> told;  // components
  const Run run(results, [&](const Run& so_far) {
    so_far.ShowRobot(scene);
    const std::vector<int>& components = so_far.mapper().best_components();
    const bool has_news = std::exchange(told, components) != components;
    const bool is_time = so_far.num_scans() % step == 0 || so_far.num_scans() == num_scans;
    if (has_news || is_time) so_far.ShowMapAndPath(scene);
    if (has_news) scene.AddNews(join_news.Look(so_far.mapper().FindPieces()));
    changed();
  });
}

}  // namespace crsm
