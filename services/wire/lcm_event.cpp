#include "services/wire/lcm_event.hpp"

namespace crsm {
namespace {

// Sync word, int64 number, int64 timestamp, int32 channel length, int32 data length, all big-endian.
constexpr std::size_t kUtimeAt = 12;
constexpr std::size_t kChannelLengthAt = 20;
constexpr std::size_t kDataLengthAt = 24;
constexpr std::uint64_t kMaxChannelBytes = 1000;
constexpr std::uint64_t kMaxDataBytes = std::uint64_t{64} << 20;

void AppendBigEndian(std::uint64_t value, int count, std::string& bytes) {
  for (int shift = 8 * (count - 1); shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
}

}  // namespace

std::uint64_t ReadBigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (const char byte : bytes.substr(at, count)) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

std::size_t FindLcmSync(std::string_view bytes) { return bytes.find(kLcmSync); }

bool HasLcmSync(std::string_view bytes) { return FindLcmSync(bytes) != std::string_view::npos; }

std::optional<EventExtent> ReadEventHeader(std::string_view bytes) {
  if (bytes.size() < kEventHeaderBytes || !bytes.starts_with(kLcmSync)) return std::nullopt;
  const std::uint64_t channel_bytes = ReadBigEndian(bytes, kChannelLengthAt, 4);
  const std::uint64_t data_bytes = ReadBigEndian(bytes, kDataLengthAt, 4);
  if (channel_bytes == 0 || channel_bytes > kMaxChannelBytes || data_bytes > kMaxDataBytes) return std::nullopt;
  return EventExtent{channel_bytes, data_bytes};
}

std::int64_t ReadEventUtime(std::string_view bytes) {
  return static_cast<std::int64_t>(ReadBigEndian(bytes, kUtimeAt, 8));
}

void AppendEventHeader(const EventHeader& header, std::size_t data_bytes, std::string& bytes) {
  bytes += kLcmSync;
  AppendBigEndian(static_cast<std::uint64_t>(header.number), 8, bytes);
  AppendBigEndian(static_cast<std::uint64_t>(header.utime), 8, bytes);
  AppendBigEndian(header.channel.size(), 4, bytes);
  AppendBigEndian(data_bytes, 4, bytes);
  bytes += header.channel;
}

}  // namespace crsm
