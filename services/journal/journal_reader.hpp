#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"
#include "services/base/file_window.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// What was kept in a journal at once.
struct JournalStretch {
  std::optional<journal_head_t> head;  ///< in the first one
  std::optional<CriticalRays> scan;    ///< if it was drawn
  std::optional<ScanMatch> match;
  std::optional<pose_graph_t> graph;
  std::optional<kept_mark_t> mark;
  std::optional<fleet_keyframe_t> fleet_keyframe;
  std::optional<fleet_marks_t> fleet_marks;
  /// Of no session that ended in order.
  bool HasContent() const { return match || graph || mark || fleet_keyframe || fleet_marks; }
};

/// Reads a journal stretch by stretch, each only if its checksum holds and it is the one that belongs there.
class JournalReader {
 public:
  /// Throws std::runtime_error if there is no such file.
  explicit JournalReader(const std::string& path) : file_(path) {}

  /// The next stretch; nothing where the file ends, or where something else begins than a whole stretch. Throws
  /// std::runtime_error if the disk does not give it back.
  std::optional<JournalStretch> Next();

  std::uint64_t whole_bytes() const { return whole_bytes_; }  ///< of the stretches given
  std::int64_t num_events() const { return num_events_; }     ///< in them
  std::int64_t last_utime() const { return last_utime_; }     ///< the largest in them [us]; 0 before the first
  bool ended_in_order() const { return ended_in_order_; }     ///< the last of them is the end of a session
  std::uint64_t size() const { return file_.size(); }

  /// What follows the whole stretches.
  struct Rest {
    std::int64_t num_stretches = 0;  ///< that are whole, but not in their place or behind one that is not whole
    bool was_on_disk = false;  ///< one of them tells that its beginning had reached the disk: no power cut tore it
    bool is_of_other_types = false;  ///< it begins with a whole stretch of message types that are not today's
    bool all_zero = true;            ///< nothing but zeros, as a file system leaves what it did not come to write
  };
  Rest ExamineRest();

  /// The beginning of the file, however whole it is.
  std::string_view Start(std::size_t count) { return file_.At(0, count); }

 private:
  struct Event {
    std::string_view channel;
    std::string_view data;
    std::size_t size = 0;  ///< of all of it, in the file
  };
  std::optional<Event> EventAt(std::uint64_t offset);
  std::optional<journal_check_t> CheckAt(std::uint64_t offset);
  bool IsNextOfOtherTypes();
  bool TakeEvent(const Event& event, JournalStretch& stretch) const;

  FileWindow file_;
  std::uint64_t whole_bytes_ = 0;
  std::int64_t num_events_ = 0;
  std::int64_t last_utime_ = 0;
  bool ended_in_order_ = true;
};

/// Bytes at the end of a journal_check_t that its checksum does not cover: itself.
inline constexpr std::size_t kCrcBytes = 4;

}  // namespace crsm
