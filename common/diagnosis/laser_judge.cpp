#include "common/diagnosis/laser_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/scan/clock_restart.hpp"
#include "common/scan/same_scan.hpp"
#include "common/scan/utime_unit.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {
namespace {

/// "35 min", say.
std::string FormatDuration(std::int64_t duration_us) {
  constexpr double kFew = 120.0;  // of a unit: more are said in a larger one
  double duration = 1e-6 * static_cast<double>(duration_us);
  if (duration < kFew) return fmt::format("{:.0f} s", duration);
  if ((duration /= 60.0) < kFew) return fmt::format("{:.0f} min", duration);
  if ((duration /= 60.0) < kFew) return fmt::format("{:.0f} h", duration);
  return fmt::format("{:.0f} days", duration / 24.0);
}

/// How the ranges of a scan lie to what the laser may measure.
struct RangeCount {
  std::size_t num_measured = 0;  ///< finite and above 0
  std::size_t num_valid = 0;     ///< of them, between range_min_m and the largest usable range
};

RangeCount CountRanges(const LaserScan& scan, const ScanParameters& parameters) {
  const auto min_m = static_cast<float>(parameters.range_min_m);
  const auto max_m = static_cast<float>(LargestUsableRange(parameters));
  RangeCount count;
  for (const float range_m : scan.ranges_m) {
    if (!(range_m > 0.0f) || std::isinf(range_m)) continue;
    ++count.num_measured;
    if (range_m >= min_m && range_m <= max_m) ++count.num_valid;
  }
  return count;
}

/// Of the finite ranges above 0, of which there is one at least.
struct RangeSpread {
  float least_m;
  float median_m;
  float most_m;
};

RangeSpread FindSpread(const LaserScan& scan) {
  std::vector<float> ranges_m;
  for (const float range_m : scan.ranges_m) {
    if (range_m > 0.0f && !std::isinf(range_m)) ranges_m.push_back(range_m);
  }
  std::sort(ranges_m.begin(), ranges_m.end());
  return {ranges_m.front(), ranges_m[ranges_m.size() / 2], ranges_m.back()};
}

/// Whether ranges that the laser cannot have would be of a room if they were a thousandth of it. A laser that says "no
/// return" by a large number says the same one each time.
bool LookLikeMillimetres(const LaserScan& scan, const RangeCount& count,
                         const DiagnosisConstants::LaserJudge& constants) {
  if (count.num_measured == 0 || constants.valid_one_in * count.num_valid > count.num_measured) return false;
  const RangeSpread spread = FindSpread(scan);
  return spread.median_m > constants.millimetres_median_min && spread.median_m < constants.millimetres_median_max &&
         spread.least_m != spread.most_m;
}

std::string DescribeNoRays(const LaserScan& scan, const RangeCount& count, const ScanParameters& parameters) {
  const std::size_t num_beams = scan.ranges_m.size();
  if (count.num_measured == 0) {
    return fmt::format(
        "none of the {} rays has a range (each is 0, below 0, infinite or NaN): is the laser covered, or its motor "
        "off?",
        num_beams);
  }
  const RangeSpread spread = FindSpread(scan);
  return fmt::format(
      "none of the {} rays is usable: ranges are {:.4g} m to {:.4g} m, but only {:.4g} m to {:.4g} m are accepted: set "
      "range_max_m ({}) and range_min_m ({}) to the laser's values",
      num_beams, spread.least_m, spread.most_m, parameters.range_min_m, LargestUsableRange(parameters),
      parameters.range_max_m, parameters.range_min_m);
}

}  // namespace

