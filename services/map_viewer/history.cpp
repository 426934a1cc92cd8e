#include "services/map_viewer/history.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "common/graph/mapper.hpp"
#include "services/map_viewer/finished_run.hpp"
#include "services/map_viewer/page_feed.hpp"

namespace crsm {

void History::Set(TileIndex index, const TileBytes& cells) {
  TileChanges& changes = tiles_[index];
  std::vector<std::uint8_t> runs = PackRuns(SceneMap::Tile().cells, cells);
  if (changes.empty() ? runs.empty() : changes.back().runs == runs) return;
  num_bytes_ += runs.size() + sizeof(TileChange);
  if (num_bytes_ > kMostBytes) throw std::runtime_error("its earlier maps need too much memory");
  changes.push_back({moments_.size(), std::move(runs)});
}

void History::Add(const Scene& scene, std::size_t num_closed) {
  const SceneMap& map = scene.map();
  for (auto change = map.changes().upper_bound(last_change_); change != map.changes().end(); ++change) {
    Set(change->second, map.tiles().at(change->second).cells);
  }
  last_change_ = map.last_change();
  moments_.push_back({static_cast<std::size_t>(scene.path().counts().scans()), static_cast<std::uint32_t>(num_closed),
                      scene.loops(), PackPath(scene.path().kept())});
  num_bytes_ += moments_.back().path.size();
}

void History::Finish(const SceneMap& map, std::size_t num_scans) {
  for (const auto& [index, tile] : map.tiles()) Set(index, tile.cells);
  for (const auto& [index, changes] : tiles_) {
    if (!map.tiles().contains(index)) Set(index, SceneMap::Tile().cells);
  }
  moments_.push_back({num_scans, 0, {}, PackPath({})});
}

std::size_t History::FindMoment(std::size_t scan) const {
  const auto later = std::ranges::upper_bound(moments_, scan + 1, {}, &Moment::num_scans);
  return later == moments_.begin() ? 0 : static_cast<std::size_t>(later - moments_.begin()) - 1;
}

std::size_t History::CountChanges(const TileChanges& changes, std::size_t moment) {
  return static_cast<std::size_t>(std::ranges::upper_bound(changes, moment, {}, &TileChange::moment) - changes.begin());
}

std::shared_ptr<const History> ReadHistory(const Scene& end, const std::function<bool()>& is_stopped) {
  constexpr std::size_t kTimes = 200;
  auto history = std::make_shared<History>();
  Scene scene(end.name());
  int path_told = scene.path_generation();
  const std::size_t step = std::max<std::size_t>(1, end.timeline().size() / kTimes);
  ReplayRun(end.name(), step, scene, [&](const Mapper& so_far) {
    if (is_stopped()) throw std::runtime_error("stopped");
    if (std::exchange(path_told, scene.path_generation()) == scene.path_generation()) return;
    scene.SetLoops(so_far.PlaceLoops());
    history->Add(scene, static_cast<std::size_t>(so_far.FindPieces().num_closed));
  });
  const auto num_scans = static_cast<std::size_t>(scene.path().counts().scans());
  if (num_scans != end.timeline().size()) throw std::runtime_error("the run has gone on");
  history->Finish(end.map(), num_scans);
  return history;
}

}  // namespace crsm
