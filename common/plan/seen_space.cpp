#include "common/plan/seen_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/map/walk_cells.hpp"
#include "common/scan/hits.hpp"

namespace crsm {

SeenSpace::SeenSpace(const std::vector<PlacedScan>& scans, const PlanConstants::Space& constants)
    : constants_(constants), cell_m_(constants.cell_m), origin_m_(Eigen::Vector2d::Zero()) {
  constexpr double kMostCells = 1e7;
  Eigen::Array2d least = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d most = -least;
  for (const PlacedScan& scan : scans) {
    const Eigen::Array2d at(scan.T_map_laser.x_m, scan.T_map_laser.y_m);
    const ValidRays rays = scan.rays.Unpack();
    const double reach = rays.size() == 0 ? 0.0 : *std::max_element(rays.range_m.begin(), rays.range_m.end());
    least = least.min(at - reach);
    most = most.max(at + reach);
  }
  if (scans.empty()) return;
  cell_m_ = std::max(cell_m_, std::sqrt((most - least).prod() / kMostCells));
  origin_m_ = least.matrix() - Eigen::Vector2d::Constant(2.0 * cell_m_);
  columns_ = static_cast<int>((most.x() - least.x()) / cell_m_) + 5;
  rows_ = static_cast<int>((most.y() - least.y()) / cell_m_) + 5;
  const std::size_t num = IndexOf(0, rows_);
  num_through_.resize(num);
  num_beyond_.resize(num);
  std::vector<int> through_by(num, -1);  // the last scan that was counted
  std::vector<int> beyond_by(num, -1);
  int number = 0;
  const auto Count = [&](std::vector<std::uint16_t>& counts, std::vector<int>& by, Cell cell) {
    const std::size_t index = IndexOf(cell.x, cell.y);
    if (by[index] == number) return;
    by[index] = number;
    if (counts[index] < std::numeric_limits<std::uint16_t>::max()) ++counts[index];
  };
  for (const PlacedScan& scan : scans) {
    const ValidRays rays = scan.rays.Unpack();
    const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
    const auto [sin, cos] = ComputeSinCos(scan.T_map_laser.yaw_rad);
    const Eigen::Matrix2d rotation{{cos, -sin}, {sin, cos}};
    const Eigen::Vector2d from = (Eigen::Vector2d(scan.T_map_laser.x_m, scan.T_map_laser.y_m) - origin_m_) / cell_m_;
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
      const double range_m = rays.range_m[static_cast<std::size_t>(i)];
      const Eigen::Vector2d ray = rotation * hits_m.col(i) / cell_m_;
      const auto Walk = [&](double before_end_m, std::vector<std::uint16_t>& counts, std::vector<int>& by) {
        if (range_m <= before_end_m) return;
        WalkCells(from, from + ray * (1.0 - before_end_m / range_m), [&](Cell a, Cell b) {
          Count(counts, by, a);
          Count(counts, by, b);
        });
      };
      Walk(constants_.before_hit_m, num_through_, through_by);
      Walk(constants_.deep_m, num_beyond_, beyond_by);
    }
    ++number;
  }
}

int SeenSpace::Look(const std::vector<std::uint16_t>& counts, const Eigen::Vector2d& at_m) const {
  const Eigen::Vector2d cell = (at_m - origin_m_) / cell_m_;
  if (!(cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < columns_ && cell.y() < rows_)) return 0;
  return counts[IndexOf(static_cast<int>(cell.x()), static_cast<int>(cell.y()))];
}

double SeenSpace::FreeShare(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double beside_m) const {
  const double length_m = (to_m - from_m).norm();
  if (length_m == 0.0) return 0.0;
  const Eigen::Vector2d along = (to_m - from_m) / length_m;
  const Eigen::Vector2d left(-along.y(), along.x());
  const int num = std::max(2, static_cast<int>(length_m / (0.5 * cell_m_)));
  double least = 1.0;
  for (const double off_m : {0.0, beside_m, -beside_m}) {
    int num_free = 0;
    for (int i = 0; i < num; ++i) {
      num_free += IsFree(from_m + along * (length_m * (i + 0.5) / num) + left * off_m);
    }
    least = std::min(least, static_cast<double>(num_free) / num);
  }
  return least;
}

}  // namespace crsm
