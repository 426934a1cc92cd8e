#include "common/match/judge/agreement.hpp"

#include <algorithm>
#include <cmath>

#include "common/match/fit/rays_in_cells.hpp"
#include "common/math/columns.hpp"

namespace crsm {

double ComputeAgreement(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                        const MatchConstants::Agreement& constants) {
  const MapGeometry& geometry = map.geometry();
  const double cell_m = geometry.cell_size_m();
  const double tolerance_m = std::max(constants.tolerance_m, constants.tolerance_cells * cell_m);
  if (hits_m.cols() == 0) return 0.0;
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  int num_agreeing = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const double range_m = std::sqrt(hits_m.col(i).squaredNorm());
    const double dx = (cos * hits_m(0, i) - sin * hits_m(1, i)) / range_m;
    const double dy = (sin * hits_m(0, i) + cos * hits_m(1, i)) / range_m;
    const double step_m = std::max(cell_m, range_m / constants.most_steps);
    const double first_m = std::min(constants.near_m, range_m - tolerance_m);
    for (double way_m = first_m; way_m <= range_m + tolerance_m; way_m += step_m) {
      if (!IsOccupied(map.At(geometry.CellAt(T_map_laser.x_m + way_m * dx, T_map_laser.y_m + way_m * dy)))) continue;
      if (way_m >= range_m - tolerance_m) ++num_agreeing;
      break;
    }
  }
  return static_cast<double>(num_agreeing) / static_cast<double>(hits_m.cols());
}

double ScorePlace(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                  const MatchConstants& constants) {
  const Eigen::Matrix2Xd thinned_m = ThinColumns(hits_m, constants.map_search.most_points);
  return map.Fitness(ToCells(thinned_m, map.geometry()), T_map_laser) *
         ComputeAgreement(map.cells(), thinned_m, T_map_laser, constants.agreement);
}

}  // namespace crsm
