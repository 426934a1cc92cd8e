#include "common/graph/pieces.hpp"

#include <algorithm>
#include <cmath>

#include "common/match/match_scan.hpp"

namespace crsm {
namespace {

/// Between two times [s], whichever comes first.
double SecondsBetween(std::int64_t utime, std::int64_t other) {
  return 1e-6 * std::abs(static_cast<double>(utime) - static_cast<double>(other));
}

}  // namespace

const char* Name(BreakReason reason) {
  switch (reason) {
    case BreakReason::kLost:
      return "lost";
    case BreakReason::kGap:
      return "gap";
    case BreakReason::kClock:
      return "clock";
    case BreakReason::kSession:
      return "session";
  }
  return "";
}

std::vector<int> MapPieces::OthersWithMap(const GraphConstants::Pieces& constants) const {
  std::vector<int> numbers;
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    if (pieces[i].way_m >= constants.least_way_m) numbers.push_back(static_cast<int>(i) + 1);
  }
  return numbers;
}

void TrajectoryLog::Add(const ScanMatch& match, int num_trajectories) {
  if (num_trajectories > size()) trajectories_.push_back({MakeBreak(match), 0, num_scans_, match.T_map_laser});
  const bool lost = match.state == MatchState::kLost;
  num_lost_ = lost ? num_lost_ + 1 : 0;
  last_utime_ = match.utime;
  if (!lost) last_match_utime_ = match.utime;
  if (!lost && size() > 0) {
    ++trajectories_.back().num_matched;
    trajectories_.back().last_matched = num_scans_;
    trajectories_.back().T_map_last = match.T_map_laser;
  }
  ++num_scans_;
}

/// The reasons are those for which MatchScan begins a trajectory.
Break TrajectoryLog::MakeBreak(const ScanMatch& match) const {
  Break begun;
  begun.utime = match.utime;
  begun.scan = num_scans_;
  begun.seconds = SecondsBetween(match.utime, last_utime_);
  if (num_lost_ + 1 >= constants_.lost_scans_max) {
    begun.reason = BreakReason::kLost;
    begun.seconds = SecondsBetween(match.utime, last_match_utime_);
  } else if (match.utime < last_utime_) {
    begun.reason = BreakReason::kClock;
  } else if (begun.seconds > constants_.gap_max_s) {
    begun.reason = BreakReason::kGap;
  } else {
    begun.reason = BreakReason::kSession;
  }
  return begun;
}

}  // namespace crsm
