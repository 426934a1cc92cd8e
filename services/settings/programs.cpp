#include "services/settings/programs.hpp"

namespace crsm {

using enum ParameterGroup;

ProgramFlags FlagsOfPublisher() {
  return {{kSeed, kLaser},
          {"lcm_url", "channel_prefix", "rate", "resend_s", "laser_channel", "laser_frame", "odometry",
           "odometry_topic", "botlab_clockwise", "mirrored", "position"}};
}

ProgramFlags FlagsOfSelector() {
  return {{kLaser, kScan, kSelection, kAlgorithm},
          {"lcm_url", "channel_prefix", "laser_channel", "laser_frame", "botlab_clockwise", "mirrored"}};
}

ProgramFlags FlagsOfMatcher() {
  return {{kSeed, kLoops, kAlgorithm},
          {"lcm_url", "channel_prefix", "odometry", "odometry_topic", "lockstep", "map_wait_s", "start"}};
}

ProgramFlags FlagsOfUpdater() {
  return {{kLaser, kScan, kUpdate, kLoops, kAlgorithm},
          {"lcm_url", "channel_prefix", "lockstep", "journal", "resume", "new_session", "until_damage", "localize",
           "start", "part_bytes"}};
}

ProgramFlags FlagsOfLoopCloser() { return {{kUpdate, kLoops, kAlgorithm}, {"lcm_url", "channel_prefix", "out"}}; }

ProgramFlags FlagsOfExporter() {
  return {{}, {"lcm_url", "channel_prefix", "out", "export_period_s", "made_from", "team"}};
}

ProgramFlags FlagsOfViewer() { return {{}, {"lcm_url", "channel_prefix", "http"}}; }

ProgramFlags FlagsOfMbotPublisher() { return {{}, {"lcm_url", "channel_prefix"}}; }

ProgramFlags FlagsOfFleetMapper() {
  ProgramFlags flags{{kLaser, kScan, kUpdate, kLoops, kAlgorithm},
                     {"lcm_url", "channel_prefix", "journal", "resume", "until_damage", "part_bytes"}};
  flags.defaults.channel_prefix = "fleet/";
  return flags;
}

ProgramFlags FlagsOfFleetRelay() { return {{}, {"lcm_url", "channel_prefix"}}; }

}  // namespace crsm
