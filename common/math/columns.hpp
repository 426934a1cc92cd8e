#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace crsm {

/// A matrix of these columns: JoinColumns<Eigen::Matrix2Xd>(points).
template <class Matrix, class Column>
Matrix JoinColumns(const std::vector<Column>& all) {
  Matrix columns(Matrix::RowsAtCompileTime, static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = all[i];
  return columns;
}

/// Those columns, in that order.
inline Eigen::Matrix2Xd SelectColumns(const Eigen::Matrix2Xd& all, std::span<const int> picked) {
  Eigen::Matrix2Xd columns(2, static_cast<Eigen::Index>(picked.size()));
  for (std::size_t i = 0; i < picked.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = all.col(picked[i]);
  return columns;
}

/// Some columns of many, evenly spread; no more than `most`, which is at least 1.
inline Eigen::Matrix2Xd ThinColumns(const Eigen::Matrix2Xd& all, Eigen::Index most) {
  const Eigen::Index step = (all.cols() + most - 1) / most;
  if (step <= 1) return all;
  Eigen::Matrix2Xd some(2, (all.cols() + step - 1) / step);
  for (Eigen::Index i = 0; i < some.cols(); ++i) some.col(i) = all.col(i * step);
  return some;
}

}  // namespace crsm
