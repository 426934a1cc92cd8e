#include "common/scan/ray_selection.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

constexpr double kMinDensityScale = 1e-3;
constexpr double kMaxDensityScale = 1e6;

std::vector<int> SelectAll(std::size_t num_rays) {
  std::vector<int> picked(num_rays);
  std::iota(picked.begin(), picked.end(), 0);
  return picked;
}

std::vector<int> SelectUniform(std::size_t num_rays, int step) {
  std::vector<int> picked;
  for (std::size_t i = 0; i < num_rays; i += static_cast<std::size_t>(step))
    picked.push_back(static_cast<int>(i));  // Eq. 1
  return picked;
}

/// Walks along the outline of the scan and picks a ray each time that another N-th of it lies behind.
std::vector<int> SelectByDensity(const std::vector<double>& displacements, int num_rays) {
  const double total_m = std::accumulate(displacements.begin(), displacements.end(), 0.0);  // Eq. 3
  const double step_m = total_m / num_rays;
  std::vector<int> picked{0};
  double walked_m = 0.0;
  double next_m = step_m;
  for (std::size_t i = 0; i < displacements.size(); ++i) {
    walked_m += displacements[i];
    if (walked_m < next_m || step_m <= 0.0) continue;
    picked.push_back(static_cast<int>(i) + 1);  // Eq. 4
    next_m = step_m * (std::floor(walked_m / step_m) + 1.0);
  }
  return picked;
}

/// A scan cut into segments, with what line 4 of the pseudo-code needs of each ray.
class SegmentedScan {
 public:
  SegmentedScan(const ValidRays& rays, const SelectionParameters& parameters)
      : displacements_(ComputeDisplacements(rays)), parameters_(parameters) {
    const double threshold_m = EdgeThreshold();
    edges_.push_back(0);
    for (std::size_t i = 0; i < displacements_.size(); ++i) {
      if (displacements_[i] <= threshold_m) continue;
      edges_.push_back(static_cast<int>(i));
      edges_.push_back(static_cast<int>(i) + 1);
    }
    edges_.push_back(static_cast<int>(rays.size()) - 1);

    // Line 4, as the text around it gives it: S[i] relative to the square root of the scan's longest range.
    const double root_max = std::sqrt(*std::max_element(rays.range_m.begin(), rays.range_m.end()));
    for (const float range_m : rays.range_m) damping_.push_back(1.0 / ComputeExp(range_m / root_max));
  }

  std::vector<int> Select(double density_scale) const {
    std::vector<int> picked = edges_;
    for (std::size_t edge = 0; edge + 1 < edges_.size(); ++edge) {
      SelectInSegment(edges_[edge], edges_[edge + 1], density_scale, picked);
    }
    std::sort(picked.begin(), picked.end());
    picked.erase(std::unique(picked.begin(), picked.end()), picked.end());
    FillGaps(picked);
    return picked;
  }

 private:
  /// D_THRES; larger where the scan has so many edges that nothing would be left for the surfaces between them.
  double EdgeThreshold() const {
    const auto most_edges = static_cast<std::size_t>(parameters_.rays_max / 4);  // each picks two rays: half of them
    if (!parameters_.limit_edges || displacements_.size() <= most_edges) return parameters_.edge_threshold_m;
    std::vector<double> sorted = displacements_;
    const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(most_edges);
    std::nth_element(sorted.begin(), nth, sorted.end(), std::greater<>());
    return std::max(parameters_.edge_threshold_m, *nth);
  }

  void SelectInSegment(int start, int end, double density_scale, std::vector<int>& picked) const {
    if (end - start < 2) return;
    const auto first = displacements_.begin() + start;
    const double sparseness_m = std::accumulate(first, first + (end - start), 0.0) / (end - start);        // Eq. 5
    double local_density = 0.0;                                                                            // line 1
    for (int i = start; i < end; ++i) {                                                                    // line 2
      local_density += displacements_[static_cast<std::size_t>(i)];                                        // line 3
      if (local_density < density_scale * sparseness_m * damping_[static_cast<std::size_t>(i)]) continue;  // line 4
      picked.push_back(i);                                                                                 // line 5
      local_density = 0.0;                                                                                 // line 6
    }
  }

  /// Lines 9 to 11, repeated until no gap is left: the middle of a very wide gap leaves two that are still too wide.
  void FillGaps(std::vector<int>& picked) const {
    for (std::size_t i = 0; i + 1 < picked.size();) {
      if (picked[i + 1] - picked[i] > parameters_.gap_threshold_rays) {
        picked.insert(picked.begin() + static_cast<std::ptrdiff_t>(i) + 1, (picked[i] + picked[i + 1]) / 2);
      } else {
        ++i;
      }
    }
  }

  std::vector<double> displacements_;  // RaysDisplacement, Eq. 2
  const SelectionParameters& parameters_;
  std::vector<int> edges_;       // FeatureEdges
  std::vector<double> damping_;  // 1 / e^(S[i] / sqrt(Max))
};

/// Finds the P whose count of rays falls in the wanted band: the count falls as P rises, so P is bisected.
RaySelection SelectBySegments(const SegmentedScan& scan, const SelectionParameters& parameters) {
  const auto rays_min = static_cast<std::size_t>(parameters.rays_min);
  const auto rays_max = static_cast<std::size_t>(std::max(parameters.rays_min, parameters.rays_max));
  double low = kMinDensityScale;
  double high = kMaxDensityScale;
  RaySelection selection;
  for (int halvings = 0; halvings < 24; ++halvings) {
    selection.density_scale = std::sqrt(low * high);
    selection.critical = scan.Select(selection.density_scale);
    if (selection.critical.size() > rays_max) {
      low = selection.density_scale;
    } else if (selection.critical.size() < rays_min) {
      high = selection.density_scale;
    } else {
      break;
    }
  }
  return selection;
}

}  // namespace

RaySelection SelectRays(const ValidRays& rays, const SelectionParameters& parameters, double density_scale) {
  if (rays.size() < 2) return {SelectAll(rays.size()), 0.0};
  switch (parameters.method) {
    case SelectionMethod::kAll:
      return {SelectAll(rays.size()), 0.0};
    case SelectionMethod::kUniform:
      return {SelectUniform(rays.size(), parameters.uniform_step), 0.0};
    case SelectionMethod::kDensity:
      return {SelectByDensity(ComputeDisplacements(rays), parameters.density_rays), 0.0};
    case SelectionMethod::kSegments:
      break;
  }
  const SegmentedScan scan(rays, parameters);
  if (parameters.density_scale_mode == DensityScaleMode::kPrevious) return {scan.Select(density_scale), density_scale};
  return SelectBySegments(scan, parameters);
}

double NextDensityScale(double density_scale, std::size_t num_critical, const SelectionParameters& parameters) {
  constexpr double kStep = 1.1;  // the paper gives no rate: a tenth settles within some scans and does not swing
  if (num_critical > static_cast<std::size_t>(parameters.rays_max)) density_scale *= kStep;
  if (num_critical < static_cast<std::size_t>(parameters.rays_min)) density_scale /= kStep;
  return std::clamp(density_scale, kMinDensityScale, kMaxDensityScale);
}

}  // namespace crsm
