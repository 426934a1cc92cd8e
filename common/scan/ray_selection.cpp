#include "common/scan/ray_selection.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

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

/// Walks along the contour of the scan and picks a ray each time that another N-th of it lies behind.
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

/// Rays that are picked one after the other, with the middle of each gap between them that is too wide: lines 9 to 11,
/// repeated until no gap is left, as the middle of a very wide one leaves two that are still too wide.
class PickedRays {
 public:
  explicit PickedRays(int gap_threshold_rays) : gap_threshold_rays_(gap_threshold_rays) {}

  /// ray: no less than the last one; the same is not picked twice.
  void Pick(int ray) {
    if (!rays_.empty() && ray == rays_.back()) return;
    if (!rays_.empty()) FillGap(rays_.back(), ray);
    rays_.push_back(ray);
  }

  std::vector<int> Take() { return std::move(rays_); }

 private:
  void FillGap(int from, int to) {
    if (to - from <= gap_threshold_rays_) return;
    const int middle = (from + to) / 2;
    FillGap(from, middle);
    rays_.push_back(middle);
    FillGap(middle, to);
  }

  int gap_threshold_rays_;
  std::vector<int> rays_;
};

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
    for (std::size_t edge = 0; edge + 1 < edges_.size(); ++edge) {
      const int num = edges_[edge + 1] - edges_[edge];
      const auto first = displacements_.begin() + edges_[edge];
      sparseness_m_.push_back(num > 0 ? std::accumulate(first, first + num, 0.0) / num : 0.0);  // Eq. 5
    }

    // Line 4, as the text around it gives it: S[i] relative to the square root of the scan's longest range.
    const double root_max = std::sqrt(*std::max_element(rays.range_m.begin(), rays.range_m.end()));
    for (const float range_m : rays.range_m) damping_.push_back(1.0 / ComputeExp(range_m / root_max));
    gap_threshold_rays_ = GapThreshold();
  }

  std::vector<int> Select(double density_scale) const {
    PickedRays picked(gap_threshold_rays_);
    for (std::size_t segment = 0; segment < sparseness_m_.size(); ++segment) {
      picked.Pick(edges_[segment]);
      SelectInSegment(segment, density_scale, picked);
    }
    picked.Pick(edges_.back());
    return picked.Take();
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

  /// RAY_THRES; of a scan with so many rays that they make more than rays_max of such gaps the next larger one with
  /// which edges and gaps alone do not pick more.
  int GapThreshold() const {
    const auto num_rays = static_cast<int>(damping_.size());
    int low = parameters_.gap_threshold_rays;
    if (2 * num_rays <= low * parameters_.rays_max) return low;  // a gap that is halved leaves two of half its width
    int high = num_rays;                                         // no gap is as wide
    while (low < high) {
      const int middle = (low + high) / 2;
      PickedRays picked(middle);
      for (const int edge : edges_) picked.Pick(edge);
      if (picked.Take().size() > static_cast<std::size_t>(parameters_.rays_max)) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

  void SelectInSegment(std::size_t segment, double density_scale, PickedRays& picked) const {
    const int end = edges_[segment + 1];
    if (end - edges_[segment] < 2) return;
    const double scaled_m = density_scale * sparseness_m_[segment];
    double local_density = 0.0;                                                        // line 1
    for (int i = edges_[segment]; i < end; ++i) {                                      // line 2
      local_density += displacements_[static_cast<std::size_t>(i)];                    // line 3
      if (local_density < scaled_m * damping_[static_cast<std::size_t>(i)]) continue;  // line 4
      picked.Pick(i);                                                                  // line 5
      local_density = 0.0;                                                             // line 6
    }
  }

  std::vector<double> displacements_;  // RaysDisplacement, Eq. 2
  const SelectionParameters& parameters_;
  std::vector<int> edges_;            // FeatureEdges; a segment lies between two of them
  std::vector<double> sparseness_m_;  // of segments
  std::vector<double> damping_;       // 1 / e^(S[i] / sqrt(Max))
  int gap_threshold_rays_;
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
