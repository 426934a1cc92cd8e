#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "scratch.hpp"
#include "services/journal/journal.hpp"
#include "synthetic_scans.hpp"

namespace crsm {

namespace fs = std::filesystem;

inline const JournalSubject kMapping{false, {{"cell_size_m", "0.05"}, {"join_hits", "true"}}};
constexpr OnDamage kRefuse = OnDamage::kRefuse;
constexpr OnDamage kTakeWhatIsBefore = OnDamage::kTakeWhatIsBefore;

inline CriticalRays Scan(std::int64_t utime) { return RaysOf(ScanRoom({}, utime, 10)); }
inline ScanMatch Match(std::int64_t utime) {
  return {utime, {0.1 * static_cast<double>(utime), 0.0, 0.0}, 0.5, 1, 1, 0, MatchState::kOk};
}

/// What loops have brought up to a keyframe; with more than a thousand, it is kept in several parts.
inline GraphUpdate Update(int keyframe) {
  Random random(static_cast<std::uint64_t>(keyframe));
  GraphUpdate update;
  update.keyframe = {1, keyframe};
  update.previous = KeyframeId{1, keyframe - 7};
  update.closed = {{{0, 2}, {1, keyframe}, {0.5, random.Uniform(-1.0, 1.0), 0.25}}};
  update.moved = {{{1, 0}, {}}};
  for (int i = 0; i <= keyframe; ++i) update.moved[0].poses.push_back({random.Uniform(-9.0, 9.0), 1.0 / 3.0, 0.1});
  return update;
}

/// One entry of a journal: the match of a scan, of which every third one was not drawn, or an update.
struct Entry {
  std::int64_t utime = 0;
  std::optional<GraphUpdate> update = std::nullopt;
  friend bool operator==(const Entry&, const Entry&) = default;
};
using Entries = std::vector<Entry>;

/// Scans of as many utimes, from 100 on.
inline Entries Scans(std::int64_t count) {
  Entries entries;
  for (std::int64_t i = 0; i < count; ++i) entries.push_back({100 + i});
  return entries;
}

inline void Append(Journal& journal, const Entries& entries) {
  for (const auto& [utime, update] : entries) {
    const CriticalRays scan = Scan(utime);
    update ? journal.Append(*update, utime) : journal.Append(utime % 3 == 0 ? nullptr : &scan, Match(utime));
  }
}

/// What a visitor is told is put behind `entries`.
inline VisitJournal NoteIn(Entries& entries) {
  return {[&](const CriticalRays* scan, const ScanMatch& match) {
            CHECK(match == Match(match.utime));
            CHECK((scan != nullptr) == (match.utime % 3 != 0));
            if (scan) CHECK(*scan == Scan(match.utime));
            entries.push_back({match.utime});
          },
          [&](const GraphUpdate& update) {
            entries.push_back({0, update});
            return true;
          }};
}

inline std::string Content(const fs::path& folder) { return BytesOf(folder / "journal.lcm"); }

/// A first session of these entries, which ended in order, or which was killed before the check at its end; what the
/// journal holds then.
inline std::string Keep(const fs::path& folder, const Entries& entries, bool is_killed = false) {
  std::optional<Journal> journal(std::in_place, folder, kMapping);
  Append(*journal, entries);
  const std::string killed = Content(folder);
  journal.reset();
  return is_killed ? killed : Content(folder);
}

/// A later session, which goes on with them.
inline void GoOn(const fs::path& folder, const Entries& entries) {
  Entries before;
  Journal journal(folder, kMapping, kRefuse, NoteIn(before));
  Append(journal, entries);
}

struct JournalRead {
  Entries entries;
  std::string notice;
};

inline JournalRead Read(const fs::path& folder) {
  JournalRead read;
  read.notice = ReadJournal(folder, kMapping, kRefuse, NoteIn(read.entries));
  return read;
}

/// Whether these entries are read, and nothing is said of them.
inline bool Holds(const fs::path& folder, const Entries& entries) {
  const JournalRead read = Read(folder);
  return read.entries == entries && read.notice.empty();
}

}  // namespace crsm
