#pragma once

#include <cstdint>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <vector>

#include "services/wire/replay_clock.hpp"

namespace crsm {

/// Writes messages to an LCM log that lcm-logplayer plays at the pace of their own times (ReplayClock). The same
/// messages give the same bytes.
class EventLogWriter {
 public:
  /// Begins a new log. Throws std::runtime_error if it cannot be written.
  explicit EventLogWriter(const std::string& path);

  EventLogWriter(const EventLogWriter&) = delete;  // lcm::LogFile closes its file, and would copy all the same

  /// Throws std::runtime_error if it cannot be written on.
  template <class Message>
  void Write(const std::string& channel, const Message& message) {
    bytes_.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
    WriteBytes(channel, message.utime);
  }

  /// Hands everything to the operating system: it survives the end of the process. Throws as Write.
  void Flush();

 private:
  void WriteBytes(const std::string& channel, std::int64_t utime);
  [[noreturn]] void Fail() const;

  std::string path_;
  lcm::LogFile log_;
  ReplayClock clock_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace crsm
