#include "services/wire/message_types.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "common/math/trigonometry.hpp"
#include "services/base/printable.hpp"
#include "services/wire/wire.hpp"

namespace crsm {
namespace {

template <class Message>
std::uint64_t FingerprintOf() {
  return static_cast<std::uint64_t>(Message::getHash());
}

/// Why the values of a scan whose bytes are those of its type are out of range.
std::string DescribeValues(const bot_core::planar_lidar_t& scan) {
  constexpr double kTwoTurns_deg = 720.0;
  const double sweep = std::abs(static_cast<double>(scan.radstep)) * std::max(0, scan.nranges - 1);
  const double largest = std::max(sweep, std::abs(static_cast<double>(scan.rad0)));
  if (largest > kFullTurn_rad && largest <= kTwoTurns_deg) {
    return fmt::format(
        "angles look like degrees (rad0 {:.6g}, radstep {:.6g}, {} rays): they must be radians: the driver must divide "
        "by 57.2958",
        scan.rad0, scan.radstep, scan.nranges);
  }
  if (scan.utime < 0) return fmt::format("utime is below 0 ({}): it must be microseconds since 1970", scan.utime);
  if (scan.nranges < static_cast<int>(kMinBeams)) {
    return fmt::format("scans have {} rays: they must have {} to {}", scan.nranges, kMinBeams, kMaxBeams);
  }
  if (scan.nintensities != 0 && scan.nintensities != scan.nranges) {
    return fmt::format(
        "scans have {} ranges and {} intensities: both numbers must be equal, or there must be no intensities",
        scan.nranges, scan.nintensities);
  }
  return fmt::format(
      "rad0 is {} and radstep {}: both must be finite and within a full turn [rad], and radstep must not be 0",
      scan.rad0, scan.radstep);
}

}  // namespace

std::string NameOfType(std::uint64_t fingerprint) {
  if (const LaserType* laser = FindLaserType(fingerprint)) return laser->name;
  static const std::map<std::uint64_t, std::string> kNames{
      {FingerprintOf<bot_core::pose_t>(), "bot_core.pose_t"},
      {FingerprintOf<critical_rays_t>(), "crsm.critical_rays_t"},
      {FingerprintOf<keyframe_t>(), "crsm.keyframe_t"},
      {FingerprintOf<keyframe_request_t>(), "crsm.keyframe_request_t"},
      {FingerprintOf<map_delta_t>(), "crsm.map_delta_t"},
      {FingerprintOf<map_page_t>(), "crsm.map_page_t"},
      {FingerprintOf<map_request_t>(), "crsm.map_request_t"},
      {FingerprintOf<mark_t>(), "crsm.mark_t"},
      {FingerprintOf<pose_graph_t>(), "crsm.pose_graph_t"},
      {FingerprintOf<robot_marks_t>(), "crsm.robot_marks_t"},
      {FingerprintOf<scan_answer_t>(), "crsm.scan_answer_t"},
      {FingerprintOf<scan_match_t>(), "crsm.scan_match_t"},
      {FingerprintOf<scan_request_t>(), "crsm.scan_request_t"},
      {FingerprintOf<service_status_t>(), "crsm.service_status_t"}};
  const auto name = kNames.find(fingerprint);
  return name != kNames.end() ? name->second : fmt::format("a type with fingerprint 0x{:016x}", fingerprint);
}

std::string DescribeRefusedLaser(std::span<const std::uint8_t> bytes) {
  using Lidar = bot_core::planar_lidar_t;
  const LaserType* type = FindLaserType(bytes);
  if (!type) {
    return fmt::format("messages are {}: they must be one of {} (lcmtypes/)",
                       bytes.size() < 8 ? "too short for LCM" : NameOfType(Fingerprint(bytes)), LaserTypeNames());
  }
  if (!Is<Lidar>(bytes)) {
    return fmt::format(
        "messages of {} are cut short, have a time below 0, do not have {} to {} beams, or have angles beyond a full "
        "turn [rad]: {} bytes came",
        type->name, kMinBeams, kMaxBeams, bytes.size());
  }
  Lidar scan;
  if (!CountsFit<Lidar>(bytes) || scan.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) {
    return fmt::format("messages are cut short, or have more than {} rays: {} bytes came", kMaxBeams, bytes.size());
  }
  return DescribeValues(scan);
}

std::string DescribeMirrored(const std::string& pose_channel, const LaserType& laser,
                             const LaserMessageOptions& options) {
  std::string mend = options.mirrored ? "remove --mirrored" : "add --mirrored";
  if (laser.name.starts_with("botlab.")) {
    mend = options.botlab_clockwise ? "add --no-botlab-clockwise" : "remove --no-botlab-clockwise";
  }
  return fmt::format("turn in the opposite direction to the poses on {}: the map is a mirror image: {}",
                     MakePrintable(pose_channel), mend);
}

}  // namespace crsm
