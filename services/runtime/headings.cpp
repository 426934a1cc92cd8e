#include "services/runtime/headings.hpp"

#include <fmt/format.h>

#include <cmath>
#include <mbot_lcm_msgs/pose2D_t.hpp>

#include "common/math/trigonometry.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/printable.hpp"

namespace crsm {

template <>
constexpr auto FieldsOf<mbot_lcm_msgs::pose2D_t>() {
  using T = mbot_lcm_msgs::pose2D_t;
  return std::tuple(&T::utime, &T::x, &T::y, &T::theta);
}

template <>
bool ValuesInRange(const mbot_lcm_msgs::pose2D_t& pose) {
  constexpr float kMost = 1000.0f;  // a heading that nobody wraps has turns in it
  return pose.utime >= 0 && std::abs(pose.theta) <= kMost && std::isfinite(pose.x) && std::isfinite(pose.y);
}

std::optional<Odometry> DecodeHeading(std::span<const std::uint8_t> bytes) {
  if (const auto pose = Decode<bot_core::pose_t>(bytes)) return FromMessage(*pose);
  if (const auto pose = Decode<mbot_lcm_msgs::pose2D_t>(bytes)) {
    return Odometry{pose->utime, Pose2{pose->x, pose->y, WrapAngle(pose->theta)}};
  }
  return std::nullopt;
}

std::string DescribeMirrored(const std::string& heading_channel, const LaserType& laser,
                             const ScanParameters& parameters) {
  std::string mend = "the driver must turn its angles round";
  if (laser.name.starts_with("botlab.")) {
    mend = parameters.botlab_clockwise ? "say --no-botlab-clockwise" : "leave --no-botlab-clockwise away";
  }
  return fmt::format("turn against the poses on {}: the map is a mirror image: {}", MakePrintable(heading_channel),
                     mend);
}

}  // namespace crsm
