#include "services/fleet_mapper/robot_finder.hpp"

#include <stdexcept>
#include <utility>

#include "services/bus/bus.hpp"
#include "services/wire/channels.hpp"

namespace crsm {

RobotFinder::RobotFinder(const std::string& lcm_url) : lcm_(CompleteUrl(lcm_url)) {
  if (!lcm_.good()) throw std::runtime_error("--robots auto: the bus cannot be reached");
  lcm_.subscribe(".*/" + ServiceStatusChannel("map_updater"), &RobotFinder::Hear, this);
}

std::vector<std::string> RobotFinder::Find() {
  while (lcm_.handleTimeout(0) > 0) {
  }
  return std::exchange(found_, {});
}

/// What it says is of no interest here.
void RobotFinder::Hear(const lcm::ReceiveBuffer*, const std::string& channel) {
  const std::string prefix = channel.substr(0, channel.size() - ServiceStatusChannel("map_updater").size());
  if (known_.size() < kMost && known_.insert(prefix).second) found_.push_back(prefix);
}

}  // namespace crsm
