#pragma once

#include <lcm/lcm-cpp.hpp>
#include <set>
#include <string>
#include <vector>

namespace crsm {

/// Finds the channel prefixes of robots on a bus: each robot's map_updater says once a second that it lives.
class RobotFinder {
 public:
  /// Throws std::runtime_error where there is no such bus.
  explicit RobotFinder(const std::string& lcm_url);

  /// Prefixes that were not found before.
  std::vector<std::string> Find();

 private:
  static constexpr std::size_t kMost = 256;  ///< prefixes: more are no robots

  void Hear(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  lcm::LCM lcm_;
  std::set<std::string> known_;
  std::vector<std::string> found_;
};

}  // namespace crsm
