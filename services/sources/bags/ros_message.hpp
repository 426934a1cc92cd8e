#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "services/sources/bags/bag_reader.hpp"
#include "services/sources/bags/byte_reader.hpp"
#include "services/wire/ros_scan.hpp"

namespace crsm {

/// A message of ROS 1 or ROS 2. Both have the same fields and differ in what is around them.
struct RosMessage {
  ByteReader reader;
  bool has_sequence = false;     ///< before the stamp of a header
  std::size_t most_padding = 0;  ///< bytes that may follow

  bool IsWhole() const { return reader.ok() && reader.left() <= most_padding; }
};

/// Nothing if it is neither plain CDR nor of ROS 1.
std::optional<RosMessage> OpenMessage(const BagTopic& topic, std::string_view data);

/// std_msgs/Header.
struct RosHeader {
  RosTime stamp;
  std::string frame;
};
RosHeader ReadHeader(RosMessage& message);

/// The name of a frame, without the '/' that TF once had before it and without the NUL of CDR behind it.
std::string ReadFrame(ByteReader& reader);

}  // namespace crsm
