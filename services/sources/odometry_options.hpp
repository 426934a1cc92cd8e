#pragma once

#include <string>

namespace crsm {

/// What is to be made of the odometry in a log.
struct OdometryOptions {
  bool is_used = false;  ///< else it is only noted that it is there
  std::string topic;     ///< topic, frame of TF or LCM channel that has it; empty for the usual ones
};

}  // namespace crsm
