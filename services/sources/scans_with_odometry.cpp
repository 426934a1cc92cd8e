#include "services/sources/scans_with_odometry.hpp"

#include <fmt/format.h>

#include "common/logs/left_out.hpp"

namespace crsm {

bool ScansWithOdometry::Add(LaserScan scan) {
  const std::int64_t clock_utime = scan.utime;
  const auto utime = utimes_.Add(clock_utime);
  if (!utime) return false;
  scan.utime = *utime;
  waiting_.push_back({std::move(scan), clock_utime});
  return true;
}

bool ScansWithOdometry::NextIsReady() const {
  constexpr std::size_t kMostWaiting = 8;
  constexpr std::int64_t kLongestWait_us = 1'000'000;
  if (waiting_.empty()) return false;
  const std::int64_t utime = waiting_.front().clock_utime;
  return waiting_.size() > kMostWaiting || waiting_.back().clock_utime - utime > kLongestWait_us ||
         odometry_.Find(utime).state != ScanOdometry::State::kAwaited;
}

std::optional<LaserScan> ScansWithOdometry::Next() {
  if (waiting_.empty()) return std::nullopt;
  Waiting next = std::move(waiting_.front());
  waiting_.pop_front();
  const ScanOdometry found = odometry_.Find(next.clock_utime);
  T_odom_robot_ = found.T_odom_robot;
  if (T_odom_robot_) ++num_with_odometry_;
  if (found.state == ScanOdometry::State::kAwaited) ++num_given_up_;
  return std::move(next.scan);
}

std::string ScansWithOdometry::ExplainNoOdometry() const {
  if (2 * num_given_up_ > num_scans()) {
    return "its messages stand too late in the recording, behind eight more scans or a second, or are too few";
  }
  return "a scan needs a message within 0.1 s before it and one within 0.1 s after it, by their own times";
}

std::vector<std::string> ScansWithOdometry::Complaints(const std::string& channel,
                                                       const std::map<std::string, std::int64_t>& counts,
                                                       const std::string& refusal, const std::string& time) const {
  std::vector<std::string> complaints;
  const std::int64_t num_all = num_scans() + CountLeftOut(counts);
  if (const auto num_bad = FindCount(counts, "bad_message"); !refusal.empty() && IsWorthSaying(num_bad, num_all)) {
    complaints.push_back(fmt::format("{} of {} scans on {} are left out: {}", num_bad, num_all, channel, refusal));
  }
  if (const auto num_repeated = FindCount(counts, "utime_repeated"); IsWorthSaying(num_repeated, num_all)) {
    complaints.push_back(
        fmt::format("{} of {} scans on {} repeat the {} of an earlier scan and are left out: the driver must set {} to "
                    "the time of each scan",
                    num_repeated, num_all, channel, time, time));
  }
  return complaints;
}

}  // namespace crsm
