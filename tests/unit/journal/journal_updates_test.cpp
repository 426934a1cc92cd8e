#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "journal/journal_folder.hpp"
#include "services/base/crc32.hpp"
#include "services/journal/journal.hpp"
#include "services/journal/journal_reader.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

constexpr OnDamage kRefuse = OnDamage::kRefuse;

/// What loops have brought up to a keyframe; with more than a thousand, it is kept in several parts.
GraphUpdate Update(int keyframe) {
  Random random(static_cast<std::uint64_t>(keyframe));
  GraphUpdate update;
  update.keyframe = {1, keyframe};
  update.previous = KeyframeId{1, keyframe - 7};
  update.closed = {{{0, 2}, {1, keyframe}, {0.5, random.Uniform(-1.0, 1.0), 0.25}}};
  update.moved = {{{1, 0}, {}}};
  for (int i = 0; i <= keyframe; ++i) update.moved[0].poses.push_back({random.Uniform(-9.0, 9.0), 1.0 / 3.0, 0.1});
  return update;
}

/// One entry of a journal: the match of a scan, or an update.
struct Entry {
  std::int64_t utime = 0;
  std::optional<GraphUpdate> update = std::nullopt;
  friend bool operator==(const Entry&, const Entry&) = default;
};
using Entries = std::vector<Entry>;

void Append(Journal& journal, const Entries& entries) {
  for (const auto& [utime, update] : entries) {
    const CriticalRays scan = Scan(utime);
    update ? journal.Append(*update, utime) : journal.Append(&scan, Match(utime));
  }
}

/// What a visitor is told.
VisitJournal NoteIn(Entries& entries) {
  return {[&](const CriticalRays* scan, const ScanMatch& match) {
            REQUIRE(scan);
            CHECK(*scan == Scan(match.utime));
            entries.push_back({match.utime});
          },
          [&](const GraphUpdate& update) {
            entries.push_back({0, update});
            return true;
          }};
}

/// What is read; `notice` gets what is said of it.
Entries Read(const fs::path& folder, std::string& notice) {
  Entries entries;
  notice = ReadJournal(folder, kMapping, kRefuse, NoteIn(entries));
  return entries;
}

/// Where the events of a journal end [bytes].
std::vector<std::size_t> EndsOfEvents(const fs::path& path) {
  lcm::LogFile log(path.string(), "r");
  std::vector<std::size_t> ends;
  std::size_t at = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    at += 28 + event->channel.size() + static_cast<std::size_t>(event->datalen);
    ends.push_back(at);
  }
  REQUIRE(at == fs::file_size(path));
  return ends;
}

/// A journal in which an event has another type than today, and the check behind it is right.
std::string WithOtherType(std::string content, const std::vector<std::size_t>& ends, std::size_t first_of_stretch,
                          std::size_t event, std::size_t check) {
  const auto BeginOf = [&](std::size_t index) { return index == 0 ? 0 : ends[index - 1]; };
  constexpr std::size_t kChannelBytesAt = 20;
  const auto channel_bytes = static_cast<std::size_t>(content[BeginOf(event) + kChannelBytesAt + 3]);
  content[BeginOf(event) + 28 + channel_bytes] ^= 1;  // its fingerprint
  const std::size_t end = ends[check] - kCrcBytes;
  const std::uint32_t crc =
      Crc32(std::string_view(content).substr(BeginOf(first_of_stretch), end - BeginOf(first_of_stretch)));
  for (std::size_t i = 0; i < kCrcBytes; ++i) content[end + i] = static_cast<char>(crc >> (24 - 8 * i) & 0xff);
  return content;
}

}  // namespace

TEST_CASE("a journal of an older version is refused by name and stays as it is, also where damage may be passed over") {
  const Folder folder;
  {
    Journal journal(folder / "new", kMapping);
    Append(journal, {{100}, {0, Update(30)}, {101}});
  }
  const std::string content = Content(folder / "new/journal.lcm");
  const auto ends = EndsOfEvents(folder / "new/journal.lcm");
  REQUIRE(ends.size() == 4 + 2 + 3 + 1);
  struct Event {
    std::size_t first_of_stretch, event, check;
  };
  // The head, the rays and the match of the first stretch, and the update in the second one.
  for (const auto& [first, event, check] : {Event{0, 0, 3}, {0, 1, 3}, {0, 2, 3}, {4, 4, 5}}) {
    CAPTURE(event);
    const std::string old = WithOtherType(content, ends, first, event, check);
    fs::create_directories(folder / "old");
    Write(folder / "old/journal.lcm", old);
    for (const OnDamage on_damage : {kRefuse, OnDamage::kTakeWhatIsBefore}) {
      Entries entries;
      const std::string error = ErrorOf([&] { Journal(folder / "old", kMapping, on_damage, NoteIn(entries)); });
      CHECK(error == (folder / "old/journal.lcm").string() +
                         ": journal of an older version of the programs: map the log anew, into another folder");
    }
    CHECK(Content(folder / "old/journal.lcm") == old);
  }
}

