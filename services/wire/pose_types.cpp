#include "services/wire/pose_types.hpp"

#include <cmath>
#include <wire_fields/mbot_lcm_msgs/pose2D_t.hpp>

#include "common/math/trigonometry.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {

template <>
bool ValuesInRange(const mbot_lcm_msgs::pose2D_t& pose) {
  constexpr float kMost = 1000.0f;  // a heading that nobody wraps has turns in it
  return pose.utime >= 0 && std::abs(pose.theta) <= kMost && std::isfinite(pose.x) && std::isfinite(pose.y);
}

bool IsPoseMessage(std::span<const std::uint8_t> bytes) {
  return Is<bot_core::pose_t>(bytes) || Is<mbot_lcm_msgs::pose2D_t>(bytes);
}

std::optional<Odometry> DecodePose(std::span<const std::uint8_t> bytes) {
  if (const auto pose = Decode<bot_core::pose_t>(bytes)) return FromMessage(*pose);
  if (const auto pose = Decode<mbot_lcm_msgs::pose2D_t>(bytes)) {
    return Odometry{pose->utime, RoundOdometry({pose->x, pose->y, WrapAngle(pose->theta)})};
  }
  return std::nullopt;
}

}  // namespace crsm
