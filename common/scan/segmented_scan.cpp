#include "common/scan/segmented_scan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

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

}  // namespace

SegmentedScan::SegmentedScan(const ValidRays& rays, std::vector<double> displacements, double edge_threshold_m)
    : displacements_(std::move(displacements)) {
  edges_.push_back(0);
  for (std::size_t i = 0; i < displacements_.size(); ++i) {
    if (displacements_[i] <= edge_threshold_m) continue;
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
}

std::vector<int> SegmentedScan::Select(double density_scale, int gap_threshold_rays) const {
  PickedRays picked(gap_threshold_rays);
  for (std::size_t segment = 0; segment < sparseness_m_.size(); ++segment) {
    const int begin = edges_[segment];
    const int end = edges_[segment + 1];
    picked.Pick(begin);
    if (end - begin < 2) continue;
    const double scaled_m = density_scale * sparseness_m_[segment];
    double local_density = 0.0;                                                        // line 1
    for (int i = begin; i < end; ++i) {                                                // line 2
      local_density += displacements_[static_cast<std::size_t>(i)];                    // line 3
      if (local_density < scaled_m * damping_[static_cast<std::size_t>(i)]) continue;  // line 4
      picked.Pick(i);                                                                  // line 5
      local_density = 0.0;                                                             // line 6
    }
  }
  picked.Pick(edges_.back());
  return picked.Take();
}

std::size_t SegmentedScan::CountEdgesAndGaps(int gap_threshold_rays) const {
  PickedRays picked(gap_threshold_rays);
  for (const int edge : edges_) picked.Pick(edge);
  return picked.Take().size();
}

}  // namespace crsm
