#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// The `count` low bytes of a number, high byte first.
inline std::string BigEndian(std::uint64_t value, int count) {
  std::string bytes;
  for (int i = count - 1; i >= 0; --i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
  return bytes;
}

/// The bytes of a message, as they stand in an event.
template <class Message>
std::string DataOf(const Message& message) {
  std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// An event of an LCM log.
inline std::string Event(const std::string& channel, const std::string& data, std::int64_t recorded_utime = 0) {
  return BigEndian(0xEDA1DA01, 4) + BigEndian(0, 8) + BigEndian(static_cast<std::uint64_t>(recorded_utime), 8) +
         BigEndian(channel.size(), 4) + BigEndian(data.size(), 4) + channel + data;
}

}  // namespace crsm
