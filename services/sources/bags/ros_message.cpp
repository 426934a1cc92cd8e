#include "services/sources/bags/ros_message.hpp"

namespace crsm {

std::optional<RosMessage> OpenMessage(const BagTopic& topic, std::string_view data) {
  if (topic.encoding == "ros1") return RosMessage{ByteReader(data), true, 0};
  constexpr std::size_t kHeadBytes = 4;
  if (data.size() < kHeadBytes || data[0] != 0 || (data[1] != 0 && data[1] != 1)) return std::nullopt;  // plain CDR
  return RosMessage{ByteReader(data.substr(kHeadBytes), {true, data[1] == 0}), false, 7};
}

RosHeader ReadHeader(RosMessage& message) {
  ByteReader& reader = message.reader;
  RosHeader header;
  if (message.has_sequence) {
    reader.Read<std::uint32_t>();
    header.stamp.sec = reader.Read<std::uint32_t>();
  } else {
    header.stamp.sec = reader.Read<std::int32_t>();
  }
  header.stamp.nanosec = reader.Read<std::uint32_t>();
  header.frame = ReadFrame(reader);
  return header;
}

std::string ReadFrame(ByteReader& reader) {
  std::string_view frame = reader.Text();
  if (frame.ends_with('\0')) frame.remove_suffix(1);
  if (frame.starts_with('/')) frame.remove_prefix(1);
  return std::string(frame);
}

}  // namespace crsm
