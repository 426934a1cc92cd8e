#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace crsm {

// The events of an LCM log as lcm-logger writes them: sync word, number, time, lengths, channel, data.

/// As the decoders of messages take it.
inline std::span<const std::uint8_t> Bytes(std::string_view data) {
  return {reinterpret_cast<const std::uint8_t*>(data.data()), data.size()};
}

/// With which each event begins.
inline constexpr std::string_view kLcmSync = "\xED\xA1\xDA\x01";

/// Whether an LCM event begins anywhere in `bytes`.
bool HasLcmSync(std::string_view bytes);

/// Where the first one begins; npos if none does.
std::size_t FindLcmSync(std::string_view bytes);
inline constexpr std::size_t kLcmSyncBytes = kLcmSync.size();

inline constexpr std::size_t kEventHeaderBytes = 28;

/// How long an event is, by its header.
struct EventExtent {
  std::size_t channel_bytes = 0;
  std::size_t data_bytes = 0;
  std::size_t size() const { return kEventHeaderBytes + channel_bytes + data_bytes; }
};

/// Of the event that begins `bytes`; nothing if that is no whole header.
std::optional<EventExtent> ReadEventHeader(std::string_view bytes);

/// When it was recorded [us], of the event that begins `bytes` with a whole header.
std::int64_t ReadEventUtime(std::string_view bytes);

struct EventHeader {
  std::int64_t number = 0;
  std::int64_t utime = 0;  ///< when it is played [us]
  std::string_view channel;
};

/// Appends all of an event but its data, which is to follow.
void AppendEventHeader(const EventHeader& header, std::size_t data_bytes, std::string& bytes);

/// The `count` bytes from `at` on as one number, high byte first; count <= 8, and all of them are there.
std::uint64_t ReadBigEndian(std::string_view bytes, std::size_t at, std::size_t count);

}  // namespace crsm
