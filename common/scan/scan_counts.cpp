#include "common/scan/scan_counts.hpp"

#include <fmt/format.h>

namespace crsm {

std::string DescribeOthers(const ScanCounts& counts) {
  std::string text;
  if (counts.floating > 0) text += fmt::format("{} floating (on another piece), ", counts.floating);
  text += fmt::format("{} lost", counts.lost);
  if (counts.without_rays > 0) text += fmt::format(", {} without rays", counts.without_rays);
  return text;
}

}  // namespace crsm
