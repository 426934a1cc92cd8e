#include "services/map_viewer/timeline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/trigonometry.hpp"
#include "common/scan/scan_counts.hpp"

namespace crsm {
namespace {

constexpr double kAngleStep_rad = 1e-4;
constexpr double kRangeStep_m = 0.004;

}  // namespace

void Timeline::Add(const ScanMatch& match, const CriticalRays* scan) {
  moments_.push_back({match, {}, rays_.size(), critical_.size()});
  if (OutcomeOf(match) == ScanOutcome::kOnMap) {
    moments_.back().first = {static_cast<float>(match.T_map_laser.x_m), static_cast<float>(match.T_map_laser.y_m),
                             static_cast<float>(match.T_map_laser.yaw_rad)};
  }
  if (!scan) return;
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  for (std::size_t i = 0; i < scan->rays.size(); ++i) {
    rays_.push_back(
        {static_cast<std::int16_t>(std::lround(WrapAngle(double{scan->rays.angle_rad[i]}) / kAngleStep_rad)),
         static_cast<std::uint16_t>(std::lround(std::min(kMost, scan->rays.range_m[i] / kRangeStep_m)))});
  }
  for (const int index : scan->critical) critical_.push_back(static_cast<std::uint16_t>(index));
}

Timeline Timeline::Pick(std::span<const std::size_t> numbers) const {
  Timeline picked;
  for (const std::size_t number : numbers) {
    const Moment& moment = moments_[number];
    picked.moments_.push_back({moment.match, moment.first, picked.rays_.size(), picked.critical_.size()});
    const auto Copy = [](const auto& from, std::size_t first, std::size_t end, auto& to) {
      to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(first),
                from.begin() + static_cast<std::ptrdiff_t>(end));
    };
    Copy(rays_, moment.first_ray, LastRay(number), picked.rays_);
    Copy(critical_, moment.first_critical, LastCritical(number), picked.critical_);
  }
  return picked;
}

CriticalRays Timeline::scan(std::size_t number) const {
  const ScanMatch& here = moments_[number].match;
  std::size_t kept = number;
  while (kept > 0 && LastRay(kept) == moments_[kept].first_ray) --kept;
  if (moments_[kept].match.trajectory != here.trajectory) return CriticalRays{here.utime, {}, {}};
  CriticalRays scan = Unpack(kept);
  if (kept == number) return scan;
  scan.utime = here.utime;
  const Pose2 T_here_kept = Inverse(here.T_map_laser) * moments_[kept].match.T_map_laser;
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    const double angle = T_here_kept.yaw_rad + double{scan.rays.angle_rad[i]};
    const double x_m = T_here_kept.x_m + scan.rays.range_m[i] * std::cos(angle);
    const double y_m = T_here_kept.y_m + scan.rays.range_m[i] * std::sin(angle);
    scan.rays.angle_rad[i] = static_cast<float>(std::atan2(y_m, x_m));
    scan.rays.range_m[i] = static_cast<float>(std::hypot(x_m, y_m));
  }
  return scan;
}

std::size_t Timeline::LastRay(std::size_t number) const {
  return number + 1 == moments_.size() ? rays_.size() : moments_[number + 1].first_ray;
}

std::size_t Timeline::LastCritical(std::size_t number) const {
  return number + 1 == moments_.size() ? critical_.size() : moments_[number + 1].first_critical;
}

CriticalRays Timeline::Unpack(std::size_t number) const {
  const Moment& moment = moments_[number];
  const std::size_t last_ray = LastRay(number);
  CriticalRays scan{moment.match.utime, {}, {}};
  for (std::size_t i = moment.first_ray; i < last_ray; ++i) {
    scan.rays.angle_rad.push_back(static_cast<float>(rays_[i].angle * kAngleStep_rad));
    scan.rays.range_m.push_back(static_cast<float>(rays_[i].range * kRangeStep_m));
  }
  for (std::size_t i = moment.first_critical; i < LastCritical(number); ++i) scan.critical.push_back(critical_[i]);
  return scan;
}

}  // namespace crsm
