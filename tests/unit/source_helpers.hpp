#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "packed.hpp"
#include "scratch.hpp"

namespace crsm {

/// What gzip makes of `content`.
inline std::string Compress(const std::string& content) { return Pack("gzip", content); }

inline std::vector<LaserScan> ReadAll(LaserSource& source) {
  std::vector<LaserScan> scans;
  while (auto scan = source.Next()) scans.push_back(*scan);
  return scans;
}

inline std::vector<std::int64_t> UtimesOf(const std::vector<LaserScan>& scans) {
  std::vector<std::int64_t> utimes;
  for (const LaserScan& scan : scans) utimes.push_back(scan.utime);
  return utimes;
}

inline std::int64_t CountOf(const LaserSource& source, const std::string& name) {
  const auto counts = source.Counts();
  const auto found = counts.find(name);
  return found == counts.end() ? 0 : found->second;
}

}  // namespace crsm
