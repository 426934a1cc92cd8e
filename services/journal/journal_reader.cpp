#include "services/journal/journal_reader.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "common/logs/crc32.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/lcm_event.hpp"

namespace crsm {
namespace {

/// A scan of 4096 beams makes 41 KB, its match and the head 8 KB.
constexpr std::size_t kMostStretchBytes = std::size_t{1} << 17;

/// By its type alone.
bool IsOfJournal(std::span<const std::uint8_t> bytes) {
  return Is<journal_head_t>(bytes) || Is<critical_rays_t>(bytes) || Is<scan_match_t>(bytes) ||
         Is<pose_graph_t>(bytes) || Is<kept_mark_t>(bytes) || Is<fleet_keyframe_t>(bytes) || Is<fleet_marks_t>(bytes);
}

}  // namespace

/// By its header alone.
std::optional<JournalReader::Event> JournalReader::EventAt(std::uint64_t offset) {
  const std::optional<EventExtent> extent = ReadEventHeader(file_.At(offset, kEventHeaderBytes));
  if (!extent || extent->size() > kMostStretchBytes) return std::nullopt;
  const std::string_view bytes = file_.At(offset, extent->size());
  if (bytes.size() < extent->size()) return std::nullopt;
  return Event{bytes.substr(kEventHeaderBytes, extent->channel_bytes),
               bytes.substr(kEventHeaderBytes + extent->channel_bytes), extent->size()};
}

/// The check that begins at `offset`, if its checksum holds for the stretch before it.
std::optional<journal_check_t> JournalReader::CheckAt(std::uint64_t offset) {
  const auto event = EventAt(offset);
  if (!event || event->channel != kJournalCheckChannel) return std::nullopt;
  const std::size_t event_bytes = event->size;
  const auto check = Decode<journal_check_t>(Bytes(event->data));
  if (!check) return std::nullopt;
  const auto num_bytes = static_cast<std::uint64_t>(check->num_bytes);
  if (num_bytes > kMostStretchBytes || num_bytes > offset) return std::nullopt;
  const std::size_t covered = static_cast<std::size_t>(num_bytes) + event_bytes - kCrcBytes;
  const std::string_view bytes = file_.At(offset - num_bytes, covered);
  if (bytes.size() < covered || Crc32(bytes) != static_cast<std::uint32_t>(check->crc)) return std::nullopt;
  return check;
}

bool JournalReader::TakeEvent(const Event& event, JournalStretch& stretch) const {
  const bool is_whole = stretch.HasContent();
  const bool first = num_events_ == 0 && !stretch.head && !stretch.scan && !is_whole;
  if (first) return (stretch.head = Decode<journal_head_t>(Bytes(event.data))).has_value();
  if (is_whole) return false;
  if (auto keyframe = Decode<fleet_keyframe_t>(Bytes(event.data))) {
    stretch.fleet_keyframe = std::move(keyframe);
    return !stretch.scan;
  }
  if (auto marks = Decode<fleet_marks_t>(Bytes(event.data))) {
    stretch.fleet_marks = std::move(marks);
    return !stretch.scan;
  }
  if (auto mark = Decode<kept_mark_t>(Bytes(event.data))) {
    stretch.mark = std::move(mark);
    return !stretch.scan;
  }
  if (const auto match = Decode<scan_match_t>(Bytes(event.data))) {
    stretch.match = FromMessage(*match);
    return !stretch.scan || stretch.scan->utime == match->utime;
  }
  if (auto graph = Decode<pose_graph_t>(Bytes(event.data))) {
    stretch.graph = std::move(graph);
    return !stretch.scan;
  }
  const auto rays = Decode<critical_rays_t>(Bytes(event.data));
  if (!rays || stretch.scan) return false;
  stretch.scan = FromMessage(*rays);
  return true;
}

std::optional<JournalStretch> JournalReader::Next() {
  JournalStretch stretch;
  std::uint64_t at = whole_bytes_;
  for (std::int64_t num_events = 1; at - whole_bytes_ <= kMostStretchBytes; ++num_events) {
    const auto event = EventAt(at);
    if (!event) return std::nullopt;
    if (event->channel != kJournalCheckChannel) {
      at += event->size;
      if (!TakeEvent(*event, stretch)) return std::nullopt;
      continue;
    }
    const std::uint64_t end = at + event->size;
    const auto check = CheckAt(at);
    const bool in_place =
        check && std::cmp_equal(check->first_byte, whole_bytes_) && std::cmp_equal(check->num_bytes, at - whole_bytes_);
    if (!in_place || (stretch.scan && !stretch.match)) return std::nullopt;
    whole_bytes_ = end;
    num_events_ += num_events;
    last_utime_ = std::max(last_utime_, check->utime);
    ended_in_order_ = !stretch.HasContent();
    return stretch;
  }
  return std::nullopt;
}

/// Whether the next stretch is as it was written, with a message of a type that is not one of today's.
bool JournalReader::IsNextOfOtherTypes() {
  std::uint64_t at = whole_bytes_;
  bool has_other = false;
  auto event = EventAt(at);
  for (; event && event->channel != kJournalCheckChannel; event = EventAt(at)) {
    has_other = has_other || !IsOfJournal(Bytes(event->data));
    at += event->size;
    if (at - whole_bytes_ > kMostStretchBytes) return false;
  }
  const auto check = event ? CheckAt(at) : std::nullopt;
  return has_other && check && std::cmp_equal(check->first_byte, whole_bytes_) &&
         std::cmp_equal(check->num_bytes, at - whole_bytes_);
}

JournalReader::Rest JournalReader::ExamineRest() {
  constexpr std::size_t kPieceBytes = 4096;
  Rest rest;
  rest.is_of_other_types = IsNextOfOtherTypes();
  std::uint64_t at = whole_bytes_;
  while (at < size()) {
    const std::string_view ahead = file_.At(at, kPieceBytes);
    if (ahead.empty()) break;  // it was cut off meanwhile
    const std::size_t sync = FindLcmSync(ahead);
    const std::size_t passed = sync != std::string_view::npos ? sync
                               : at + ahead.size() >= size()  ? ahead.size()
                                                              : ahead.size() - kLcmSyncBytes + 1;
    const std::string_view without_sync = ahead.substr(0, passed);
    rest.all_zero = rest.all_zero && without_sync.find_first_not_of('\0') == std::string_view::npos;
    at += passed;
    if (sync == std::string_view::npos) continue;
    rest.all_zero = false;
    if (const auto check = CheckAt(at)) {
      ++rest.num_stretches;
      rest.was_on_disk = rest.was_on_disk || std::cmp_greater(check->synced_bytes, whole_bytes_);
    }
    ++at;
  }
  return rest;
}

}  // namespace crsm
