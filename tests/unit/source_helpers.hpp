#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "common/worlds/simulator.hpp"
#include "packed.hpp"
#include "scratch.hpp"

namespace crsm {

/// What gzip makes of `content`.
inline std::string Compress(const std::string& content) { return Pack("gzip", content); }

/// The scans of a source, or the first of them.
inline std::vector<LaserScan> ReadAll(LaserSource& source, std::size_t most = SIZE_MAX) {
  std::vector<LaserScan> scans;
  while (scans.size() < most) {
    auto scan = source.Next();
    if (!scan) break;
    scans.push_back(std::move(*scan));
  }
  return scans;
}

/// The scans of a simulated drive, or the first of them.
inline std::vector<LaserScan> ScansOf(const World& world, std::uint64_t seed = 1, std::size_t most = SIZE_MAX) {
  Simulator simulator(world, seed);
  return ReadAll(simulator, most);
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
