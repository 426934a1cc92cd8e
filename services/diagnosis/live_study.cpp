#include "services/diagnosis/live_study.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <utility>

#include "common/diagnosis/range_study.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {
namespace {

std::string DescribeNoReturn(const RangeFinding& finding, const ScanParameters& parameters) {
  if (!finding.no_return_m || *finding.no_return_m > LargestUsableRange(parameters)) return "";
  return fmt::format("{:.4g} m is no return ({:.0f} % of the beams), and is taken for hits: --range-max-m {:.4f}",
                     *finding.no_return_m, 100.0 * finding.no_return_share, finding.RangeMax());
}

std::string DescribeSweep(const SweepFinding& finding) {
  if (finding.agrees() || (finding.can_be && finding.num_turning == 0)) return "";
  const std::string why = finding.can_be ? fmt::format("{} scans that turn fit better otherwise", finding.num_turning)
                                         : fmt::format("a scan comes every {:.3g} s", finding.period_s);
  return fmt::format("the beams are said to take {:.3g} s, but {}: --no-beam-times --sweep-s {:.4f}", finding.said_s,
                     why, finding.sweep_s);
}

}  // namespace

std::vector<std::string> DescribeStudy(const std::vector<LaserScan>& first_scans, const Parameters& parameters) {
  std::vector<std::string> lines;
  if (first_scans.empty()) return lines;
  lines.push_back(DescribeNoReturn(StudyRanges(first_scans, parameters.scan), parameters.scan));
  if (const auto finding = StudySweep(first_scans, parameters)) lines.push_back(DescribeSweep(*finding));
  std::erase(lines, "");
  return lines;
}

void LiveStudy::Add(const LaserScan& scan) {
  if (due_at_ == 0 || (!scans_.empty() && scans_.back().utime == scan.utime)) return;
  scans_.push_back(scan);
  if (scans_.size() < due_at_ || study_.valid()) return;
  const bool is_last = due_at_ == kScansOfStudy;
  due_at_ = is_last ? 0 : kScansOfStudy;
  study_ = std::async(std::launch::async, [parameters = parameters_, scans = is_last ? std::move(scans_) : scans_] {
    constexpr int kNice = 5;
    setpriority(PRIO_PROCESS, 0, kNice);  // of this thread alone
    return DescribeStudy(scans, parameters);
  });
}

std::vector<std::string> LiveStudy::TakeFindings() {
  if (!study_.valid() || study_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
  std::vector<std::string> lines = study_.get();
  if (!lines.empty()) {  // more scans would say the same
    due_at_ = 0;
    scans_ = {};
  }
  return lines;
}

}  // namespace crsm
