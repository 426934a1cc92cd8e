#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// A finished run scan by scan, by all that is known at its end, and where each scan was matched first. Scans are kept
/// in four bytes a ray: angles to 0.1 mrad, ranges to 4 mm and 262 m.
class Timeline {
 public:
  /// match: of that moment, before anything that came later moved it. scan: null where the run has not kept it.
  void Add(const ScanMatch& match, const CriticalRays* scan);

  void SetMatch(std::size_t number, const ScanMatch& match) { moments_[number].match = match; }

  /// These scans alone.
  Timeline Pick(std::span<const std::size_t> numbers) const;

  std::size_t size() const { return moments_.size(); }
  const ScanMatch& match(std::size_t number) const { return moments_[number].match; }

  struct Position {
    float x_m = std::numeric_limits<float>::quiet_NaN();
    float y_m = std::numeric_limits<float>::quiet_NaN();
    float yaw_rad = std::numeric_limits<float>::quiet_NaN();
  };
  /// Where the scan was matched first; NaN where it was lost, or floated.
  Position first_position(std::size_t number) const { return moments_[number].first; }

  /// Where the run has not kept it, because it was not drawn: the one before that was, as it is seen from here.
  CriticalRays scan(std::size_t number) const;

 private:
  struct Ray {
    std::int16_t angle = 0;
    std::uint16_t range = 0;
  };
  struct Moment {
    ScanMatch match;
    Position first;
    std::size_t first_ray = 0;
    std::size_t first_critical = 0;
  };

  std::size_t LastRay(std::size_t number) const;
  std::size_t LastCritical(std::size_t number) const;
  CriticalRays Unpack(std::size_t number) const;

  std::vector<Moment> moments_;
  std::vector<Ray> rays_;
  std::vector<std::uint16_t> critical_;
};

}  // namespace crsm
