#include "services/map_viewer/finished_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/graph/mapper.hpp"
#include "common/graph/whole_map.hpp"
#include "common/logs/read_map.hpp"
#include "common/map/byte_map.hpp"
#include "common/marks/mark_book.hpp"
#include "common/results/json_text.hpp"
#include "common/scan/deskew.hpp"
#include "services/base/process.hpp"
#include "services/journal/earlier_results.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/map_parameters.hpp"
#include "services/journal/run_folder.hpp"
#include "services/map_viewer/join_news.hpp"
#include "services/map_viewer/run_facts.hpp"

namespace crsm {
namespace {

/// What a journal brings back.
class Run {
 public:
  /// after_scan: called after each.
  Run(const RunFolder& results, const std::function<void(const Run&)>& after_scan) : results_(results) {
    const std::filesystem::path folder = FindJournal(results.run).parent_path();
    const auto head = ReadHead(folder);
    if (!head) throw std::runtime_error(fmt::format("{}: its journal has no scans", results.run.string()));
    epoch_ = head->epoch;
    const Parameters parameters = ReadMapParameters(folder);
    drawing_ = parameters.update;
    mapper_.emplace(parameters.update, parameters.loops);
    if (head->subject.finished_map) {
      finished_map_ = ReadByteMap(results.run);
      mapper_->Finish();
    }
    VisitJournal visit;
    visit.match = [&](const CriticalRays* scan, const ScanMatch& match) {
      Add(scan, match);
      after_scan(*this);
    };
    visit.update = [this](const GraphUpdate& update) { return mapper_->Accept(update); };
    visit.mark = [this](const FixedMark& mark) { return marks_.Add(mark, *mapper_); };
    const std::string notice =
        ReadJournal(folder, {head->subject.finished_map, ListMapParameters(parameters)}, OnDamage::kRefuse, visit);
    if (!notice.empty()) Say(fmt::format("map_viewer: {}", notice));
  }

  std::size_t num_scans() const { return matches_.size(); }
  const Mapper& mapper() const { return *mapper_; }

  /// The scan that was read last; one that was not drawn is not in the journal.
  void ShowRobot(Scene& scene) const {
    scene.SetRobot({matches_.back(), of_last_scan_ + 1 == matches_.size() ? LastScan() : CriticalRays()});
  }

  WholeMap MakeWholeMap() const { return WholeMap(drawing_); }

  /// All that is known of the map and the path. whole: what was drawn of it so far.
  void ShowMapAndPath(WholeMap& whole, Scene& scene) const {
    ShowMap(1, whole, scene.map());
    PathSketch path;
    for (std::size_t scan = 0; scan < matches_.size(); ++scan) path.Add(BestMatch(scan, 1));
    scene.SetPath(path, true);
  }

  /// The scan that was read last.
  void AddTo(Timeline& timeline) const {
    const bool is_kept = last_scan_.rays.size() > 0 && of_last_scan_ + 1 == matches_.size();
    const CriticalRays scan = is_kept ? LastScan() : CriticalRays();
    timeline.Add(matches_.back(), is_kept ? &scan : nullptr);
  }

  /// The scans that are seen with a piece: of the first one all.
  std::vector<std::size_t> FindScans(int piece) const {
    std::vector<std::size_t> scans;
    if (piece == 1) {
      scans.resize(matches_.size());
      std::iota(scans.begin(), scans.end(), 0);
      return scans;
    }
    const int component = mapper_->FindComponent(piece);
    if (component < 0) {
      throw std::runtime_error(fmt::format("{}: its map has {} pieces, and no piece {}", results_.run.string(),
                                           mapper_->FindPieces().num_pieces, piece));
    }
    for (const auto& [first, end] : mapper_->FindScans(component)) {
      for (std::int64_t scan = first; scan < end; ++scan) scans.push_back(static_cast<std::size_t>(scan));
    }
    return scans;
  }

  /// The pieces that have a folder, and the one that was asked for.
  std::map<int, std::unique_ptr<Scene>> MakeScenes(const Timeline& timeline) const {
    const MapPieces pieces = mapper_->FindPieces();
    const nlohmann::json list = ListPieces(results_.run, pieces);
    std::map<int, std::unique_ptr<Scene>> scenes;
    const auto Make = [&](int piece) { scenes[piece] = MakeScene(piece, pieces, list, timeline); };
    Make(results_.piece);
    for (const nlohmann::json& one : list) {
      if (one.contains("folder") && one["piece"] != results_.piece) Make(one["piece"].get<int>());
    }
    return scenes;
  }

