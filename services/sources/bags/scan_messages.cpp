#include "services/sources/bags/scan_messages.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/scan/thin_beams.hpp"
#include "services/sources/bags/ros_message.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/message_types.hpp"
#include "services/wire/ros_scan.hpp"

namespace crsm {
namespace {

using Json = nlohmann::json;

constexpr const char* kMalformed = "messages are cut short, or do not match their type";

DecodedScan MakeScan(RosScan raw, const ScanParameters& parameters) {
  constexpr std::int64_t kMostSeconds = 9'000'000'000;
  const auto& [sec, nanosec] = raw.stamp;
  if (sec < 0 || sec > kMostSeconds || nanosec < 0 || nanosec >= kRosSecond_ns) {
    return {{}, fmt::format("their stamp is {} s and {} ns: it must be the time since 1970", sec, nanosec)};
  }
  if (raw.ranges.size() < kMinBeams || raw.ranges.size() > kMostBeamsRead) {
    return {{},
            fmt::format("scans have {} ranges: they must have {} to {}", raw.ranges.size(), kMinBeams, kMostBeamsRead)};
  }
  std::string contradiction = DescribeContradiction(raw);
  LaserScan scan = FromRosScan(std::move(raw), parameters);
  std::string thinned = ThinBeams(scan);
  // What goes over the wire has to pass there.
  const bot_core::planar_lidar_t message = ToMessage(scan);
  if (ValuesInRange(message)) return {std::move(scan), "", "", std::move(thinned), std::move(contradiction)};
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return {{}, DescribeRefusedLaser(bytes)};
}

/// Nothing if there are more than bytes for them.
std::vector<float> ReadFloats(ByteReader& reader) {
  const auto count = reader.Read<std::uint32_t>();
  if (!reader.ok() || count > reader.left() / sizeof(float)) {
    reader.Take(std::numeric_limits<std::uint64_t>::max());
    return {};
  }
  std::vector<float> floats(count);
  for (float& number : floats) number = reader.Read<float>();
  return floats;
}

/// Of sensor_msgs/MultiEchoLaserScan: the first echo of each beam, the nearest thing that it has met; NaN where there
/// is none.
std::vector<float> ReadFirstEchoes(ByteReader& reader) {
  const auto count = reader.Read<std::uint32_t>();
  if (!reader.ok() || count > reader.left() / sizeof(std::uint32_t)) {
    reader.Take(std::numeric_limits<std::uint64_t>::max());
    return {};
  }
  std::vector<float> firsts;
  for (std::uint32_t beam = 0; beam < count && reader.ok(); ++beam) {
    const std::vector<float> echoes = ReadFloats(reader);
    firsts.push_back(echoes.empty() ? std::numeric_limits<float>::quiet_NaN() : echoes.front());
  }
  return firsts;
}

/// sensor_msgs/LaserScan, and MultiEchoLaserScan, which differs in its ranges and intensities alone.
DecodedScan DecodeRosScan(const BagTopic& topic, std::string_view data, const ScanParameters& parameters) {
  auto message = OpenMessage(topic, data);
  if (!message) return {{}, kMalformed};
  ByteReader& reader = message->reader;
  RosScan raw;
  RosHeader header = ReadHeader(*message);
  raw.stamp = header.stamp;
  raw.angle_min = reader.Read<float>();
  raw.angle_max = reader.Read<float>();
  raw.angle_increment = reader.Read<float>();
  raw.time_increment = reader.Read<float>();
  reader.Read<float>();  // time between scans
  raw.range_min = reader.Read<float>();
  raw.range_max = reader.Read<float>();
  const auto ReadRanges = topic.type.ends_with("/MultiEchoLaserScan") ? &ReadFirstEchoes : &ReadFloats;
  raw.ranges = ReadRanges(reader);
  ReadRanges(reader);  // intensities
  if (!message->IsWhole()) return {{}, kMalformed};
  DecodedScan decoded = MakeScan(std::move(raw), parameters);
  decoded.frame = std::move(header.frame);
  return decoded;
}

/// Nothing if it is no number.
std::optional<double> FindNumber(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

/// JSON has no words for what is no number: null and the words of several writers stand for it.
std::optional<std::vector<float>> FindRanges(const Json& json) {
  const auto found = json.find("ranges");
  if (found == json.end() || !found->is_array()) return std::nullopt;
  std::vector<float> ranges;
  for (const Json& range : *found) {
    if (!range.is_number() && !range.is_null() && !range.is_string()) return std::nullopt;
    const double range_m = range.is_number() ? range.get<double>() : 0.0;
    constexpr double kLargest = std::numeric_limits<float>::max();
    ranges.push_back(std::abs(range_m) <= kLargest ? static_cast<float>(range_m) : 0.0f);
  }
  return ranges;
}

/// foxglove.LaserScan. It knows neither a laser's range nor the time of a sweep.
DecodedScan DecodeJsonScan(std::string_view data, const ScanParameters& parameters) {
  const Json json = Json::parse(data, nullptr, false);
  if (!json.is_object() || !json.contains("timestamp") || !json["timestamp"].is_object()) return {{}, kMalformed};
  const auto sec = FindNumber(json["timestamp"], "sec");
  const auto nsec = FindNumber(json["timestamp"], "nsec");
  const auto start_rad = FindNumber(json, "start_angle");
  const auto end_rad = FindNumber(json, "end_angle");
  auto ranges = FindRanges(json);
  const auto is_time = [](double value) { return value >= 0.0 && value < 1e10; };
  if (!sec || !nsec || !start_rad || !end_rad || !ranges || !is_time(*sec) || !is_time(*nsec)) return {{}, kMalformed};
  constexpr double kMostAngle_rad = 1e6;
  if (!(std::abs(*start_rad) <= kMostAngle_rad && std::abs(*end_rad) <= kMostAngle_rad)) return {{}, kMalformed};
  RosScan raw;
  raw.stamp = {static_cast<std::int64_t>(*sec), static_cast<std::int64_t>(*nsec)};
  raw.angle_min = static_cast<float>(*start_rad);
  const double num_steps = ranges->empty() ? 1.0 : std::max(1.0, static_cast<double>(ranges->size() - 1));
  raw.angle_increment = static_cast<float>((*end_rad - *start_rad) / num_steps);
  raw.angle_max = static_cast<float>(*end_rad);
  raw.ranges = std::move(*ranges);
  DecodedScan decoded = MakeScan(std::move(raw), parameters);
  if (const auto frame = json.find("frame_id"); frame != json.end() && frame->is_string()) {
    decoded.frame = frame->get<std::string>();
  }
  return decoded;
}

struct Kind {
  const char* encoding;
  const char* type;
};
constexpr std::array<Kind, 5> kLasers{{{"ros1", "sensor_msgs/LaserScan"},
                                       {"ros1", "sensor_msgs/MultiEchoLaserScan"},
                                       {"cdr", "sensor_msgs/msg/LaserScan"},
                                       {"cdr", "sensor_msgs/msg/MultiEchoLaserScan"},
                                       {"json", "foxglove.LaserScan"}}};
constexpr std::array<Kind, 2> kOdometries{{{"ros1", "nav_msgs/Odometry"}, {"cdr", "nav_msgs/msg/Odometry"}}};
constexpr std::array<Kind, 2> kPoses{{{"ros1", "geometry_msgs/PoseStamped"}, {"cdr", "geometry_msgs/msg/PoseStamped"}}};

template <class Kinds>
bool IsOneOf(const Kinds& kinds, const BagTopic& topic) {
  return std::any_of(kinds.begin(), kinds.end(),
                     [&](const Kind& kind) { return topic.encoding == kind.encoding && topic.type == kind.type; });
}

}  // namespace

bool IsLaserTopic(const BagTopic& topic) { return IsOneOf(kLasers, topic); }
bool IsOdometryTopic(const BagTopic& topic) { return IsOneOf(kOdometries, topic); }
bool IsPoseTopic(const BagTopic& topic) { return IsOdometryTopic(topic) || IsOneOf(kPoses, topic); }

std::string LaserTopicTypes() {
  std::vector<std::string> names;
  for (const Kind& kind : kLasers) names.push_back(fmt::format("{} in {}", kind.type, kind.encoding));
  return fmt::format("{}", fmt::join(names, ", "));
}

DecodedScan DecodeScan(const BagTopic& topic, std::string_view data, const ScanParameters& parameters) {
  return topic.encoding == "json" ? DecodeJsonScan(data, parameters) : DecodeRosScan(topic, data, parameters);
}

std::optional<RobotOdometry> DecodeOdometry(const BagTopic& topic, std::string_view data) {
  auto message = OpenMessage(topic, data);
  if (!message) return std::nullopt;
  const RosTime stamp = ReadHeader(*message).stamp;
  ByteReader& reader = message->reader;
  const bool is_odometry = IsOdometryTopic(topic);
  RobotOdometry odometry;
  if (is_odometry) odometry.robot_frame = ReadFrame(reader);
  bot_core::pose_t pose{};
  pose.utime = ToUtime(stamp);
  for (double& coordinate : pose.pos) coordinate = reader.Read<double>();
  auto& [w, x, y, z] = pose.orientation;
  for (double* part : {&x, &y, &z, &w}) *part = reader.Read<double>();
  constexpr std::size_t kRestBytes = (36 + 6 + 36) * sizeof(double);  // covariance, speeds and theirs
  if (is_odometry) reader.Take(kRestBytes);
  if (!message->IsWhole() || stamp.nanosec >= kRosSecond_ns || !ValuesInRange(pose)) return std::nullopt;
  odometry.sample = FromMessage(pose);
  return odometry;
}

}  // namespace crsm
