#include "services/sources/lcm_event_log.hpp"

#include <algorithm>

namespace crsm {
namespace {

// Sync word, int64 number, int64 timestamp, int32 channel length, int32 data length, all big-endian.
constexpr std::string_view kSync = "\xED\xA1\xDA\x01";
constexpr std::size_t kHeaderBytes = 28;
constexpr std::size_t kChannelLengthAt = 20;
constexpr std::size_t kDataLengthAt = 24;
constexpr std::uint64_t kMaxChannelBytes = 1000;
constexpr std::uint64_t kMaxDataBytes = std::uint64_t{64} << 20;

/// Bytes of the event that begins `bytes`, by its header; nothing if that is no header.
std::optional<std::size_t> EventSize(std::string_view bytes) {
  if (bytes.size() < kHeaderBytes || !bytes.starts_with(kSync)) return std::nullopt;
  const std::uint64_t channel_bytes = ReadBigEndian(bytes, kChannelLengthAt, 4);
  const std::uint64_t data_bytes = ReadBigEndian(bytes, kDataLengthAt, 4);
  if (channel_bytes == 0 || channel_bytes > kMaxChannelBytes || data_bytes > kMaxDataBytes) return std::nullopt;
  return kHeaderBytes + channel_bytes + data_bytes;
}

}  // namespace

std::uint64_t ReadBigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (const char byte : bytes.substr(at, count)) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

bool HasLcmSync(std::string_view bytes) { return bytes.find(kSync) != std::string_view::npos; }

std::optional<LcmEventLog::Event> LcmEventLog::Next() {
  while (true) {
    std::string_view ahead = file_.Peek(kHeaderBytes);
    if (ahead.empty()) return std::nullopt;
    const std::optional<std::size_t> size = EventSize(ahead);
    if (size) {
      ahead = file_.Peek(*size + kSync.size());
      const bool followed = ahead.size() == *size || ahead.substr(std::min(*size, ahead.size())).starts_with(kSync);
      const bool another_inside = !followed && ahead.substr(0, *size).find(kSync, 1) != std::string_view::npos;
      if (!another_inside && ahead.size() >= *size) {
        const std::size_t channel_bytes = ReadBigEndian(ahead, kChannelLengthAt, 4);
        Skip(*size);
        whole_bytes_ = taken_bytes_;
        return Event{std::string(ahead.substr(kHeaderBytes, channel_bytes)),
                     ahead.substr(kHeaderBytes + channel_bytes, *size - kHeaderBytes - channel_bytes)};
      }
      if (!another_inside) {
        torn_tail_ = true;
        Skip(ahead.size());
        return std::nullopt;
      }
    } else if (ahead.size() < kHeaderBytes && ahead.starts_with(kSync.substr(0, ahead.size()))) {
      torn_tail_ = true;
      Skip(ahead.size());
      return std::nullopt;
    }
    ++num_bad_events_;
    SkipToSync();
  }
}

void LcmEventLog::Skip(std::size_t size) {
  file_.Skip(size);
  taken_bytes_ += size;
}

void LcmEventLog::SkipToSync() {
  Skip(1);
  while (true) {
    const std::string_view ahead = file_.Peek(kHeaderBytes);
    const std::size_t sync = ahead.find(kSync);
    if (sync != std::string_view::npos) return Skip(sync);
    // The end of a stretch may be the beginning of a sync word.
    Skip(ahead.size() < kHeaderBytes ? ahead.size() : ahead.size() - kSync.size() + 1);
    if (ahead.size() < kHeaderBytes) return;
  }
}

}  // namespace crsm