std::vector<std::string> LaserJudge::Look(const LaserScan& scan) {
  if (num_scans_ > 0 && IsSameScan(scan, last_)) return {};
  std::vector<std::string> found;
  if (num_scans_ > 0) {
    JudgeRestart(scan, found);
    JudgeClock(scan, found);
    if (num_scans_ == constants_.steps_of_pace) JudgeUnit(scan, found);
  } else {
    first_utime_ = scan.utime;
  }
  const bool doubted = std::any_of(in_a_row_.begin(), in_a_row_.end(), [](const auto& row) { return row.second > 0; });
  const bool due = num_scans_ < constants_.looked_at_first || num_scans_ % constants_.looked_at_one_in == 0;
  if (due || doubted) JudgeRanges(scan, found);
  last_ = scan;
  ++num_scans_;
  return found;
}

void LaserJudge::JudgeClock(const LaserScan& scan, std::vector<std::string>& found) {
  standing_steps_ <<= 1;
  standing_steps_[0] = scan.utime == last_.utime;
  backward_steps_ <<= 1;
  backward_steps_[0] = scan.utime < last_.utime;
  if (CountInWindow(standing_steps_) >= constants_.enough && IsNew(Fault::kClockStands)) {
    JudgeUnit(scan, found);
    found.push_back(fmt::format(
        "utime {} {}: {} are lost, because utime identifies a scan: the driver must set it to the time of each scan "
        "[us]",
        scan.utime == 0 ? "is always" : "stands still at", scan.utime,
        scan.utime == first_utime_ ? "all scans but one" : "scans with the utime of another one"));
  }
  const int num_backward = CountInWindow(backward_steps_);
  if (num_backward >= constants_.enough && IsNew(Fault::kClockGoesBack)) {
    found.push_back(
        fmt::format("utime goes back in {} of {} scans, now from {} to {} [us]: are there two lasers on this channel, "
                    "or is the driver's clock wrong?",
                    num_backward, constants_.window_steps, last_.utime, scan.utime));
  }
}

/// Where the clock shows one that is not microseconds.
void LaserJudge::JudgeUnit(const LaserScan& scan, std::vector<std::string>& found) {
  const double step = MeanStep(scan);
  const auto unit = FindWrongUnit(scan.utime, step);
  if (unit && IsNew(Fault::kUnit)) found.push_back(DescribeWrongUnit(*unit, scan.utime, step));
}

/// From the first scan to this one.
double LaserJudge::MeanStep(const LaserScan& scan) const {
  return (static_cast<double>(scan.utime) - static_cast<double>(first_utime_)) / static_cast<double>(num_scans_);
}

void LaserJudge::JudgeRestart(const LaserScan& scan, std::vector<std::string>& found) {
  if (!HasClockRestarted(last_.utime, scan.utime)) return;
  const auto earlier = std::exchange(restart_, num_scans_);
  if (earlier && num_scans_ - *earlier < constants_.window_steps) return;
  found.push_back(
      fmt::format("the clock steps back by {} at scan {}: unless the robot stands where it stood, a new "
                  "trajectory begins",
                  FormatDuration(last_.utime - scan.utime), num_scans_ + 1));
}

void LaserJudge::JudgeRanges(const LaserScan& scan, std::vector<std::string>& found) {
  const RangeCount count = CountRanges(scan, parameters_);
  const bool millimetres = LookLikeMillimetres(scan, count, constants_);
  const auto Show = [this](Fault fault, bool shown) {
    int& in_a_row = in_a_row_[fault];
    in_a_row = shown ? in_a_row + 1 : 0;
    return in_a_row >= constants_.enough && IsNew(fault);
  };
  if (Show(Fault::kMillimetres, millimetres)) {
    found.push_back(
        fmt::format("ranges look like millimetres, half of them above {:.0f}: they must be metres: the driver must "
                    "divide by 1000",
                    FindSpread(scan).median_m));
  }
  if (Show(Fault::kNoRays, count.num_valid == 0 && !millimetres)) {
    found.push_back(DescribeNoRays(scan, count, parameters_));
  }
}

int LaserJudge::CountInWindow(const Steps& steps) const {
  return static_cast<int>((steps << (steps.size() - static_cast<std::size_t>(constants_.window_steps))).count());
}

bool LaserJudge::IsNew(Fault fault) { return !std::exchange(said_[fault], true); }

}  // namespace crsm
