#pragma once

#include <string>

namespace crsm {

/// Which laser of a log to take.
struct LaserChoice {
  std::string channel = {};  ///< of an LCM log; empty for the first that has a laser. Or topic of a bag
  std::string frame = {};    ///< frame_id of its scans; empty where only one laser is on the channel
};

}  // namespace crsm
