#include "common/match/fit/rays_in_cells.hpp"

#include <utility>

namespace crsm {

RaysInCells::RaysInCells(Eigen::ArrayXf x, Eigen::ArrayXf y, Eigen::ArrayXi weight)
    : x_(std::move(x)),
      y_(std::move(y)),
      weight_(std::move(weight)),
      total_weight_(weight_.cast<std::int64_t>().sum()),
      all_alike_((weight_ == 1).all()) {}

RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry, const Eigen::ArrayXi& weight) {
  if (hits_m.cols() == 0) return {{}, {}, weight};  // no second row to point at
  const Eigen::Matrix2Xf hits = (hits_m / geometry.cell_size_m()).cast<float>();
  return {hits.row(0).transpose(), hits.row(1).transpose(), weight};
}

RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry) {
  return ToCells(hits_m, geometry, Eigen::ArrayXi::Ones(hits_m.cols()));
}

}  // namespace crsm
