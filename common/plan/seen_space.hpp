#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/plan/plan.hpp"

namespace crsm {

/// Where the rays of many scans went: through how many of them each cell was seen. Map frame.
class SeenSpace {
 public:
  SeenSpace(const std::vector<PlacedScan>& scans, const PlanConstants::Space& constants);

  bool IsFree(const Eigen::Vector2d& at_m) const { return NumThrough(at_m) >= constants_.least_scans; }

  /// How many scans looked through a place, and well beyond it.
  int NumBeyond(const Eigen::Vector2d& at_m) const { return Look(num_beyond_, at_m); }

  /// The share of the way between two points that is free, also `beside_m` to its left and to its right, where less of
  /// it is.
  double FreeShare(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double beside_m) const;

  /// Calls visit with the middle of each free cell.
  template <class Visit>
  void ForEachFree(Visit&& visit) const {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const Eigen::Vector2d middle_m = origin_m_ + cell_m_ * Eigen::Vector2d(column + 0.5, row + 0.5);
        if (IsFree(middle_m)) visit(middle_m);
      }
    }
  }

  double cell_m() const { return cell_m_; }

 private:
  int NumThrough(const Eigen::Vector2d& at_m) const { return Look(num_through_, at_m); }
  int Look(const std::vector<std::uint16_t>& counts, const Eigen::Vector2d& at_m) const;
  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  PlanConstants::Space constants_;
  double cell_m_;
  Eigen::Vector2d origin_m_;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint16_t> num_through_;
  std::vector<std::uint16_t> num_beyond_;
};

}  // namespace crsm
