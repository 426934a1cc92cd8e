#include "common/scan/thin_beams.hpp"

#include <vector>

namespace crsm {
namespace {

std::vector<float> TakeEveryNth(const std::vector<float>& values, std::size_t n) {
  std::vector<float> kept;
  for (std::size_t i = 0; i < values.size(); i += n) kept.push_back(values[i]);
  return kept;
}

}  // namespace

std::string ThinBeams(LaserScan& scan) {
  const std::size_t num_beams = scan.ranges_m.size();
  if (num_beams <= kMaxBeams) return "";
  const std::size_t n = (num_beams + kMaxBeams - 1) / kMaxBeams;
  scan.ranges_m = TakeEveryNth(scan.ranges_m, n);
  scan.times_s = TakeEveryNth(scan.times_s, n);
  scan.angle_step_rad *= static_cast<float>(n);
  return "scans have " + std::to_string(num_beams) + " beams, of which one in " + std::to_string(n) +
         " is used, because " + std::to_string(kMaxBeams) + " are the most";
}

}  // namespace crsm
