#include "services/journal/earlier_scans.hpp"

#include <algorithm>
#include <cmath>

#include "common/scan/clock_restart.hpp"
#include "common/scan/deskew.hpp"
#include "services/journal/journal_reader.hpp"

namespace crsm {

void EarlierScans::Add(const CriticalRays* scan, const ScanMatch& match) {
  if (!last_utime_ || HasClockRestarted(*last_utime_, match.utime)) drives_.push_back(utimes_.size());
  last_utime_ = match.utime;
  newest_utime_ = std::max(newest_utime_, match.utime);
  utimes_.Add(match.utime);
  if (!scan || scan->rays.size() == 0) return;
  const ValidRays rays = Deskew(scan->rays, match.twist);
  Drawn& drawn = drawn_[match.utime];
  drawn.twist = match.twist;
  const std::size_t step = (rays.size() - 1) / constants_.num_compared + 1;
  for (std::size_t i = 0; i < rays.size(); i += step) {
    drawn.rays.angle_rad.push_back(rays.angle_rad[i]);
    drawn.rays.range_m.push_back(rays.range_m[i]);
  }
}

/// A scan of a later drive has the next microsecond that was free then: all before it are taken.
bool EarlierScans::Has(std::int64_t utime, const ValidRays& rays) {
  for (auto scan = utimes_.Find(utime); scan; scan = utimes_.Find(++utime)) {
    const std::size_t drive = DriveOf(*scan);
    if (contradicted_.contains(drive)) continue;
    const auto drawn = drawn_.find(utime);
    if (drawn == drawn_.end()) return true;
    if (IsSame(rays, drawn->second)) {
      ++num_same_;
      return true;
    }
    contradicted_.insert(drive);
  }
  return false;
}

std::size_t EarlierScans::DriveOf(std::int64_t scan) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(drives_, scan) - drives_.begin()) - 1;
}

bool EarlierScans::IsSame(const ValidRays& rays, const Drawn& drawn) const {
  const ValidRays deskewed = Deskew(rays, drawn.twist);
  std::size_t num_same = 0;
  for (std::size_t i = 0; i < drawn.rays.size(); ++i) {
    const float lowest_rad = drawn.rays.angle_rad[i] - constants_.angle_rad;
    auto at =
        static_cast<std::size_t>(std::ranges::lower_bound(deskewed.angle_rad, lowest_rad) - deskewed.angle_rad.begin());
    for (; at < deskewed.size() && deskewed.angle_rad[at] <= drawn.rays.angle_rad[i] + constants_.angle_rad; ++at) {
      if (std::abs(deskewed.range_m[at] - drawn.rays.range_m[i]) > constants_.range_m) continue;
      ++num_same;
      break;
    }
  }
  return static_cast<double>(num_same) >= constants_.least_share * static_cast<double>(drawn.rays.size());
}

EarlierScans ReadEarlierScans(const std::filesystem::path& journal) {
  EarlierScans scans;
  JournalReader reader(journal.string());
  while (const auto stretch = reader.Next()) {
    if (stretch->match) scans.Add(stretch->scan ? &*stretch->scan : nullptr, *stretch->match);
  }
  return scans;
}

}  // namespace crsm
