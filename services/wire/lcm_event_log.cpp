#include "services/wire/lcm_event_log.hpp"

#include <algorithm>

namespace crsm {

std::optional<LcmEventLog::Event> LcmEventLog::Next() {
  while (true) {
    std::string_view ahead = file_.Peek(kEventHeaderBytes);
    if (ahead.empty()) return std::nullopt;
    const std::optional<EventExtent> extent = ReadEventHeader(ahead);
    if (extent) {
      const std::size_t size = extent->size();
      ahead = file_.Peek(size + kLcmSync.size());
      const bool followed = ahead.size() == size || ahead.substr(std::min(size, ahead.size())).starts_with(kLcmSync);
      const bool another_inside = !followed && ahead.substr(0, size).find(kLcmSync, 1) != std::string_view::npos;
      if (!another_inside && ahead.size() >= size) {
        file_.Skip(size);
        return Event{std::string(ahead.substr(kEventHeaderBytes, extent->channel_bytes)),
                     ahead.substr(kEventHeaderBytes + extent->channel_bytes, extent->data_bytes),
                     ReadEventUtime(ahead)};
      }
      if (!another_inside) {
        torn_tail_ = true;
        file_.Skip(ahead.size());
        return std::nullopt;
      }
    } else if (ahead.size() < kEventHeaderBytes && ahead.starts_with(kLcmSync.substr(0, ahead.size()))) {
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
    const std::size_t sync = ahead.find(kLcmSync);
    if (sync != std::string_view::npos) return file_.Skip(sync);
    // The end of a stretch may be the beginning of a sync word.
    file_.Skip(ahead.size() < kEventHeaderBytes ? ahead.size() : ahead.size() - kLcmSync.size() + 1);
    if (ahead.size() < kEventHeaderBytes) return;
  }
}

}  // namespace crsm
