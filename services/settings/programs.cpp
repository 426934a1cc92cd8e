#include "services/settings/programs.hpp"

namespace crsm {

using enum ParameterGroup;

ProgramFlags FlagsOfPublisher() {
  return {
      {kSeed, kOdometry, kLaser},
      {"lcm_url", "channel_prefix", "rate", "resend_s", "laser_channel", "laser_frame", "odometry_topic", "position"}};
}

ProgramFlags FlagsOfSelector() {
  return {{kLaser, kScan, kSelection}, {"lcm_url", "channel_prefix", "laser_channel", "laser_frame"}};
}

ProgramFlags FlagsOfMatcher() {
  return {{kSeed, kOdometry, kMatch, kLoops},
          {"lcm_url", "channel_prefix", "odometry_topic", "lockstep", "map_wait_s", "start"}};
}

ProgramFlags FlagsOfUpdater() {
  return {{kLaser, kScan, kUpdate, kLoops},
          {"lcm_url", "channel_prefix", "lockstep", "journal", "resume", "new_session", "until_damage", "localize",
           "start", "part_bytes"}};
}

ProgramFlags FlagsOfLoopCloser() { return {{kUpdate, kLoops}, {"lcm_url", "channel_prefix", "out"}}; }

ProgramFlags FlagsOfExporter() { return {{}, {"lcm_url", "channel_prefix", "out", "export_period_s"}}; }

ProgramFlags FlagsOfViewer() { return {{}, {"lcm_url", "channel_prefix", "http"}}; }

ProgramFlags FlagsOfMbotPublisher() { return {{}, {"lcm_url", "channel_prefix"}}; }

}  // namespace crsm
