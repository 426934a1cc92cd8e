#include "common/results/read_results.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/logs/regular_file.hpp"

namespace crsm {

namespace {

/// summary.json, or an object without anything if it is none.
nlohmann::json ReadSummaryJson(const std::filesystem::path& path) {
  auto json = nlohmann::json::parse(ReadWholeFile(path), nullptr, false);
  return json.is_object() ? json : nlohmann::json::object();
}

}  // namespace

double ReadMeanFitness(const std::filesystem::path& dir) {
  const std::filesystem::path path = dir / "summary.json";
  const auto json = ReadSummaryJson(path);
  if (!json.contains("mean_fitness") || !json["mean_fitness"].is_number()) {
    throw std::runtime_error(fmt::format("{}: has no number mean_fitness", path.string()));
  }
  return json["mean_fitness"].get<double>();
}

std::string ReadMadeFrom(const std::filesystem::path& dir) {
  try {
    const auto json = ReadSummaryJson(dir / "summary.json");
    const auto found = json.find("made_from");
    return found != json.end() && found->is_string() ? found->get<std::string>() : "";
  } catch (const std::runtime_error&) {  // there is none
    return "";
  }
}

RunSummary ReadSummary(const std::filesystem::path& dir) {
  const std::filesystem::path path = dir / "summary.json";
  const auto json = ReadSummaryJson(path);
  try {
    RunSummary summary;
    json.at("scans").get_to(summary.scans);
    json.at("floating").get_to(summary.floating);
    json.at("lost").get_to(summary.lost);
    json.at("without_rays").get_to(summary.without_rays);
    json.at("left_out").get_to(summary.left_out);
    json.at("mean_fitness").get_to(summary.mean_fitness);
    json.at("verdict").at("trust").get_to(summary.trust);
    if (json.contains("loops")) summary.loops = json["loops"].at("closed").get<std::int64_t>();
    if (json.contains("wall_s") && !json["wall_s"].is_null()) summary.wall_s = json["wall_s"].get<double>();
    const auto TextOf = [&json](const char* key) {
      return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
    };
    summary.made_from = TextOf("made_from");
    summary.recorded = TextOf("recorded");
    summary.mapped = TextOf("mapped");
    const auto& verdict = json["verdict"];
    if (verdict.contains("off_m") && verdict["off_m"].is_number()) summary.off_m = verdict["off_m"].get<double>();
    if (json.contains("identity") && !json["identity"].is_null()) json["identity"].get_to(summary.identity);
    return summary;
  } catch (const nlohmann::json::exception&) {
    throw std::runtime_error(
        fmt::format("{}: must have the numbers scans, floating, lost, without_rays, left_out and mean_fitness, and a "
                    "verdict: is it of an older version?",
                    path.string()));
  }
}

}  // namespace crsm