TEST_CASE("what loops have brought comes back in its place between the matches, over several sessions") {
  const Folder folder;
  std::string notice;
  const Entries first{{100}, {101}, {0, Update(30)}, {102}, {0, Update(2499)}, {0, Update(2506)}, {103}};
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, first);
  }
  CHECK(Read(folder / "a", notice) == first);
  CHECK(notice.empty());
  const Entries second{{0, Update(2600)}, {104}, {0, Update(2700)}};
  Entries all;
  {
    Journal journal(folder / "a", kMapping, kRefuse, NoteIn(all));
    CHECK(all == first);
    Append(journal, second);
  }
  all.insert(all.end(), second.begin(), second.end());
  CHECK(Read(folder / "a", notice) == all);
  CHECK(notice.empty());
}

TEST_CASE("a session that kept nothing but what loops have brought ends in order") {
  const Folder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {{100}});
  }
  {
    Entries entries;
    Journal journal(folder / "a", kMapping, kRefuse, NoteIn(entries));
    Append(journal, {{0, Update(30)}});
  }
  std::string notice;
  CHECK(Read(folder / "a", notice) == Entries{{100}, {0, Update(30)}});
  CHECK(notice.empty());
}

TEST_CASE("an LCM log shows each part of what loops have brought, and time does not go back there") {
  const Folder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {{100}, {90, Update(2499)}, {101}});
  }
  lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
  std::vector<std::string> channels;
  std::int64_t utime = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    CHECK(event->timestamp >= std::exchange(utime, event->timestamp));
    CHECK(event->eventnum == static_cast<std::int64_t>(channels.size()));
    channels.push_back(event->channel);
  }
  CHECK(channels == std::vector<std::string>{"JOURNAL_HEAD", "CRITICAL_RAYS", "SCAN_MATCH", "JOURNAL_CHECK",
                                             "POSE_GRAPH", "JOURNAL_CHECK", "POSE_GRAPH", "JOURNAL_CHECK", "POSE_GRAPH",
                                             "JOURNAL_CHECK", "CRITICAL_RAYS", "SCAN_MATCH", "JOURNAL_CHECK",
                                             "JOURNAL_CHECK"});
}

TEST_CASE("a journal says up to which keyframe loops were searched, at once or a few scans later") {
  const Folder folder;
  struct Told {
    std::vector<KeyframeId> searched;
    int num_scans = 0;
  };
  const auto ReadTold = [&](const char* name) {
    Told told;
    ReadJournal(
        folder / name, kMapping, kRefuse,
        {[&](const CriticalRays*, const ScanMatch&) { ++told.num_scans; }, [](const GraphUpdate&) { return true; },
         [&](KeyframeId keyframe) {
           told.searched.push_back(keyframe);
           return true;
         }});
    return told;
  };
  {
    Journal journal(folder / "a", kMapping);
    for (int i = 0; i < 35; ++i) {
      const CriticalRays scan = Scan(100 + i);
      journal.Append(&scan, Match(100 + i));
      journal.AppendSearched({0, i}, {}, 100 + i);
      const auto told = ReadTold("a").searched;  // as if it were killed now
      CHECK((told.empty() ? 0 : told.back().number + 1) == (i + 1) / 10 * 10);
    }
  }
  CHECK(ReadTold("a").searched == std::vector<KeyframeId>{{0, 9}, {0, 19}, {0, 29}, {0, 34}});
  const std::string before = Content(folder / "a/journal.lcm");
  {
    Entries entries;
    Journal journal(folder / "a", kMapping, kRefuse, NoteIn(entries));
    journal.AppendSearched({0, 34}, {}, 134);  // which it says already
  }
  CHECK(Content(folder / "a/journal.lcm") == before);
  {
    Entries entries;
    Journal journal(folder / "a", kMapping, kRefuse, NoteIn(entries));
    GraphUpdate update;
    update.keyframe = {0, 33};
    update.finding = LoopFinding{{0, 2}, {0, 33}, {0.5, 1.0 / 3.0, 0.1}, 0.75, LoopFinding::By::kCheck};
    journal.Append(update, 133);
    journal.AppendSearched({0, 33}, KeyframeId{0, 33}, 133);  // which the update says
  }
  std::string notice;
  const Entries entries = Read(folder / "a", notice);
  CHECK(notice.empty());
  REQUIRE(entries.back().update);
  CHECK(entries.back().update->finding->T_older_newer == Pose2{0.5, 1.0 / 3.0, 0.1});
  CHECK(ReadTold("a").searched.size() == 4);
}

