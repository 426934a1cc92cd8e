// bot_core.planar_lidar_t, which LASER itself has: a scan as it is.

#include "services/runtime/conversions.hpp"
#include "services/sources/laser_types.hpp"

namespace crsm {
namespace {

[[maybe_unused]] const bool kRegistered =
    RegisterLaserType<bot_core::planar_lidar_t>("bot_core.planar_lidar_t", &FromMessage);

}  // namespace
}  // namespace crsm
