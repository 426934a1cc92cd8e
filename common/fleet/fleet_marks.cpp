#include "common/fleet/fleet_marks.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace crsm {
namespace {

PlacedMark PlaceMark(const FleetGraph& graph, int map, const AnchoredMark& anchored, int shown) {
  PlacedMark placed = anchored.mark;
  placed.floating = false;
  for (const auto& [keyframe, at] : anchored.points) {
    const FleetKeyframeId id{map, keyframe};
    placed.points.push_back(Apply(graph.pose(id), at));
    placed.floating |= graph.piece(id) != shown;
  }
  placed.covariance = TurnCovariance(placed.covariance, graph.pose({map, anchored.points.front().keyframe}).yaw_rad);
  return placed;
}

}  // namespace

bool FleetMarks::Fits(const FleetGraph& graph, int map, const std::vector<AnchoredMark>& marks) {
  const auto IsThere = [&](const AnchoredMark::Anchor& point) { return graph.map(map).Has(point.keyframe); };
  return std::ranges::all_of(marks,
                             [&](const AnchoredMark& mark) { return std::ranges::all_of(mark.points, IsThere); });
}

std::vector<PlacedMark> FleetMarks::Place(const FleetGraph& graph, int shown) const {
  std::vector<PlacedMark> all;
  for (auto map = maps_.rbegin(); map != maps_.rend(); ++map) {  // the newest first
    for (const AnchoredMark& anchored : map->second.marks) {
      PlacedMark placed = PlaceMark(graph, map->first, anchored, shown);
      placed.id = map->second.robot + "/" + placed.id;
      placed.name = placed.name.empty() ? map->second.robot : map->second.robot + ": " + placed.name;
      if (std::ranges::all_of(placed.points, IsOnMaps)) all.push_back(std::move(placed));
    }
  }
  std::ranges::stable_sort(all, {}, &PlacedMark::floating);
  std::set<std::string> ids;
  std::erase_if(all, [&](const PlacedMark& placed) { return !ids.insert(placed.id).second; });
  std::ranges::stable_sort(all, {}, &PlacedMark::id);
  if (all.size() > PlacedMark::kMostOnMap) all.resize(PlacedMark::kMostOnMap);
  return all;
}

std::size_t FleetMarks::Count() const {
  std::set<std::string> ids;
  for (const auto& [map, of_map] : maps_) {
    for (const AnchoredMark& mark : of_map.marks) ids.insert(of_map.robot + "/" + mark.mark.id);
  }
  return ids.size();
}

}  // namespace crsm