TEST_CASE("a journal that was searched up to a keyframe that it does not have is an error that names the file") {
  const Folder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {{100}});
    journal.AppendSearched({0, 0}, {}, 100);
  }
  const VisitJournal refuse{[](const CriticalRays*, const ScanMatch&) {}, [](const GraphUpdate&) { return true; },
                            [](KeyframeId) { return false; }};
  CHECK(ErrorOf([&] { ReadJournal(folder / "a", kMapping, kRefuse, refuse); }) ==
        (folder / "a/journal.lcm").string() + ": its loop closures do not fit its scans");
}

TEST_CASE("a session that was killed amid the parts of an update loses that one alone, and the next goes on") {
  const Folder folder;
  {
    Journal journal(folder / "whole", kMapping);
    Append(journal, {{100}, {0, Update(30)}, {0, Update(2499)}});
  }
  const std::string whole = Content(folder / "whole/journal.lcm");
  const auto ends = EndsOfEvents(folder / "whole/journal.lcm");
  REQUIRE(ends.size() == 4 + 2 + 3 * 2 + 1);
  const std::size_t first_part = 6;  // events before it
  // The same update is found again; or, by other parameters than then, another one.
  const int found = GENERATE(2499, 2700);
  for (std::size_t num_events = first_part; num_events < first_part + 5; ++num_events) {
    for (const std::size_t more_bytes : {0, 100}) {
      CAPTURE(num_events, more_bytes);
      fs::create_directories(folder / "cut");
      Write(folder / "cut/journal.lcm", whole.substr(0, ends[num_events - 1] + more_bytes));
      Entries entries;
      {
        Journal journal(folder / "cut", kMapping, kRefuse, NoteIn(entries));
        CHECK(entries == Entries{{100}, {0, Update(30)}});
        CHECK_FALSE(journal.notice().empty());
        Append(journal, {{101}, {0, Update(found)}, {102}});
      }
      std::string notice;
      CHECK(Read(folder / "cut", notice) == Entries{{100}, {0, Update(30)}, {101}, {0, Update(found)}, {102}});
      CHECK(notice.empty());
      fs::remove_all(folder / "cut");
    }
  }
}

TEST_CASE("an update that does not fit the scans is an error that names the file, which stays as it is") {
  const Folder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {{100}, {0, Update(30)}, {101}});
  }
  const std::string before = Content(folder / "a/journal.lcm");
  const VisitJournal refuse{[](const CriticalRays*, const ScanMatch&) {}, [](const GraphUpdate&) { return false; }};
  for (const OnDamage on_damage : {kRefuse, OnDamage::kTakeWhatIsBefore}) {
    const std::string error = ErrorOf([&] { ReadJournal(folder / "a", kMapping, on_damage, refuse); });
    CHECK(error == (folder / "a/journal.lcm").string() + ": its loop closures do not fit its scans");
    CHECK(ErrorOf([&] { Journal(folder / "a", kMapping, on_damage, refuse); }) == error);
  }
  CHECK(Content(folder / "a/journal.lcm") == before);
}

TEST_CASE("who does not ask for what loops have brought reads the matches alone") {
  const Folder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {{100}, {0, Update(30)}, {101}});
  }
  std::vector<std::int64_t> utimes;
  const VisitJournal visit{[&](const CriticalRays*, const ScanMatch& match) { utimes.push_back(match.utime); }};
  CHECK(ReadJournal(folder / "a", kMapping, kRefuse, visit).empty());
  CHECK(utimes == std::vector<std::int64_t>{100, 101});
}

}  // namespace crsm
