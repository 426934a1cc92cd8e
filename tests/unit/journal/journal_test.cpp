#include "services/journal/journal.hpp"

#include <lcm/lcm-cpp.hpp>
#include <map>
#include <thread>

#include "catch.hpp"
#include "journal/journal_folder.hpp"
#include "services/wire/channels.hpp"

namespace crsm {
namespace {

const VisitJournal kIgnore{[](const CriticalRays*, const ScanMatch&) {}};

bool Says(const std::string& text, const std::string& expected) {
  CAPTURE(text);
  return text.find(expected) != std::string::npos;
}

void WriteJournal(const fs::path& folder, const std::string& content) {
  std::ofstream(folder / "journal.lcm", std::ios::binary) << content;
}

/// What is said of a journal when a session goes on with it, and what it reads.
JournalRead GoOnWith(const fs::path& folder, OnDamage on_damage = kRefuse) {
  JournalRead read;
  read.notice = Journal(folder, kMapping, on_damage, NoteIn(read.entries)).notice();
  return read;
}

}  // namespace

TEST_CASE("a journal gives back what was kept, in several sessions, and its epoch stays") {
  const ScratchFolder folder;
  Entries all;
  std::int64_t epoch = 0;
  CHECK(Keep(folder / "a", {}).empty());
  for (const Entries& session : {Entries{}, {{100}, {102}, {101}}, {{110}, {111}, {112}}, {{120}, {121}}}) {
    Entries before;
    Journal journal(folder / "a", kMapping, kRefuse, NoteIn(before));
    CHECK(before == all);
    CHECK(journal.notice().empty());
    CHECK(journal.epoch() != 0);
    if (all.size() > 0) CHECK(journal.epoch() == epoch);
    epoch = journal.epoch();
    Append(journal, session);
    all.insert(all.end(), session.begin(), session.end());
    if (all.empty()) CHECK_FALSE(ReadHead(folder / "a"));
  }
  CHECK(Holds(folder / "a", all));
  lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
  for (std::int64_t number = 0; const lcm::LogEvent* event = log.readNextEvent(); ++number) {
    CHECK(event->eventnum == number);  // on from session to session
  }
  CHECK(Journal(folder / "b", kMapping).epoch() != epoch);
}

TEST_CASE("a journal is an LCM log that begins with its head, at the time of its first scan") {
  const ScratchFolder folder;
  for (const bool finished_map : {false, true}) {
    const fs::path path = folder / (finished_map ? "finished" : "grows");
    std::int64_t epoch = 0;
    {
      Journal journal(path, {finished_map, kMapping.parameters});
      epoch = journal.epoch();
      Append(journal, {{100}, {102}});
    }
    lcm::LogFile log((path / "journal.lcm").string(), "r");
    const std::pair<std::string, std::int64_t> expected[] = {
        {"JOURNAL_HEAD", 100}, {"CRITICAL_RAYS", 100}, {"SCAN_MATCH", 100},   {"JOURNAL_CHECK", 100},
        {"SCAN_MATCH", 102},   {"JOURNAL_CHECK", 102}, {"JOURNAL_CHECK", 102}};
    for (const auto& [channel, utime] : expected) {
      const lcm::LogEvent* event = log.readNextEvent();
      REQUIRE(event);
      CHECK(event->channel == channel);
      CHECK(event->timestamp == utime);
      if (channel != "JOURNAL_HEAD") continue;
      journal_head_t head;
      REQUIRE(head.decode(event->data, 0, event->datalen) > 0);
      CHECK(head.epoch == epoch);
      CHECK(head.finished_map == finished_map);
      CHECK(head.parameter_name == std::vector<std::string>{"cell_size_m", "join_hits"});
      CHECK(head.parameter_value == std::vector<std::string>{"0.05", "true"});
    }
    CHECK(log.readNextEvent() == nullptr);
    const auto said = ReadHead(path);
    REQUIRE(said);
    CHECK(said->epoch == epoch);
    CHECK(said->subject.finished_map == finished_map);
    CHECK(said->subject.parameters == kMapping.parameters);
  }
}

TEST_CASE(
    "a tail that a power cut left is cut off behind the last whole scan, wherever it was torn, and that is said") {
  const ScratchFolder folder;
  const std::string whole = Keep(folder / "a", Scans(6), true);
  const std::string five = Keep(folder / "b", Scans(5), true);
  const std::string last = whole.substr(five.size());
  REQUIRE(last.size() > 100);
  for (const std::string& tail :
       {last.substr(0, last.size() - 1), last.substr(0, 5), last.substr(0, last.size() / 2), std::string(4096, '\0'),
        std::string(3000, '\x5a'), last.substr(0, 40) + std::string(4096, '\0')}) {
    WriteJournal(folder / "a", five + tail);
    CHECK(Says(Read(folder / "a").notice, "5 scans remain"));
    CHECK(Content(folder / "a") == five + tail);  // who reads only leaves it as it is
    const JournalRead read = GoOnWith(folder / "a");
    CHECK(read.entries == Scans(5));
    CHECK(Says(read.notice, "the last " + std::to_string(tail.size()) + " bytes are left out; 5 scans remain"));
    CHECK(Content(folder / "a").starts_with(five));
    GoOn(folder / "a", {{200}});
    Entries expected = Scans(5);
    expected.push_back({200});
    CHECK(Holds(folder / "a", expected));
  }
}

TEST_CASE("a journal that a killed process left is whole, and that its session did not end in order is said") {
  const ScratchFolder folder;
  const std::string killed = Keep(folder / "a", Scans(4), true);
  WriteJournal(folder / "a", killed);
  Entries entries;
  Journal journal(folder / "a", kMapping, kRefuse, NoteIn(entries));
  CHECK(entries == Scans(4));
  CHECK(Says(journal.notice(), "ended unexpectedly; 4 scans are complete"));
  CHECK(Content(folder / "a") == killed);
}

TEST_CASE("a journal torn before its first scan was whole begins anew, but another file is refused") {
  const ScratchFolder folder;
  const std::string whole = Keep(folder / "a", Scans(3), true);
  for (const std::string& torn :
       {whole.substr(0, 10), whole.substr(0, 60), whole.substr(0, 200), std::string(5000, '\0')}) {
    WriteJournal(folder / "a", torn);
    CHECK_FALSE(ReadHead(folder / "a"));
    const JournalRead read = GoOnWith(folder / "a");
    CHECK(read.entries.empty());
    CHECK(Says(read.notice, "0 scans remain"));
    CHECK(Content(folder / "a").empty());
  }
  for (const std::string& other : {std::string("x"), std::string("a text of somebody\n"), std::string(500, 'x')}) {
    WriteJournal(folder / "a", other);
    for (const OnDamage on_damage : {kRefuse, kTakeWhatIsBefore}) {
      CHECK(Says(ErrorOf([&] { GoOnWith(folder / "a", on_damage); }), " is no journal"));
      CHECK(Content(folder / "a") == other);
    }
  }
}

TEST_CASE("damage in the middle is refused with its place, and what is before it is taken where that is allowed") {
  const ScratchFolder folder;
  std::string damaged = Keep(folder / "a", Scans(20));
  const std::string nine = Keep(folder / "b", Scans(9), true);
  damaged[nine.size() + 77] ^= 0x10;
  WriteJournal(folder / "a", damaged);
  const std::string place = "damaged at byte " + std::to_string(nine.size()) + " (event 25)";
  for (int time = 0; time < 2; ++time) {
    CHECK(Says(ErrorOf([&] { GoOnWith(folder / "a"); }), place + ", after its first 9 scans: --until-damage"));
    CHECK(Content(folder / "a") == damaged);
  }
  for (const char* beside : {"a/journal.lcm.damaged", "a/journal.lcm.damaged2"}) {
    WriteJournal(folder / "a", damaged);
    Entries entries;
    Journal journal(folder / "a", kMapping, kTakeWhatIsBefore, NoteIn(entries));
    CHECK(entries == Scans(9));
    CHECK(Says(journal.notice(), place));
    CHECK(Says(journal.notice(), "; the original file is now " + (folder / beside).string()));
    CHECK(BytesOf(folder / beside) == damaged);
    CHECK(Content(folder / "a") == damaged.substr(0, nine.size()));
  }
}

TEST_CASE("a scan that stands twice in a journal, or that is left out, is a damage although each is whole") {
  const ScratchFolder folder;
  const std::string whole = Keep(folder / "a", Scans(20));
  const std::size_t nine = Keep(folder / "b", Scans(9), true).size();
  const std::size_t ten = Keep(folder / "c", Scans(10), true).size();
  for (const auto& [first_end, then_begin] : {std::pair(ten, nine), std::pair(nine, ten)}) {
    WriteJournal(folder / "a", whole.substr(0, first_end) + whole.substr(then_begin));
    Entries entries;
    const auto Visit = [&] { ReadJournal(folder / "a", kMapping, kRefuse, NoteIn(entries)); };
    CHECK(Says(ErrorOf(Visit), " is damaged at byte "));
    CHECK(entries == Scans(first_end == ten ? 10 : 9));
  }
}

TEST_CASE("a hole that was never on the disk is what a power cut leaves, and is kept beside with what follows") {
  const ScratchFolder folder;
  std::string killed = Keep(folder / "a", Scans(12), true);  // faster than the disk is told of
  killed.replace(Keep(folder / "b", Scans(4), true).size() + 10, 100, 100, '\0');
  WriteJournal(folder / "a", killed);
  const JournalRead read = GoOnWith(folder / "a");
  CHECK(read.entries == Scans(4));
  CHECK(Says(read.notice, "4 scans remain; the original file is now "));
  CHECK(BytesOf(folder / "a/journal.lcm.damaged") == killed);
}

TEST_CASE("a thousand damages: each is cut off, refused, or changes nothing, and none is silent") {
  const ScratchFolder folder;
  const Entries kept = Scans(40);
  const std::string whole = Keep(folder / "a", kept);
  Random random(14);
  const auto Below = [&](std::size_t most) {
    return static_cast<std::size_t>(random.Uniform(0.0, static_cast<double>(most)));
  };
  const auto IsBegin = [&](const Entries& read) {
    return read.size() <= kept.size() && std::equal(read.begin(), read.end(), kept.begin());
  };
  std::map<std::string, int> counts;
  for (int number = 0; number < 1000; ++number) {
    std::string damaged = whole;
    const std::size_t at = Below(whole.size());
    const std::size_t size = std::min(1 + Below(2000), whole.size() - at);
    switch (number % 5) {
      case 0:
        damaged[at] = static_cast<char>(damaged[at] ^ 1 << Below(8));
        break;
      case 1:
        damaged.resize(at);
        break;
      case 2:
        damaged.replace(at, size, size, '\0');
        break;
      case 3:
        damaged.replace(at, size, whole.substr(Below(whole.size() - size), size));
        break;
      default:
        damaged.insert(at, whole.substr(Below(whole.size() - size), size));
    }
    WriteJournal(folder / "a", damaged);
    Entries entries;
    std::string said;
    const std::string error = ErrorOf([&] { said = ReadJournal(folder / "a", kMapping, kRefuse, NoteIn(entries)); });
    CAPTURE(number, at, size, said, error);
    REQUIRE(IsBegin(entries));
    const bool all = entries == kept;
    CHECK((all || !(error + said).empty()));
    if (!error.empty() && error.find("no journal") == std::string::npos) {
      Entries before;
      said = ReadJournal(folder / "a", kMapping, kTakeWhatIsBefore, NoteIn(before));
      CHECK(IsBegin(before));
      CHECK(Says(said, std::to_string(before.size()) + " scans remain"));
    }
    ++counts[!error.empty() ? "refused" : all ? "same" : "cut"];
  }
  CHECK(counts["refused"] > 500);
  CHECK(counts["cut"] > 100);
}

TEST_CASE("what was kept reaches the disk within a second, and a check tells how much") {
  const ScratchFolder folder;
  Journal journal(folder / "a", kMapping);
  Append(journal, {{100}});
  const auto size = static_cast<std::int64_t>(Content(folder / "a").size());
  std::int64_t synced = 0;
  for (std::int64_t utime = 101; synced == 0 && utime < 120; ++utime) {
    std::this_thread::sleep_for(std::chrono::milliseconds(utime == 101 ? 1000 : 100));
    Append(journal, {{utime}});
    lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
    while (const lcm::LogEvent* event = log.readNextEvent()) {
      journal_check_t check;
      if (check.decode(event->data, 0, event->datalen) > 0) synced = check.synced_bytes;
    }
  }
  CHECK(synced >= size);
}

TEST_CASE("a journal of something else, missing or in the way is refused by name") {
  const ScratchFolder folder;
  const JournalSubject localization{true, kMapping.parameters};
  Keep(folder / "map", Scans(3));
  {
    Journal journal(folder / "loc", localization);
    Append(journal, {{100}});
  }
  struct Case {
    std::string name;
    JournalSubject subject;
    std::string error;  ///< a part of it
  };
  for (const auto& [name, subject, error] :
       {Case{"map", localization, " belongs to a run that made a map"},
        {"loc", kMapping, " belongs to a run that localised on the map of another folder"},
        {"map", {false, {{"cell_size_m", "0.02"}}}, ": its map was made with cell_size_m = 0.05, not with 0.02"},
        {"none", kMapping, ""}}) {
    const auto Visit = [&, name = name, subject = subject] { ReadJournal(folder / name, subject, kRefuse, kIgnore); };
    CHECK(Says(ErrorOf(Visit), (folder / name / "journal.lcm").string() + error));
  }
  CHECK(Holds(folder / "map", Scans(3)));
  CHECK_NOTHROW(ReadJournal(folder / "map", {false, {{"of_a_later_version", "1"}}}, kRefuse, kIgnore));
  CHECK(Says(ErrorOf([&] { ReadHead(folder / "none"); }), "none/journal.lcm"));
  CHECK(Says(ErrorOf([&] { Journal(folder / "map", kMapping); }), "map/journal.lcm exists already"));
}

TEST_CASE("a localization goes on with its journal only on the map that it began on, which is named") {
  const ScratchFolder folder;
  JournalSubject subject{true, kMapping.parameters, NameMap(0x12, 300)};
  {
    Journal journal(folder / "a", subject);
    Append(journal, {{100}});
  }
  CHECK(ReadHead(folder / "a")->subject.parameters == kMapping.parameters);
  CHECK(ReadHead(folder / "a")->subject.finished_map_name == "0000000000000012 of 300 scans");
  CHECK_NOTHROW(ReadJournal(folder / "a", subject, kRefuse, kIgnore));
  CHECK_NOTHROW(ReadJournal(folder / "a", {true, {}}, kRefuse, kIgnore));      // which is not compared
  for (const std::string& other : {NameMap(0x13, 300), NameMap(0x12, 301)}) {  // replaced, continued
    subject.finished_map_name = other;
    const std::string error = ErrorOf([&] { Journal(folder / "a", subject, kRefuse, kIgnore); });
    CHECK(Says(
        error,
        "localises on another map (0000000000000012 of 300 scans) than the one that --localize names now (" + other));
  }
  {
    Journal journal(folder / "old", {true, kMapping.parameters});  // as version 0.2.0 has written it
    Append(journal, {{100}});
  }
  CHECK_NOTHROW(ReadJournal(folder / "old", subject, kRefuse, kIgnore));
}

TEST_CASE("a summary beside the journal of another map is named, one without an identity is not") {
  const ScratchFolder folder;
  Keep(folder / "journal", Scans(2));
  CHECK_NOTHROW(CheckAreOfOneMap(folder.path()));
  const auto Summarize = [&](const std::string& text) { std::ofstream(folder / "summary.json") << text; };
  Summarize("{}");
  CHECK_NOTHROW(CheckAreOfOneMap(folder.path()));
  Summarize(R"({"identity": ")" + FormatIdentity(ReadHead(folder / "journal")->epoch) + R"("})");
  CHECK_NOTHROW(CheckAreOfOneMap(folder.path()));
  Summarize(R"({"identity": "0000000000000012"})");
  CHECK(Says(ErrorOf([&] { CheckAreOfOneMap(folder.path()); }),
             folder.path().string() + ": its summary.json is of another map than its journal"));
  for (const char* text : {"[]", "{", R"({"identity": 5})"}) {
    Summarize(text);
    CHECK_NOTHROW(CheckAreOfOneMap(folder.path()));
  }
}

TEST_CASE("a journal is taken over whole by another folder, and by its own") {
  const ScratchFolder folder;
  const std::string content = Keep(folder / "a/journal", Scans(2));
  Keep(folder / "b/journal", {});
  for (const char* name : {"a", "b", "c"}) {
    TakeOverJournal(folder / "a", folder / name);
    CHECK(Content(folder / name / "journal") == content);
    CHECK_FALSE(fs::exists(folder / name / "journal/journal.lcm.tmp"));
  }
  CHECK(Says(ErrorOf([&] { TakeOverJournal(folder / "none", folder / "d"); }), "there is no file "));
  RemoveJournal(folder / "b");
  CHECK_FALSE(fs::exists(folder / "b/journal/journal.lcm"));
  CHECK(fs::exists(folder / "c/journal/journal.lcm"));
}

TEST_CASE("a journal is covered by a map that is further on, and by no other") {
  const ScratchFolder folder;
  std::vector<ScanMatch> matches;
  for (const Entry& entry : Scans(6)) matches.push_back(Match(entry.utime));
  std::int64_t epoch = 0;
  {
    Journal journal(folder / "a", kMapping, 4711);
    Append(journal, Scans(5));
    epoch = journal.epoch();
  }
  CHECK(epoch == 4711);
  CHECK(ReadHead(folder / "a")->epoch == epoch);
  CHECK(IsCovered(folder / "a", epoch, matches));
  CHECK(IsCovered(folder / "a", epoch, std::span(matches).first(5)));
  CHECK_FALSE(IsCovered(folder / "a", epoch, std::span(matches).first(4)));  // it has more
  CHECK_FALSE(IsCovered(folder / "a", epoch + 1, matches));
  CHECK_FALSE(IsCovered(folder / "none", epoch, matches));
  std::vector<ScanMatch> elsewhere = matches;
  elsewhere[3].T_map_laser.y_m += 0.1;
  CHECK_FALSE(IsCovered(folder / "a", epoch, elsewhere));
  std::ofstream(folder / "a/journal.lcm", std::ios::app) << "1";  // nobody knows what this was
  CHECK_FALSE(IsCovered(folder / "a", epoch, matches));
}

TEST_CASE("a journal is of another map by its identity, or where it cannot be read") {
  const ScratchFolder folder;
  CHECK_FALSE(IsOfAnotherMap(folder.path(), "000000000000002a"));  // there is none
  { Journal(folder.path(), {}, 0x2a).Append(nullptr, {1, {}, 0.0, 0, 1, 0, MatchState::kFirst}); }
  CHECK_FALSE(IsOfAnotherMap(folder.path(), "000000000000002a"));
  CHECK(IsOfAnotherMap(folder.path(), "000000000000002b"));
  std::filesystem::remove(JournalPath(folder.path()));
  std::filesystem::create_directory(JournalPath(folder.path()));
  CHECK(IsOfAnotherMap(folder.path(), "000000000000002a"));
}

TEST_CASE("a journal gives back marks where they came, and refuses those that do not fit") {
  const ScratchFolder folder;
  const FixedMark seen{{105, "v1", "victim", "in the hall", MarkAction::kSeen, false, 0.25, {{1.0, 2.0}}},
                       {{KeyframeId{1, 3}, {1.5, 2.5}}}};
  const FixedMark removed{{106, "v1", "", "", MarkAction::kRemoved, false, 0.5, {}}, {}};
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {{100}});
    journal.Append(seen);
    Append(journal, {{101}});
    journal.Append(removed);
  }
  std::vector<FixedMark> marks;
  std::vector<std::size_t> scans_before;
  Entries entries;
  VisitJournal visit = NoteIn(entries);
  visit.mark = [&](const FixedMark& mark) {
    marks.push_back(mark);
    scans_before.push_back(entries.size());
    return true;
  };
  CHECK(ReadJournal(folder / "a", kMapping, kRefuse, visit).empty());
  REQUIRE(marks.size() == 2);
  CHECK(scans_before == std::vector<std::size_t>{1, 2});
  CHECK(marks[0].mark.name == "in the hall");
  CHECK(marks[0].points[0].keyframe == KeyframeId{1, 3});
  CHECK(marks[0].points[0].at == Point{1.5, 2.5});
  CHECK(marks[1].mark.action == MarkAction::kRemoved);
  visit.mark = [](const FixedMark&) { return false; };
  CHECK(Says(ErrorOf([&] { ReadJournal(folder / "a", kMapping, kRefuse, visit); }), "its marks do not fit its scans"));
}

}  // namespace crsm
