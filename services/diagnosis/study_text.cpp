#include "services/diagnosis/study_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace crsm {

std::string DescribeNoReturn(const RangeFinding& finding) {
  return fmt::format("{:.4g} m is no return ({:.0f} % of the beams)", *finding.no_return_m,
                     100.0 * finding.no_return_share);
}

namespace {

std::string DescribeTurn(double sweep_s, const LaserScan& scan) {
  const bool is_clockwise = (sweep_s < 0.0) != (scan.angle_step_rad < 0.0f);
  return fmt::format("{:.3g} s, {}", std::abs(sweep_s), is_clockwise ? "clockwise" : "counter-clockwise");
}

}  // namespace

std::string DescribeSweep(const SweepFinding& finding, const LaserScan& scan, const std::string& who) {
  std::string text = finding.sweep_s == 0.0 ? "the scans show no sweep"
                                            : fmt::format("each scan takes {}", DescribeTurn(finding.sweep_s, scan));
  if (finding.said_s == 0.0) return text;
  return text + (finding.agrees() ? fmt::format(", as {}", who)
                                  : fmt::format(", not as {} ({})", who, DescribeTurn(finding.said_s, scan)));
}

}  // namespace crsm
