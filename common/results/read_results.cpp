#include "common/results/read_results.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace crsm {

double ReadMeanFitness(const std::filesystem::path& dir) {
  const std::filesystem::path path = dir / "summary.json";
  std::ifstream file(path);
  if (!file) throw std::runtime_error(fmt::format("cannot read {}", path.string()));
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object() || !json.contains("mean_fitness") || !json["mean_fitness"].is_number()) {
    throw std::runtime_error(fmt::format("{}: has no number mean_fitness", path.string()));
  }
  return json["mean_fitness"].get<double>();
}

}  // namespace crsm
