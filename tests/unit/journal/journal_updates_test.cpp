#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "catch.hpp"
#include "common/logs/crc32.hpp"
#include "journal/journal_folder.hpp"
#include "services/journal/journal_reader.hpp"

namespace crsm {
namespace {

/// Where the events of a journal end [bytes].
std::vector<std::size_t> EndsOfEvents(const fs::path& folder) {
  lcm::LogFile log((folder / "journal.lcm").string(), "r");
  std::vector<std::size_t> ends;
  std::size_t at = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    at += 28 + event->channel.size() + static_cast<std::size_t>(event->datalen);
    ends.push_back(at);
  }
  REQUIRE(at == Content(folder).size());
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

void WriteJournal(const fs::path& folder, const std::string& content) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "journal.lcm", std::ios::binary) << content;
}

const Entries kShort{{100}, {0, Update(30)}, {101}};

}  // namespace

TEST_CASE("a journal of an older version is refused by name and stays as it is, also where damage may be passed over") {
  const ScratchFolder folder;
  const std::string content = Keep(folder / "new", kShort);
  const auto ends = EndsOfEvents(folder / "new");
  REQUIRE(ends.size() == 4 + 2 + 3 + 1);
  struct Event {
    std::size_t first_of_stretch, event, check;
  };
  // The head, the rays and the match of the first stretch, and the update in the second one.
  for (const auto& [first, event, check] : {Event{0, 0, 3}, {0, 1, 3}, {0, 2, 3}, {4, 4, 5}}) {
    CAPTURE(event);
    const std::string old = WithOtherType(content, ends, first, event, check);
    WriteJournal(folder / "old", old);
    for (const OnDamage on_damage : {kRefuse, kTakeWhatIsBefore}) {
      Entries entries;
      const std::string error = ErrorOf([&] { Journal(folder / "old", kMapping, on_damage, NoteIn(entries)); });
      CHECK(error.starts_with((folder / "old/journal.lcm").string() + ": journal of an older version"));
    }
    CHECK(Content(folder / "old") == old);
  }
}

TEST_CASE("what loops have brought comes back in its place between the matches, over several sessions") {
  const ScratchFolder folder;
  Entries all{{100}, {101}, {0, Update(30)}, {102}, {0, Update(2499)}, {0, Update(2506)}, {103}};
  Keep(folder / "a", all);
  CHECK(Holds(folder / "a", all));
  for (const Entries& session : {Entries{{0, Update(2600)}, {104}, {0, Update(2700)}}, {{0, Update(2800)}}}) {
    GoOn(folder / "a", session);
    all.insert(all.end(), session.begin(), session.end());
    CHECK(Holds(folder / "a", all));
  }
  std::int64_t num_matches = 0;  // all that is told to who asks for no updates
  CHECK(ReadJournal(folder / "a", kMapping, kRefuse, {[&](const CriticalRays*, const ScanMatch&) { ++num_matches; }})
            .empty());
  CHECK(num_matches == 5);
}

TEST_CASE("an LCM log shows each part of what loops have brought, and time does not go back there") {
  const ScratchFolder folder;
  Keep(folder / "a", {{100}, {90, Update(2499)}, {101}});
  lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
  std::vector<std::string> channels;
  std::int64_t utime = 0;
  for (std::int64_t number = 0; const lcm::LogEvent* event = log.readNextEvent(); ++number) {
    CHECK(event->timestamp >= std::exchange(utime, event->timestamp));
    CHECK(event->eventnum == number);
    if (event->channel != "JOURNAL_CHECK") channels.push_back(event->channel);
  }
  CHECK(channels == std::vector<std::string>{"JOURNAL_HEAD", "CRITICAL_RAYS", "SCAN_MATCH", "POSE_GRAPH", "POSE_GRAPH",
                                             "POSE_GRAPH", "CRITICAL_RAYS", "SCAN_MATCH"});
}

