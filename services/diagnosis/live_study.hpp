#pragma once

#include <cstddef>
#include <future>
#include <string>
#include <vector>

#include "common/diagnosis/sweep_study.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// What the first scans of a laser show that its messages, flags or preset tell otherwise: a line for each, with the
/// flags that are right. Of few scans that turn, and of a sweep that may be as it is said to be, nothing.
std::vector<std::string> DescribeStudy(const std::vector<LaserScan>& first_scans, const Parameters& parameters);

/// The same of a live laser, while its scans pass by: at 300 of them, and at as many as StudySweep looks at. Maps them
/// in a thread of its own, which gives way to everything else.
class LiveStudy {
 public:
  explicit LiveStudy(const Parameters& parameters) : parameters_(parameters) {}

  /// The next scan, also one that is sent again.
  void Add(const LaserScan& scan);

  /// What has been found since, often nothing; each line once.
  std::vector<std::string> TakeFindings();

 private:
  Parameters parameters_;
  std::vector<LaserScan> scans_;
  std::size_t due_at_ = 300;  ///< scans; 0 once everything is said
  std::future<std::vector<std::string>> study_;
};

}  // namespace crsm
