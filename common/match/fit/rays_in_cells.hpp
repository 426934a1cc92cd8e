#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/map/map_geometry.hpp"

namespace crsm {

/// Rays in the laser's frame, in cells, ready to be put on the map.
class RaysInCells {
 public:
  /// x, y: where they end. weight: how much each counts, >= 1; whole numbers, so that sums are exact. All of one size.
  RaysInCells(Eigen::ArrayXf x, Eigen::ArrayXf y, Eigen::ArrayXi weight);

  Eigen::Index size() const { return x_.size(); }
  const Eigen::ArrayXf& x() const { return x_; }
  const Eigen::ArrayXf& y() const { return y_; }
  const Eigen::ArrayXi& weight() const { return weight_; }
  std::int64_t total_weight() const { return total_weight_; }
  bool all_alike() const { return all_alike_; }  ///< all weights are 1

 private:
  Eigen::ArrayXf x_;
  Eigen::ArrayXf y_;
  Eigen::ArrayXi weight_;
  std::int64_t total_weight_;
  bool all_alike_;
};

/// hits_m: 2 x N, laser frame. weight: of N rays; without, all count alike.
RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry, const Eigen::ArrayXi& weight);
RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry);

}  // namespace crsm
