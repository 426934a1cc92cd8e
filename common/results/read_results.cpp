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

RunSummary ReadSummary(const std::filesystem::path& dir) {
  const std::filesystem::path path = dir / "summary.json";
  const auto json = ReadSummaryJson(path);
  try {
    RunSummary summary;
    json.at("scans").get_to(summary.scans);
    json.at("lost").get_to(summary.lost);
    json.at("mean_fitness").get_to(summary.mean_fitness);
    json.at("verdict").at("trust").get_to(summary.trust);
    if (json.contains("loops")) summary.loops = json["loops"].at("closed").get<std::int64_t>();
    if (json.contains("wall_s") && !json["wall_s"].is_null()) summary.wall_s = json["wall_s"].get<double>();
    return summary;
  } catch (const nlohmann::json::exception&) {
    throw std::runtime_error(
        fmt::format("{}: must have the numbers scans, lost and mean_fitness, and a verdict", path.string()));
  }
}

}  // namespace crsm
