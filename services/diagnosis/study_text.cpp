#include "services/diagnosis/study_text.hpp"

#include <fmt/format.h>

namespace crsm {

std::string DescribeNoReturn(const RangeFinding& finding) {
  return fmt::format("{:.4g} m is no return ({:.0f} % of the beams)", *finding.no_return_m,
                     100.0 * finding.no_return_share);
}

std::string ExplainSweep(const SweepFinding& finding, const std::string& how) {
  return finding.can_be ? fmt::format("{} scans that turn fit better {}", finding.num_turning, how)
                        : fmt::format("a scan comes every {:.3g} s", finding.period_s);
}

}  // namespace crsm
