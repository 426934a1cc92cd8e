#include "services/map_viewer/run_facts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/logs/regular_file.hpp"
#include "common/metrics/trajectory.hpp"

namespace crsm {
namespace {

using nlohmann::json;

json WithoutVerdict(const std::string& why) {
  return {{"verdict", {{"trust", "none"}, {"lines", {"there is no verdict: " + why}}}}};
}

json ReadSummary(const std::filesystem::path& results) {
  try {
    return json::parse(ReadWholeFile(results / "summary.json"), nullptr, false);
  } catch (const std::runtime_error&) {
    return json();
  }
}

}  // namespace

json DescribeCounts(const ScanCounts& counts) {
  return {{"scans", counts.scans()},
          {"on_map", counts.on_map},
          {"floating", counts.floating},
          {"lost", counts.lost},
          {"without_rays", counts.without_rays}};
}

json ReadTruth(const std::filesystem::path& results, const ScanMatch& first) {
  constexpr std::size_t kMost = 5000;  // places: more would not be seen
  json places = json::array();
  Trajectory truth;
  std::error_code error;
  if (!std::filesystem::is_regular_file(results / "truth.tum", error)) return places;
  try {
    truth = ReadTrajectory((results / "truth.tum").string());
  } catch (const std::runtime_error&) {
    return places;
  }
  const auto same = std::ranges::find(truth, first.utime, &StampedPose::utime);
  if (same == truth.end()) return places;
  const Pose2 T_map_truth = first.T_map_laser * Inverse(same->T_map_laser);
  const std::size_t step = truth.size() / kMost + 1;
  for (std::size_t i = 0; i < truth.size(); i += step) {
    const Pose2 there = T_map_truth * truth[i].T_map_laser;
    places.push_back({there.x_m, there.y_m});
  }
  return places;
}

json DescribeChanges(const std::vector<MapChange>& changes) {
  json list = json::array();
  for (const MapChange& change : changes) {
    list.push_back({{"kind", Name(change.kind)},
                    {"x_m", change.middle.x_m},
                    {"y_m", change.middle.y_m},
                    {"length_m", change.length_m},
                    {"width_m", change.width_m},
                    {"yaw_rad", change.yaw_rad},
                    {"places", change.num_places}});
  }
  return list;
}

std::filesystem::path FolderOf(const std::filesystem::path& run, int piece) {
  return piece == 1 ? run : run / "pieces" / std::to_string(piece);
}

json ListPieces(const std::filesystem::path& run, const MapPieces& pieces) {
  json list = json::array();
  for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
    const std::filesystem::path folder = FolderOf(run, static_cast<int>(i) + 1);
    list.push_back({{"piece", i + 1}, {"scans", pieces.pieces[i].scans}, {"way_m", pieces.pieces[i].way_m}});
    std::error_code error;
    if (std::filesystem::is_regular_file(folder / "map.png", error)) list.back()["folder"] = folder.string();
  }
  return list;
}

json DescribePiece(const RunFolder& results, const MapPieces& pieces) {
  const auto index = static_cast<std::size_t>(results.piece) - 1;
  json facts = WithoutVerdict(
      fmt::format("this is piece {} of {}, and the verdict is on piece 1", results.piece, results.run.string()));
  if (index < pieces.pieces.size()) facts["way_m"] = pieces.pieces[index].way_m;
  return facts;
}

namespace {

/// What has changed since the map was made: all of it, or nothing where one of them is no change.
json ReadChanges(const json& summary) {
  const json changes = summary.value("changes", json::array());
  if (!changes.is_array()) return json::array();
  for (const json& change : changes) {
    if (!change.is_object() || !change.value("kind", json()).is_string()) return json::array();
    for (const char* key : {"x_m", "y_m", "length_m", "width_m", "yaw_rad", "places"}) {
      if (!change.value(key, json()).is_number()) return json::array();
    }
  }
  return changes;
}

bool AreNumbers(const json& list, std::size_t num) {
  return list.is_array() && list.size() == num &&
         std::ranges::all_of(list, [](const json& one) { return one.is_number(); });
}

}  // namespace

json ReadRunFacts(const std::filesystem::path& results, std::size_t num_scans, const std::string& identity) {
  const json summary = ReadSummary(results);
  if (!summary.is_object()) return WithoutVerdict("the folder has no summary.json that can be read");
  if (summary.value("ended", json()) != json(true)) return WithoutVerdict("the run has not ended");
  const json map = summary.value("identity", json());
  if (map.is_string() && map != json(identity))
    return WithoutVerdict("summary.json is of another map than the journal");
  const json scans = summary.value("scans", json());
  if (!scans.is_number_unsigned() || scans.get<std::size_t>() != num_scans) {
    return WithoutVerdict("summary.json is of another number of scans");
  }
  const json found = summary.value("verdict", json::object());
  const json trust = found.is_object() ? found.value("trust", json()) : json();
  if (!trust.is_string()) return WithoutVerdict("summary.json has none");
  json facts{{"verdict", {{"trust", trust}, {"lines", json::array()}}}};
  for (const json& line : found.value("lines", json::array())) {
    if (line.is_string()) facts["verdict"]["lines"].push_back(line);
  }
  facts["changes"] = ReadChanges(summary);
  for (const char* name : {"made_from", "recorded", "version"}) {
    if (const json value = summary.value(name, json()); value.is_string()) facts[name] = value;
  }
  const json x_m = found.value("off_x_m", json());
  const json y_m = found.value("off_y_m", json());
  if (x_m.is_number() && y_m.is_number()) facts["verdict"]["off_at_m"] = {x_m, y_m};
  if (const json off_m = found.value("off_m", json()); off_m.is_number()) facts["verdict"]["off_m"] = off_m;
  const json doubts = found.value("doubts", json());
  if (doubts.is_array() && std::ranges::all_of(doubts, [](const json& one) { return AreNumbers(one, 3); }))
    facts["verdict"]["doubts"] = doubts;
  const json way_back = found.value("way_back", json());
  if (way_back.is_object() && AreNumbers(way_back.value("from_m", json()), 2) &&
      AreNumbers(way_back.value("to_m", json()), 2)) {
    facts["verdict"]["way_back"] = way_back;
  }
  for (const auto& [key, name] : {std::pair("path_length_m", "way_m"), std::pair("explored_area_m2", "area_m2"),
                                  std::pair("left_out", "left_out")}) {
    const json value = summary.value(key, json());
    if (value.is_number()) facts[name] = value;
  }
  return facts;
}

}  // namespace crsm
