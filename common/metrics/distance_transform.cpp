#include "common/metrics/distance_transform.hpp"

#include <cmath>
#include <limits>

namespace crsm {
namespace {

constexpr float kFar = std::numeric_limits<float>::max();

/// One row of the transform: distances[i] becomes the lower envelope at i of the parabolas (i - k)^2 + distances[k].
class LowerEnvelope {
 public:
  void Apply(std::vector<double>& distances) {
    const auto n = static_cast<int>(distances.size());
    at_.clear();
    from_.clear();
    for (int k = 0; k < n; ++k) {
      if (distances[Index(k)] == kFar) continue;
      double start = -HUGE_VAL;
      while (!at_.empty()) {
        start = Meet(distances, at_.back(), k);
        if (start > from_.back()) break;
        at_.pop_back();
        from_.pop_back();
        start = -HUGE_VAL;
      }
      at_.push_back(k);
      from_.push_back(start);
    }
    if (at_.empty()) return;
    const std::vector<double> before = distances;
    std::size_t lowest = 0;
    for (int i = 0; i < n; ++i) {
      while (lowest + 1 < at_.size() && from_[lowest + 1] < i) ++lowest;
      const double step = i - at_[lowest];
      distances[Index(i)] = step * step + before[Index(at_[lowest])];
    }
  }

 private:
  static std::size_t Index(int i) { return static_cast<std::size_t>(i); }

  static double Meet(const std::vector<double>& d, int k, int l) {
    return (d[Index(l)] - d[Index(k)] + static_cast<double>(l) * l - static_cast<double>(k) * k) / (2.0 * (l - k));
  }

  std::vector<int> at_;       // where the lowest parabolas stand
  std::vector<double> from_;  // and from where on each is the lowest
};

}  // namespace

std::vector<float> ComputeSquaredDistances(const DenseGrid& grid) {
  std::vector<float> distances(grid.cells.size());
  for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = IsOccupied(grid.cells[i]) ? 0.0f : kFar;
  LowerEnvelope envelope;
  std::vector<double> line;
  const auto Sweep = [&](int num_lines, int length, auto index) {
    for (int i = 0; i < num_lines; ++i) {
      line.clear();
      for (int k = 0; k < length; ++k) line.push_back(distances[index(i, k)]);
      envelope.Apply(line);
      for (int k = 0; k < length; ++k) distances[index(i, k)] = static_cast<float>(line[static_cast<std::size_t>(k)]);
    }
  };
  Sweep(grid.width_cells, grid.height_cells, [&](int column, int row) { return grid.IndexOf(column, row); });
  Sweep(grid.height_cells, grid.width_cells, [&](int row, int column) { return grid.IndexOf(column, row); });
  return distances;
}

}  // namespace crsm
