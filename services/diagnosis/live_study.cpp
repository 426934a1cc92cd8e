#include "services/diagnosis/live_study.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <utility>

#include "common/diagnosis/range_study.hpp"
#include "services/diagnosis/study_text.hpp"

namespace crsm {
namespace {

std::string ComplainOfRanges(const RangeFinding& finding) {
  if (!finding.no_return_is_hit) return "";
  return fmt::format("{}, and is taken for hits: --range-max-m {:.4f}", DescribeNoReturn(finding), finding.RangeMax());
}

std::string ComplainOfSweep(const SweepFinding& finding, const LaserScan& scan) {
  if (finding.agrees()) return "";
  return fmt::format("{}: --no-beam-times --sweep-s {:.4f}", DescribeSweep(finding, scan, "is said"), finding.sweep_s);
}

}  // namespace

std::vector<std::string> DescribeStudy(const std::vector<LaserScan>& first_scans, const Parameters& parameters) {
  std::vector<std::string> lines;
  if (first_scans.empty()) return lines;
  lines.push_back(ComplainOfRanges(StudyRanges(first_scans, parameters.scan)));
  if (const auto finding = StudySweep(first_scans, parameters)) {
    lines.push_back(ComplainOfSweep(*finding, first_scans.front()));
  }
  std::erase(lines, "");
  return lines;
}

void LiveStudy::Add(const LaserScan& scan) {
  if (due_at_ == 0 || (!scans_.empty() && scans_.back().utime == scan.utime)) return;
  scans_.push_back(scan);
  if (scans_.size() < due_at_ || study_.valid()) return;
  const std::size_t last_at = DiagnosisConstants::SweepStudy{}.num_scans;
  const bool is_last = due_at_ == last_at;
  due_at_ = is_last ? 0 : last_at;
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