TEST_CASE("a journal says up to which keyframe loops were searched, at once or a few scans later") {
  const ScratchFolder folder;
  const auto ReadSearched = [&] {
    std::vector<KeyframeId> searched;
    ReadJournal(folder / "a", kMapping, kRefuse,
                {[](const CriticalRays*, const ScanMatch&) {}, [](const GraphUpdate&) { return true; },
                 [&](KeyframeId keyframe) {
                   searched.push_back(keyframe);
                   return true;
                 }});
    return searched;
  };
  {
    Journal journal(folder / "a", kMapping);
    for (int i = 0; i < 35; ++i) {
      Append(journal, {{100 + 3 * i}});  // all of them are drawn
      journal.AppendSearched({0, i}, {}, 100 + 3 * i);
      const auto searched = ReadSearched();  // as if it were killed now
      CHECK((searched.empty() ? 0 : searched.back().number + 1) == (i + 1) / 10 * 10);
    }
  }
  const std::vector<KeyframeId> expected{{0, 9}, {0, 19}, {0, 29}, {0, 34}};
  CHECK(ReadSearched() == expected);
  const std::string before = Content(folder / "a");
  Entries entries;
  Journal(folder / "a", kMapping, kRefuse, NoteIn(entries)).AppendSearched({0, 34}, {}, 134);  // which it says already
  CHECK(Content(folder / "a") == before);
  GraphUpdate update;
  update.keyframe = {0, 33};
  update.finding = LoopFinding{{0, 2}, {0, 33}, {0.5, 1.0 / 3.0, 0.1}, 0.75, LoopFinding::By::kCheck};
  {
    Journal journal(folder / "a", kMapping, kRefuse, NoteIn(entries));
    journal.Append(update, 133);
    journal.AppendSearched({0, 33}, KeyframeId{0, 33}, 133);  // which the update says
  }
  const JournalRead read = Read(folder / "a");
  CHECK(read.notice.empty());
  CHECK(read.entries.back().update == update);
  CHECK(ReadSearched() == expected);
}

TEST_CASE("what does not fit the scans, an update or a keyframe that was searched, is an error that names the file") {
  const ScratchFolder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, kShort);
    journal.AppendSearched({1, 31}, KeyframeId{1, 30}, 101);
  }
  const std::string before = Content(folder / "a");
  for (const bool update_fits : {false, true}) {
    const VisitJournal refuse{[](const CriticalRays*, const ScanMatch&) {},
                              [&](const GraphUpdate&) { return update_fits; }, [](KeyframeId) { return false; }};
    for (const OnDamage on_damage : {kRefuse, kTakeWhatIsBefore}) {
      const std::string error = ErrorOf([&] { ReadJournal(folder / "a", kMapping, on_damage, refuse); });
      CHECK(error == (folder / "a/journal.lcm").string() + ": its loop closures do not fit its scans");
      CHECK(ErrorOf([&] { Journal(folder / "a", kMapping, on_damage, refuse); }) == error);
    }
  }
  CHECK(Content(folder / "a") == before);
}

TEST_CASE("a session that was killed amid the parts of an update loses that one alone, and the next goes on") {
  const ScratchFolder folder;
  const Entries first{{100}, {0, Update(30)}};
  Entries with_parts = first;
  with_parts.push_back({0, Update(2499)});
  const std::string whole = Keep(folder / "whole", with_parts);
  const auto ends = EndsOfEvents(folder / "whole");
  REQUIRE(ends.size() == 4 + 2 + 3 * 2 + 1);
  const std::size_t first_part = 6;  // events before it
  // The same update is found again; or, by other parameters than then, another one.
  const int found = GENERATE(2499, 2700);
  for (std::size_t num_events = first_part; num_events < first_part + 5; ++num_events) {
    for (const std::size_t more_bytes : {0, 100}) {
      CAPTURE(num_events, more_bytes);
      WriteJournal(folder / "cut", whole.substr(0, ends[num_events - 1] + more_bytes));
      Entries entries;
      {
        Journal journal(folder / "cut", kMapping, kRefuse, NoteIn(entries));
        CHECK(entries == first);
        CHECK_FALSE(journal.notice().empty());
        Append(journal, {{101}, {0, Update(found)}, {102}});
      }
      CHECK(Holds(folder / "cut", {{100}, {0, Update(30)}, {101}, {0, Update(found)}, {102}}));
    }
  }
}

}  // namespace crsm
