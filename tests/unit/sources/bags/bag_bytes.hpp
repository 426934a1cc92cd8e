#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scratch.hpp"

namespace crsm {

// Bags by the book, byte by byte, for what no recorder would write.

/// A number as it lies in memory: the lowest byte first.
template <class Number>
std::string Little(Number number) {
  std::string bytes(sizeof(Number), '\0');
  std::memcpy(bytes.data(), &number, sizeof(Number));
  return bytes;
}

/// Bytes behind their number.
inline std::string Text(std::string_view text) {
  return Little(static_cast<std::uint32_t>(text.size())) + std::string(text);
}

/// sensor_msgs/LaserScan, and what its fields are when a test does not say.
struct LaserMessage {
  std::uint32_t sec = 100;
  std::uint32_t nanosec = 0;
  float angle_min = -1.0f;
  float angle_increment = 0.5f;
  float angle_max = 0.0f;
  float time_increment = 0.0f;
  float range_min = 0.0f;
  float range_max = 10.0f;
  std::vector<float> ranges = {1.0f, 2.0f, 3.0f};
  bool has_echoes = false;    ///< a MultiEchoLaserScan: each range is followed by that of what is behind
  std::string frame = "las";  ///< of three letters: what follows is aligned in CDR with the NUL at its end

  std::string Floats() const {
    std::string bytes;
    for (const float number : {angle_min, angle_max, angle_increment, time_increment, 0.0f, range_min, range_max}) {
      bytes += Little(number);
    }
    bytes += Little(static_cast<std::uint32_t>(ranges.size()));
    for (const float range : ranges) {
      bytes += has_echoes ? Little(2u) + Little(range) + Little(range + 5.0f) : Little(range);
    }
    return bytes + Little(std::uint32_t{0});  // no intensities
  }
  std::string Ros1() const { return Little(7u) + Little(sec) + Little(nanosec) + Text(frame) + Floats(); }
  std::string Cdr() const {
    return std::string("\0\1\0\0", 4) + Little(sec) + Little(nanosec) + Text(frame + '\0') + Floats();
  }
};

using Ros1Fields = std::vector<std::pair<std::string, std::string>>;

inline std::string Ros1Header(const Ros1Fields& fields) {
  std::string bytes;
  for (const auto& [name, value] : fields) bytes += Text(name + "=" + value);
  return bytes;
}
inline std::string Ros1Record(const Ros1Fields& fields, const std::string& data) {
  return Text(Ros1Header(fields)) + Text(data);
}
inline std::string Ros1Connection(std::uint32_t number, const std::string& topic,
                                  const std::string& type = "sensor_msgs/LaserScan") {
  return Ros1Record({{"op", "\x07"}, {"conn", Little(number)}, {"topic", topic}},
                    Ros1Header({{"topic", topic}, {"type", type}}));
}
inline std::string Ros1Message(std::uint32_t number, const std::string& data) {
  return Ros1Record({{"op", "\x02"}, {"conn", Little(number)}, {"time", Little(std::uint64_t{0})}}, data);
}
inline std::string Ros1Chunk(const std::string& records, const std::string& compression, std::uint32_t size) {
  return Ros1Record({{"op", "\x05"}, {"compression", compression}, {"size", Little(size)}}, records);
}
inline std::string Ros1Start(std::uint64_t index_at) {
  return "#ROSBAG V2.0\n" +
         Ros1Record({{"op", "\x03"}, {"index_pos", Little(index_at)}, {"conn_count", Little(0u)}}, "");
}
/// A bag without an index, of a recording that was killed.
inline std::string Ros1Bytes(const std::string& records) { return Ros1Start(0) + records; }

inline std::string McapRecord(std::uint8_t opcode, const std::string& content) {
  return Little(opcode) + Little(std::uint64_t{content.size()}) + content;
}
inline std::string McapChannel(std::uint16_t number, const std::string& topic) {
  return McapRecord(0x03, Little(std::uint16_t{1}) + Text("sensor_msgs/msg/LaserScan") + Text("ros2msg") + Text("")) +
         McapRecord(0x04, Little(number) + Little(std::uint16_t{1}) + Text(topic) + Text("cdr") + Text(""));
}
inline std::string McapMessage(std::uint16_t channel, const std::string& data) {
  return McapRecord(0x05, Little(channel) + std::string(20, '\0') + data);
}
inline std::string McapChunk(const std::string& records, const std::string& compression, std::uint64_t size,
                             std::uint32_t crc = 0) {
  return McapRecord(0x06, std::string(16, '\0') + Little(size) + Little(crc) + Text(compression) +
                              Little(std::uint64_t{records.size()}) + records);
}
/// A file that ends in order, without a summary.
inline std::string McapBytes(const std::string& records) {
  const std::string magic("\x89MCAP0\r\n", 8);
  return magic + McapRecord(0x01, Text("") + Text("")) + records + McapRecord(0x0f, Little(0u)) +
         McapRecord(0x02, std::string(20, '\0')) + magic;
}

/// A file of tests/bags/data, which others' programs have written.
inline std::string DataPath(const std::string& name) { return CRSM_SOURCE_DIR "/tests/bags/data/" + name; }
inline std::string DataBytes(const std::string& name) { return BytesOf(DataPath(name)); }

}  // namespace crsm
