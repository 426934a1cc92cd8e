#include "common/results/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/results/json_text.hpp"

namespace crsm {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const SelfContradiction& found) {
  return {{"compared", found.num_looks},
          {"contradict", found.share},
          {"worst_share", found.worst_share},
          {"worst_x_m", found.worst_place.x_m},
          {"worst_y_m", found.worst_place.y_m}};
}

Json ToJson(const Point& point) { return {point.x_m, point.y_m}; }

Json ToJson(const std::vector<Doubt>& doubts) {
  Json list = Json::array();
  for (const Doubt& doubt : doubts) list.push_back({doubt.at.x_m, doubt.at.y_m, doubt.off_m});
  return list;
}

Json ToJson(const WayBack& way) {
  return {{"from_m", ToJson(way.from)}, {"to_m", ToJson(way.to)}, {"then_off_m", way.then_m}};
}

/// "lines" is for people, and all that a program has to print.
Json ToJson(const Verdict& verdict) {
  const RunStatistics::Values& values = verdict.values;
  return {{"trust", Name(verdict.trust)},
          {"lines", FormatVerdict(verdict)},
          {"agreement", verdict.agreement ? Json(*verdict.agreement) : Json(nullptr)},
          {"revisits", ToJson(verdict.contradiction)},
          {"off_m", verdict.off_m ? Json(*verdict.off_m) : Json(nullptr)},
          {"off_x_m", verdict.off_at ? Json(verdict.off_at->x_m) : Json(nullptr)},
          {"off_y_m", verdict.off_at ? Json(verdict.off_at->y_m) : Json(nullptr)},
          {"doubts", ToJson(verdict.doubts)},
          {"way_back", verdict.way_back ? ToJson(*verdict.way_back) : Json(nullptr)},
          {"longest_unmatched", values.longest_unmatched},
          {"far_steps", values.far_steps}};
}

Json ToJson(const Break& at) {
  const Pose2& pose = at.T_map_before;
  return {{"utime", at.utime},
          {"scan", at.scan},
          {"reason", Name(at.reason)},
          {"seconds", at.seconds},
          {"pose_before", {{"x_m", pose.x_m}, {"y_m", pose.y_m}, {"yaw_rad", pose.yaw_rad}}},
          {"piece_before", at.piece_before},
          {"piece", at.piece},
          {"joined", at.joined()}};
}

Json ToJson(const WheelModel::Values& wheels) {
  return {{"way_scale", wheels.scale},
          {"turn_scale", wheels.turn_scale},
          {"laser_x_m", wheels.laser_x_m},
          {"laser_y_m", wheels.laser_y_m},
          {"laser_yaw_rad", wheels.laser_yaw_rad},
          {"way_noise_m_after_1_m", wheels.way_per_m},
          {"way_noise_m_after_1_rad", wheels.way_per_rad},
          {"turn_noise_rad_after_1_m", wheels.turn_per_m},
          {"turn_noise_rad_after_1_rad", wheels.turn_per_rad},
          {"steps", wheels.steps},
          {"slips", wheels.slips}};
}

Json ToJson(const MapChange& change) {
  return {{"kind", Name(change.kind)},   {"x_m", change.middle.x_m},          {"y_m", change.middle.y_m},
          {"length_m", change.length_m}, {"width_m", change.width_m},         {"yaw_rad", change.yaw_rad},
          {"area_m2", change.area_m2()}, {"first_utime", change.first_utime}, {"places", change.num_places}};
}

void AddPieces(const MapPieces& pieces, Json& json) {
  const std::vector<int> with_map = pieces.OthersWithMap();
  Json list = Json::array();
  for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
    const auto& [keyframes, scans, way_m] = pieces.pieces[i];
    const int number = static_cast<int>(i) + 1;
    const bool has_map = std::ranges::count(with_map, number) > 0;
    list.push_back({{"piece", number},
                    {"scans", scans},
                    {"keyframes", keyframes},
                    {"way_m", way_m},
                    {"folder", number == 1 ? Json(".")
                               : has_map   ? Json(fmt::format("pieces/{}", number))
                                           : Json()}});
  }
  json["loops"] = {
      {"keyframes", pieces.num_keyframes}, {"closed", pieces.num_closed}, {"rejected", pieces.num_rejected}};
  json["pieces"] = {{"count", pieces.num_pieces}, {"scans", pieces.num_matched}, {"largest_first", std::move(list)}};
  json["num_breaks"] = pieces.num_breaks;
  json["num_bridged"] = pieces.num_bridged;
  json["breaks"] = Json::array();
  for (const Break& at : pieces.breaks) json["breaks"].push_back(ToJson(at));
}

}  // namespace

double ComputeExploredArea(const DenseGrid& grid) {
  const auto unexplored = std::count(grid.cells.begin(), grid.cells.end(), kUnexploredByte);
  const auto explored = static_cast<std::ptrdiff_t>(grid.cells.size()) - unexplored;
  return static_cast<double>(explored) * grid.cell_size_m * grid.cell_size_m;
}

std::string FormatSummary(const Summary& summary) {
  const RunStatistics::Values& values = summary.values;
  const auto OrNull = [](const std::string& text) { return text.empty() ? Json() : Json(text); };
  Json json = {{"version", summary.version},
               {"identity", OrNull(summary.identity)},
               {"made_from", OrNull(summary.origin.made_from)},
               {"recorded", OrNull(FormatUtc(values.first_utime))},
               {"mapped", OrNull(summary.origin.mapped)},
               {"ended", summary.ended},
               {"scans", values.counts.scans()},
               {"on_map", values.counts.on_map},
               {"floating", values.counts.floating},
               {"lost", values.counts.lost},
               {"without_rays", values.counts.without_rays},
               {"left_out", summary.left_out},
               {"degenerate", values.degenerate},
               {"map_version", summary.map_version},
               {"path_length_m", values.path_m},
               {"explored_area_m2", summary.explored_area_m2},
               {"mean_fitness", values.mean_fitness},
               {"wall_s", summary.wall_s ? Json(*summary.wall_s) : Json()},
               {"verdict", summary.verdict ? ToJson(*summary.verdict) : Json()},
               {"counts", Json::object()},
               {"timings", Json::object()},
               {"parameters", Json::object()}};
  if (summary.pieces) AddPieces(*summary.pieces, json);
  if (summary.changes) {
    json["changes"] = Json::array();
    for (const MapChange& change : *summary.changes) json["changes"].push_back(ToJson(change));
  }
  if (summary.wheels) json["wheels"] = ToJson(*summary.wheels);
  for (const auto& [name, count] : summary.counts) json["counts"][name] = count;
  for (const auto& [stage, timing] : summary.timings) {
    json["timings"][stage] = {
        {"p50_ms", timing.p50_ms}, {"p95_ms", timing.p95_ms}, {"p99_ms", timing.p99_ms}, {"max_ms", timing.max_ms}};
  }
  for (const auto& [process, used] : summary.parameters) {
    Json& of_process = json["parameters"][process] = Json::object();
    for (const auto& [key, value] : used) {
      std::visit([&of_process, &key = key](const auto& plain) { of_process[key] = plain; }, value);
    }
  }
  return ToText(json, 2) + "\n";
}

}  // namespace crsm
