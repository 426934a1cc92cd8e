// bot_core.planar_lidar_t, and crsm.sweep_t, which says of each beam when it was measured: scans as they are.
//
// A fingerprint hashes what the members are called, not the type: bot_core.planar_lidar_t is the same message under the
// names that it has elsewhere (sm.planar_lidar_t, laser_t).

#include "services/wire/conversions.hpp"
#include "services/wire/laser_types.hpp"

namespace crsm {
namespace {

template <class Message>
LaserScan ToScan(const Message& message, const LaserMessageOptions&) {
  return FromMessage(message);
}

[[maybe_unused]] const bool kRegistered =
    RegisterLaserType<bot_core::planar_lidar_t>("bot_core.planar_lidar_t", &ToScan) &&
    RegisterLaserType<sweep_t>("crsm.sweep_t", &ToScan);

}  // namespace
}  // namespace crsm
