#pragma once

#include <array>
#include <deque>
#include <optional>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/odometry_buffer.hpp"

namespace crsm {

/// Tells whether scans are mirrored, clockwise where they should be counter-clockwise, by headings that somebody else
/// knew of the same robot: its wheels, or another program that mapped. Scans of a robot that turns to the left shift to
/// the right; where they shift to the left, they are mirrored. A map of mirrored scans agrees with all of them: nothing
/// else tells.
class HandednessJudge {
 public:
  enum class Verdict { kUnknown, kRight, kMirrored };

  explicit HandednessJudge(const DiagnosisConstants::Handedness& constants = {}) : constants_(constants) {}

  /// Scans in their order, and headings in theirs; a scan is compared when the headings around it are known
  /// (OdometryBuffer).
  void Add(const LaserScan& scan);
  void Add(const Odometry& heading);

  /// Not unknown once ten pairs of scans, 4 to 45 degrees apart, have told, and no more than one in five told
  /// otherwise.
  Verdict verdict() const;

 private:
  static constexpr int kBins = 180;  ///< the size of an array
  /// The nearest range in each direction [m], counter-clockwise from the laser's x axis; 0: none.
  using Profile = std::array<float, kBins>;
  struct Sight {
    std::int64_t utime = 0;
    Profile profile{};
    double yaw_rad = 0.0;
  };

  void CompareWaiting();
  void Compare(const Sight& sight);

  DiagnosisConstants::Handedness constants_;
  OdometryBuffer headings_{256};
  std::deque<Sight> waiting_;  ///< for the heading after them
  std::optional<Sight> reference_;
  int reference_age_ = 0;
  int num_right_ = 0;
  int num_mirrored_ = 0;

  static Profile MakeProfile(const LaserScan& scan);
  std::optional<double> Differ(const Profile& profile, const Profile& reference, double turn_rad) const;
};

}  // namespace crsm
