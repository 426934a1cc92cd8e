#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/graph/mapper.hpp"
#include "services/base/line_limit.hpp"

namespace crsm {

/// In each line about a break, and in each about a join: run_stack finds them in the log of map_updater by these.
inline constexpr const char* kNewTrajectory = "a new trajectory begins";
inline constexpr const char* kMappedFrom = "what was mapped from scan ";

/// Says on the terminal where a trajectory begins, and where parts of the map are joined or fall apart: a line each. Of
/// a log with hundreds of breaks it says some, and how many it has left out.
class BreakNews {
 public:
  using Clock = std::chrono::steady_clock;

  /// What the mapper knows already is no news: it is of an earlier session.
  void Skip(const Mapper& mapper);

  /// What is new since the last call, ready to be said. To be called often: it costs little where nothing is new.
  std::vector<std::string> Look(const Mapper& mapper, Clock::time_point now);

 private:
  std::vector<std::string> FindNews(const Mapper& mapper);

  std::vector<int> components_;  ///< by trajectory, as they were told
  LineLimit limit_;
};

/// "scan 535: lost for 1.3 s: a new trajectory begins".
std::string DescribeBreak(const Break& at);

}  // namespace crsm