 private:
  std::unique_ptr<Scene> MakeScene(int piece, const MapPieces& pieces, const nlohmann::json& list,
                                   const Timeline& all) const {
    const std::vector<std::size_t> shown = FindScans(piece);
    auto scene = std::make_unique<Scene>(FolderOf(results_.run, piece).string());
    WholeMap whole(drawing_);
    ShowMap(piece, whole, scene->map());
    Timeline timeline = all.Pick(shown);
    PathSketch path;
    for (std::size_t number = 0; number < shown.size(); ++number) {
      const ScanMatch match = BestMatch(shown[number], piece);
      timeline.SetMatch(number, match);
      path.Add(match);
      scene->AddSample({match.utime, static_cast<float>(match.fitness), match.state});
    }
    scene->SetPath(path, true);
    if (!shown.empty()) scene->SetRobot({timeline.match(shown.size() - 1), timeline.scan(shown.size() - 1)});
    if (piece == 1) {
      scene->SetLoops(mapper_->PlaceLoops());
      scene->SetMarks(marks_.Place(*mapper_));
    }
    nlohmann::json info = piece > 1 ? DescribePiece({results_.run, piece}, pieces)
                                    : ReadRunFacts(results_.run, matches_.size(), FormatIdentity(epoch_));
    info.update({{"live", false}, {"loops_closed", pieces.num_closed}, {"localised", finished_map_.has_value()}});
    info.update(DescribeCounts(path.counts()));
    info["pieces"] = list;
    info["shown_piece"] = piece;
    if (!shown.empty()) info["truth"] = ReadTruth(results_.run, timeline.match(0));
    for (const Break& at : pieces.breaks) {
      const auto scan = std::ranges::find(shown, static_cast<std::size_t>(at.scan));
      if (scan != shown.end()) info["breaks"].push_back({{"scan", scan - shown.begin()}, {"joined", at.joined()}});
    }
    scene->SetInfo(ToText(info));
    scene->SetTimeline(std::move(timeline));
    return scene;
  }

  void Add(const CriticalRays* scan, const ScanMatch& match) {
    mapper_->Restore(scan, match);
    matches_.push_back(match);
    if (!scan) return;
    last_scan_ = *scan;
    of_last_scan_ = matches_.size() - 1;
  }

  CriticalRays LastScan() const { return Deskew(last_scan_, matches_[of_last_scan_].twist); }

  /// An axis turns with its scan.
  ScanMatch BestMatch(std::size_t scan, int piece) const {
    ScanMatch match = mapper_->BestMatch(static_cast<std::int64_t>(scan), matches_[scan]);
    if (piece > 1) match.floating = false;
    const double turn_rad = match.T_map_laser.yaw_rad - matches_[scan].T_map_laser.yaw_rad;
    const auto [x, y] = match.degenerate_axis;
    match.degenerate_axis = {x * std::cos(turn_rad) - y * std::sin(turn_rad),
                             x * std::sin(turn_rad) + y * std::cos(turn_rad)};
    return match;
  }

  void ShowMap(int piece, WholeMap& whole, SceneMap& shown) const {
    constexpr int kAll = 1 << 30;
    const MapUpdater& local = mapper_->local();
    if (finished_map_) {
      shown.Replace(*finished_map_, local.version());
      return shown.SetVersion(epoch_, local.version());
    }
    if (piece > 1) {
      whole.Draw(*mapper_, mapper_->FindComponent(piece), local.version(), kAll);
    } else if (mapper_->closes_loops()) {
      whole.Draw(*mapper_, kAll);
    }
    const MapUpdater& drawn = mapper_->closes_loops() ? whole.map() : local;
    ByteMap map(drawn.geometry().cell_size_m());
    drawn.CopyTo(map);
    shown.Replace(map, drawn.version());
    shown.SetVersion(epoch_, drawn.version());
  }

  RunFolder results_;
  std::int64_t epoch_ = 0;
  UpdateParameters drawing_;
  std::optional<Mapper> mapper_;
  MarkBook marks_;
  std::optional<ByteMap> finished_map_;  ///< of another run, on which this one was localised
  std::vector<ScanMatch> matches_;
  CriticalRays last_scan_;  ///< that was drawn
  std::size_t of_last_scan_ = 0;
};

}  // namespace

std::map<int, std::unique_ptr<Scene>> ReadFinishedRun(const std::string& results) {
  Timeline timeline;
  return Run(FindRun(results), [&](const Run& so_far) { so_far.AddTo(timeline); }).MakeScenes(timeline);
}

std::size_t CountScans(const std::string& results) {
  return Run(FindRun(results), [](const Run&) {}).num_scans();
}

void ReplayRun(const std::string& results, std::size_t step, Scene& scene,
               const std::function<void(const Mapper& so_far)>& changed) {
  const RunFolder folder = FindRun(results);
  if (folder.piece > 1) {
    throw std::runtime_error(fmt::format("{}: is a piece of a map, and has no journal: take the whole run, {}", results,
                                         folder.run.string()));
  }
  JoinNews join_news;
  std::vector<int> told;  // components
  std::optional<WholeMap> whole;
  std::int64_t layout = 0;  // that was drawn
  const auto Show = [&](const Run& so_far) {
    const std::int64_t newest = so_far.mapper().num_layouts();
    if (!whole || std::exchange(layout, newest) != newest) whole = so_far.MakeWholeMap();
    so_far.ShowMapAndPath(*whole, scene);
  };
  const Run run(folder, [&](const Run& so_far) {
    so_far.ShowRobot(scene);
    const std::vector<int>& components = so_far.mapper().best_components();
    const bool has_news = std::exchange(told, components) != components;
    if (has_news || so_far.num_scans() % step == 0) Show(so_far);
    if (has_news) scene.AddNews(Describe(join_news.Look(so_far.mapper().FindPieces())));
    changed(so_far.mapper());
  });
  Show(run);
  changed(run.mapper());
}

}  // namespace crsm
