#include "common/results/read_results.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace crsm {

DenseGrid ReadMap(const std::filesystem::path& dir) {
  const std::filesystem::path yaml_path = dir / "map.yaml";
  std::ifstream yaml(yaml_path);
  if (!yaml) throw std::runtime_error(fmt::format("cannot read {}", yaml_path.string()));
  double resolution_m = 0.0;
  double origin_x_m = NAN;
  double origin_y_m = NAN;
  for (std::string line; std::getline(yaml, line);) {
    if (std::sscanf(line.c_str(), "resolution: %lf", &resolution_m) == 1) continue;
    if (std::sscanf(line.c_str(), "origin: [%lf, %lf", &origin_x_m, &origin_y_m) == 2) continue;
  }
  if (!(resolution_m > 0.0) || !(std::abs(origin_x_m) < 1e6) || !(std::abs(origin_y_m) < 1e6)) {
    throw std::runtime_error(
        fmt::format("{}: must have lines 'resolution: METRES' and 'origin: [X, Y, YAW]'", yaml_path.string()));
  }

  const std::string png_path = (dir / "map.png").string();
  std::ifstream png(png_path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(png), {}};
  const cv::Mat picture = bytes.empty() ? cv::Mat() : cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (picture.empty() || picture.type() != CV_8UC1) {
    throw std::runtime_error(fmt::format("{}: cannot be read as an 8-bit grey picture", png_path));
  }
  DenseGrid grid{picture.cols,
                 picture.rows,
                 static_cast<int>(std::lround(origin_x_m / resolution_m)),
                 static_cast<int>(std::lround(origin_y_m / resolution_m)),
                 resolution_m,
                 {}};
  for (int row = picture.rows - 1; row >= 0; --row) {
    grid.cells.insert(grid.cells.end(), picture.ptr(row), picture.ptr(row) + picture.cols);
  }
  return grid;
}

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
