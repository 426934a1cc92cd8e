#include "common/logs/sweep_stamps.hpp"

#include <algorithm>
#include <cmath>

#include "common/math/median.hpp"

namespace crsm {

void SweepStamps::Study(std::int64_t stamp, std::int64_t recorded_utime) {
  lags_s_.push_back(1e-6 * (static_cast<double>(recorded_utime) - static_cast<double>(stamp)));
}

bool SweepStamps::AreOfFirstBeam(double sweep_s) const {
  if (sweep_s == 0.0 || lags_s_.size() < constants_.few) return false;
  return std::ranges::min(lags_s_) >= constants_.earliest * std::abs(sweep_s) &&
         FindMedian(lags_s_) <= constants_.usual * std::abs(sweep_s);
}

}  // namespace crsm
