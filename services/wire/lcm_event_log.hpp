#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/logs/gzip_file.hpp"

namespace crsm {

/// The events of an LCM log, as lcm-logger writes them, plain or compressed by gzip.
///
/// lcm::LogFile believes the lengths in a log and knows no gzip. Here a damaged stretch is passed over to the next
/// whole event: an event counts as whole if another follows it, or the end of the file, or if no other begins inside
/// it.
class LcmEventLog {
 public:
  struct Event {
    std::string channel;
    std::string_view data;  ///< valid until the next call
  };

  /// Throws std::runtime_error if the file cannot be opened.
  explicit LcmEventLog(const std::string& path) : file_(path) {}

  /// The next event in the log's order; nothing at its end. Throws std::runtime_error if the file cannot be read.
  std::optional<Event> Next();

  double Progress() const { return file_.Progress(); }

  std::int64_t num_bad_events() const { return num_bad_events_; }     ///< damaged stretches passed over
  bool truncated() const { return torn_tail_ || file_.truncated(); }  ///< the log ends within an event, or its gzip

 private:
  void SkipToSync();

  GzipFile file_;
  std::int64_t num_bad_events_ = 0;
  bool torn_tail_ = false;
};

/// As the decoders of messages take it.
inline std::span<const std::uint8_t> Bytes(std::string_view data) {
  return {reinterpret_cast<const std::uint8_t*>(data.data()), data.size()};
}

/// Whether an LCM event begins anywhere in `bytes`.
bool HasLcmSync(std::string_view bytes);

/// Where the first one begins; npos if none does.
std::size_t FindLcmSync(std::string_view bytes);
inline constexpr std::size_t kLcmSyncBytes = 4;

inline constexpr std::size_t kEventHeaderBytes = 28;

/// How long an event is, by its header.
struct EventExtent {
  std::size_t channel_bytes = 0;
  std::size_t data_bytes = 0;
  std::size_t size() const { return kEventHeaderBytes + channel_bytes + data_bytes; }
};

/// Of the event that begins `bytes`; nothing if that is no whole header.
std::optional<EventExtent> ReadEventHeader(std::string_view bytes);

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
