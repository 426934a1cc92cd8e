#include "services/wire/lcm_event_log.hpp"

#include <algorithm>

namespace crsm {
namespace {

// Sync word, int64 number, int64 timestamp, int32 channel length, int32 data length, all big-endian.
constexpr std::string_view kSync = "\xED\xA1\xDA\x01";
static_assert(kSync.size() == kLcmSyncBytes);
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

std::size_t FindLcmSync(std::string_view bytes) { return bytes.find(kSync); }

bool HasLcmSync(std::string_view bytes) { return FindLcmSync(bytes) != std::string_view::npos; }

std::optional<EventExtent> ReadEventHeader(std::string_view bytes) {
  if (bytes.size() < kEventHeaderBytes || !bytes.starts_with(kSync)) return std::nullopt;
  const std::uint64_t channel_bytes = ReadBigEndian(bytes, kChannelLengthAt, 4);
  const std::uint64_t data_bytes = ReadBigEndian(bytes, kDataLengthAt, 4);
  if (channel_bytes == 0 || channel_bytes > kMaxChannelBytes || data_bytes > kMaxDataBytes) return std::nullopt;
  return EventExtent{channel_bytes, data_bytes};
}

void AppendEventHeader(const EventHeader& header, std::size_t data_bytes, std::string& bytes) {
  bytes += kSync;
  AppendBigEndian(static_cast<std::uint64_t>(header.number), 8, bytes);
  AppendBigEndian(static_cast<std::uint64_t>(header.utime), 8, bytes);
  AppendBigEndian(header.channel.size(), 4, bytes);
  AppendBigEndian(data_bytes, 4, bytes);
  bytes += header.channel;
}

std::optional<LcmEventLog::Event> LcmEventLog::Next() {
  while (true) {
    std::string_view ahead = file_.Peek(kEventHeaderBytes);
    if (ahead.empty()) return std::nullopt;
    const std::optional<EventExtent> extent = ReadEventHeader(ahead);
    if (extent) {
      const std::size_t size = extent->size();
      ahead = file_.Peek(size + kSync.size());
      const bool followed = ahead.size() == size || ahead.substr(std::min(size, ahead.size())).starts_with(kSync);
      const bool another_inside = !followed && ahead.substr(0, size).find(kSync, 1) != std::string_view::npos;
      if (!another_inside && ahead.size() >= size) {
        file_.Skip(size);
        return Event{std::string(ahead.substr(kEventHeaderBytes, extent->channel_bytes)),
                     ahead.substr(kEventHeaderBytes + extent->channel_bytes, extent->data_bytes)};
      }
      if (!another_inside) {
        torn_tail_ = true;
        file_.Skip(ahead.size());
        return std::nullopt;
      }
    } else if (ahead.size() < kEventHeaderBytes && ahead.starts_with(kSync.substr(0, ahead.size()))) {
      torn_tail_ = true;
      file_.Skip(ahead.size());
      return std::nullopt;
    }
    ++num_bad_events_;
    SkipToSync();
  }
}

void LcmEventLog::SkipToSync() {
  file_.Skip(1);
  while (true) {
    const std::string_view ahead = file_.Peek(kEventHeaderBytes);
    const std::size_t sync = ahead.find(kSync);
    if (sync != std::string_view::npos) return file_.Skip(sync);
    // The end of a stretch may be the beginning of a sync word.
    file_.Skip(ahead.size() < kEventHeaderBytes ? ahead.size() : ahead.size() - kSync.size() + 1);
    if (ahead.size() < kEventHeaderBytes) return;
  }
}

}  // namespace crsm
