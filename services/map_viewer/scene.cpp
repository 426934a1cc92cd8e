#include "services/map_viewer/scene.hpp"

#include <fmt/ranges.h>

#include <utility>

namespace crsm {

void SceneMap::Begin(double cell_size_m) {
  ++generation_;
  epoch_ = 0;
  version_ = 0;
  cell_size_m_ = cell_size_m;
  tiles_.clear();
  changes_.clear();
  ++last_change_;
}

void SceneMap::Set(TileIndex index, const TileBytes& cells, std::int64_t version) {
  const auto known = tiles_.find(index);
  std::vector<std::uint8_t> runs = PackRuns(known == tiles_.end() ? Tile().cells : known->second.cells, cells);
  if (runs.empty()) return;
  Tile& tile = tiles_[index];
  changes_.erase(tile.changed);
  tile.cells = cells;
  tile.last_runs = std::move(runs);
  tile.changed_before = std::exchange(tile.changed, ++last_change_);
  tile.changed_in = version;
  changes_.emplace(tile.changed, index);
}

void SceneMap::Replace(const ByteMap& map, std::int64_t version) {
  if (cell_size_m_ != map.geometry().cell_size_m()) Begin(map.geometry().cell_size_m());
  std::vector<TileIndex> gone;
  for (const auto& [index, tile] : tiles_) {
    if (!map.tiles().Find(index)) gone.push_back(index);
  }
  for (const TileIndex index : gone) Set(index, Tile().cells, version);
  for (const auto& [index, tile] : map.tiles().entries()) Set(index, tile->cells, version);
}

void SceneMap::SetVersion(std::int64_t epoch, std::int64_t version) {
  if (epoch == epoch_ && version == version_) return;
  epoch_ = epoch;
  version_ = version;
  ++last_change_;
}

ChangeNumber SceneMap::FindVersion(std::int64_t epoch, std::int64_t version) const {
  if (epoch == 0 || epoch != epoch_ || version > version_) return 0;
  ChangeNumber last = last_change_;
  for (auto change = changes_.rbegin(); change != changes_.rend(); ++change) {
    if (tiles_.at(change->second).changed_in <= version) break;
    last = change->first - 1;
  }
  return last;
}

void Scene::SetPath(const PathSketch& path, bool anew) {
  if (anew || path.num_thinnings() != path_.num_thinnings()) ++path_generation_;
  path_ = path;
}

void Scene::SetRobot(SceneRobot robot) {
  robot_ = std::move(robot);
  ++robot_change_;
}

void Scene::AddSample(const SceneSample& sample) {
  samples_.push_back(sample);
  ++num_samples_;
  if (samples_.size() > kMostSamples) samples_.pop_front();
}

void Scene::SetHistory(std::shared_ptr<const History> history) {
  history_ = std::move(history);
  ++info_change_;
}

void Scene::SetLoops(std::vector<PlacedLoop> loops) {
  std::erase_if(loops, [](const PlacedLoop& loop) { return loop.rejected; });
  if (loops == loops_) return;
  loops_ = std::move(loops);
  ++info_change_;
}

void Scene::SetMarks(std::vector<PlacedMark> marks) {
  if (marks == marks_) return;
  marks_ = std::move(marks);
  ++info_change_;
}

void Scene::AddNews(const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  newest_news_ = fmt::format("{}", fmt::join(lines, "; "));
  ++num_news_;
  ++info_change_;
}

void Scene::SetEdits(std::string json, bool is_written) {
  edits_ = std::move(json);
  writes_edits_ = is_written;
  ++info_change_;
}

void Scene::SetInfo(std::string json) {
  info_ = std::move(json);
  ++info_change_;
}

}  // namespace crsm
