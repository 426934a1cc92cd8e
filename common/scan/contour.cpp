#include "common/scan/contour.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace crsm {
namespace {

/// How what lies between a hit and the next counts.
struct CountedGap {
  double weight = 0.0;
  int num_pieces = 1;
};

std::vector<CountedGap> CountGaps(const ValidRays& rays, const Gaps& gaps, double cap_m,
                                  const ContourConstants& constants) {
  const std::vector<double> displacements_m = ComputeDisplacements(rays);
  const std::vector<bool> joined = gaps.FindSurfaces(0.0, std::numeric_limits<double>::infinity());
  std::vector<CountedGap> counted;
  for (std::size_t i = 0; i < displacements_m.size(); ++i) {
    const double caps = displacements_m[i] / cap_m;
    counted.push_back({constants.most_of_gap * std::min(caps, 1.0),
                       joined[i] ? static_cast<int>(std::min<double>(caps, constants.most_pieces - 1)) + 1 : 1});
  }
  return counted;
}

}  // namespace

Contour TraceContour(const ValidRays& rays, const Eigen::Matrix2Xd& hits_m, const Gaps& gaps, double cap_m,
                     const ContourConstants& constants) {
  if (cap_m <= 0.0 || rays.size() == 0) return {hits_m, Eigen::ArrayXi::Ones(hits_m.cols())};
  const std::vector<CountedGap> counted = CountGaps(rays, gaps, cap_m, constants);
  Eigen::Index num_points = hits_m.cols();
  for (const CountedGap& gap : counted) num_points += gap.num_pieces - 1;

  Contour contour{Eigen::Matrix2Xd(2, num_points), Eigen::ArrayXi(num_points)};
  Eigen::Index num = 0;
  const auto Add = [&](const Eigen::Vector2d& point_m, double weight) {
    contour.points_m.col(num) = point_m;
    contour.weights[num++] = static_cast<int>(std::lround(weight));
  };
  double before = 0.0;  // half a piece of the gap before a hit
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const bool is_last = i + 1 == hits_m.cols();
    const CountedGap gap = is_last ? CountedGap{} : counted[static_cast<std::size_t>(i)];
    const double piece = gap.weight / gap.num_pieces;
    const double half_piece = 0.5 * piece;
    Add(hits_m.col(i), 1.0 + std::exchange(before, half_piece) + half_piece);
    for (int k = 1; k < gap.num_pieces; ++k) {
      const double share = static_cast<double>(k) / gap.num_pieces;
      Add(hits_m.col(i) + share * (hits_m.col(i + 1) - hits_m.col(i)), piece);
    }
  }
  return contour;
}

}  // namespace crsm
