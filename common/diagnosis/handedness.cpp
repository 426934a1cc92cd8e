#include "common/diagnosis/handedness.hpp"

#include <algorithm>
#include <cmath>

#include "common/math/trigonometry.hpp"
#include "common/parameters.hpp"

namespace crsm {

void HandednessJudge::Add(const LaserScan& scan) {
  constexpr std::size_t kMostWaiting = 32;  // for memory
  waiting_.push_back({scan.utime, MakeProfile(scan)});
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
  CompareWaiting();
}

void HandednessJudge::Add(const Odometry& heading) {
  headings_.Add(heading);
  CompareWaiting();
}

HandednessJudge::Verdict HandednessJudge::verdict() const {
  if (num_right_ + num_mirrored_ < constants_.enough_pairs) return Verdict::kUnknown;
  if (constants_.others_one_in * num_mirrored_ <= num_right_ + num_mirrored_) return Verdict::kRight;
  if (constants_.others_one_in * num_right_ <= num_right_ + num_mirrored_) return Verdict::kMirrored;
  return Verdict::kUnknown;
}

void HandednessJudge::CompareWaiting() {
  for (; !waiting_.empty(); waiting_.pop_front()) {
    const ScanOdometry heading = headings_.Find(waiting_.front().utime);
    if (heading.state == ScanOdometry::State::kAwaited) return;
    if (heading.state != ScanOdometry::State::kKnown) continue;
    waiting_.front().yaw_rad = heading.T_odom_robot->yaw_rad;
    Compare(waiting_.front());
  }
}

/// With the last scan that it has turned from, not far from which it was taken.
void HandednessJudge::Compare(const Sight& sight) {
  const double turn_rad = reference_ ? WrapAngle(sight.yaw_rad - reference_->yaw_rad) : 0.0;
  if (reference_ && std::abs(turn_rad) < constants_.least_turn_rad && ++reference_age_ < constants_.oldest_scans)
    return;
  if (std::abs(turn_rad) >= constants_.least_turn_rad && std::abs(turn_rad) <= constants_.most_turn_rad) {
    const auto as_is = Differ(sight.profile, reference_->profile, turn_rad);
    const auto mirrored = Differ(sight.profile, reference_->profile, -turn_rad);
    if (as_is && mirrored && *as_is < constants_.clearly * *mirrored) ++num_right_;
    if (as_is && mirrored && *mirrored < constants_.clearly * *as_is) ++num_mirrored_;
  }
  reference_ = sight;
  reference_age_ = 0;
}

HandednessJudge::Profile HandednessJudge::MakeProfile(const LaserScan& scan) {
  Profile profile{};
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const float range_m = scan.ranges_m[i];
    if (!(range_m > 0.0f) || range_m > kLongestRange_m) continue;
    const double angle_rad = scan.angle_min_rad + static_cast<double>(i) * scan.angle_step_rad;
    const long bin = std::lround(angle_rad / (2.0 * kPi) * kBins) % kBins;
    float& nearest_m = profile[static_cast<std::size_t>(bin < 0 ? bin + kBins : bin)];
    if (nearest_m == 0.0f || range_m < nearest_m) nearest_m = range_m;
  }
  return profile;
}

/// How much a profile differs from the reference if the robot has turned so since [m]; nothing where they share little.
std::optional<double> HandednessJudge::Differ(const Profile& profile, const Profile& reference, double turn_rad) const {
  const long shift = std::lround(turn_rad / (2.0 * kPi) * kBins);
  int num_shared = 0;
  double sum_m = 0.0;
  for (int bin = 0; bin < kBins; ++bin) {
    const float now_m = profile[static_cast<std::size_t>(bin)];
    const float before_m = reference[static_cast<std::size_t>((bin + shift + kBins) % kBins)];
    if (now_m == 0.0f || before_m == 0.0f) continue;
    ++num_shared;
    sum_m += std::min(std::abs(now_m - before_m), constants_.most_difference_m);
  }
  return num_shared >= constants_.enough_shared ? std::optional(sum_m / num_shared) : std::nullopt;
}

}  // namespace crsm
