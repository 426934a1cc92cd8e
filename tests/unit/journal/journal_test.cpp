#include "services/journal/journal.hpp"

#include <lcm/lcm-cpp.hpp>
#include <map>
#include <thread>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "journal/journal_folder.hpp"
#include "services/wire/channels.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

const JournalSubject kLocalization{true, kMapping.parameters};
constexpr OnDamage kRefuse = OnDamage::kRefuse;
constexpr OnDamage kTakeWhatIsBefore = OnDamage::kTakeWhatIsBefore;

/// Appends scans of these utimes; every third one was not drawn.
void Append(Journal& journal, const std::vector<std::int64_t>& utimes) {
  for (const std::int64_t utime : utimes) {
    const CriticalRays scan = Scan(utime);
    journal.Append(utime % 3 == 0 ? nullptr : &scan, Match(utime));
  }
}

/// What a visitor is told: utimes, and whether each came with its scan.
struct Visited {
  std::vector<std::int64_t> utimes;
  VisitJournal Visit() {
    return {[this](const CriticalRays* scan, const ScanMatch& match) {
      CHECK(match == Match(match.utime));
      CHECK((scan != nullptr) == (match.utime % 3 != 0));
      if (scan) CHECK(*scan == Scan(match.utime));
      utimes.push_back(match.utime);
    }};
  }
};

/// A journal of these utimes, which ended in order, as bytes.
std::string MakeJournal(const fs::path& folder, const std::vector<std::int64_t>& utimes) {
  {
    Journal journal(folder, kMapping);
    Append(journal, utimes);
  }
  return Content(folder / "journal.lcm");
}

/// What a journal of these utimes has been when the process was killed: without the check that ends the session.
std::string MakeKilled(const fs::path& folder, const std::vector<std::int64_t>& utimes) {
  Journal journal(folder, kMapping);
  Append(journal, utimes);
  return Content(folder / "journal.lcm");
}

std::vector<std::int64_t> Utimes(std::int64_t count) {
  std::vector<std::int64_t> utimes;
  for (std::int64_t i = 0; i < count; ++i) utimes.push_back(100 + i);
  return utimes;
}

const VisitJournal kIgnore{[](const CriticalRays*, const ScanMatch&) {}};

}  // namespace

TEST_CASE("a journal gives back what was kept, in several sessions, and its epoch stays") {
  const Folder folder;
  std::int64_t epoch = 0;
  {
    Journal journal(folder / "a", kMapping);
    epoch = journal.epoch();
    CHECK(epoch != 0);
    Append(journal, {100, 102, 101});
  }
  for (int session = 1; session < 3; ++session) {
    Visited visited;
    Journal journal(folder / "a", kMapping, kRefuse, visited.Visit());
    CHECK(journal.epoch() == epoch);
    CHECK(journal.notice().empty());
    CHECK(visited.utimes.size() == 3 * static_cast<std::size_t>(session));
    Append(journal, {100 + 10 * session, 101 + 10 * session, 102 + 10 * session});
  }
  Visited visited;
  CHECK(ReadJournal(folder / "a", kMapping, kRefuse, visited.Visit()).empty());
  CHECK(visited.utimes == std::vector<std::int64_t>{100, 102, 101, 110, 111, 112, 120, 121, 122});
  lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
  for (std::int64_t number = 0; const lcm::LogEvent* event = log.readNextEvent(); ++number) {
    CHECK(event->eventnum == number);  // on from session to session
  }
  CHECK(Journal(folder / "b", kMapping).epoch() != epoch);
}

TEST_CASE("a journal is an LCM log that begins with its head, at the time of its first scan, and numbers its events") {
  const Folder folder;
  for (const bool finished_map : {false, true}) {
    std::int64_t epoch = 0;
    {
      Journal journal(folder / "a", {finished_map, kMapping.parameters});
      epoch = journal.epoch();
      Append(journal, {100, 102});
    }
    lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
    const lcm::LogEvent* event = log.readNextEvent();
    REQUIRE(event);
    CHECK(event->channel == "JOURNAL_HEAD");
    CHECK(event->timestamp == 100);
    journal_head_t head;
    REQUIRE(head.decode(event->data, 0, event->datalen) > 0);
    CHECK(head.epoch == epoch);
    CHECK(head.finished_map == finished_map);
    CHECK(head.parameter_name == std::vector<std::string>{"cell_size_m", "join_hits"});
    CHECK(head.parameter_value == std::vector<std::string>{"0.05", "true"});
    const std::vector<std::string> rest{"CRITICAL_RAYS", "SCAN_MATCH",    "JOURNAL_CHECK",
                                        "SCAN_MATCH",    "JOURNAL_CHECK", "JOURNAL_CHECK"};
    for (std::size_t i = 0; i < rest.size(); ++i) {
      REQUIRE((event = log.readNextEvent()));
      CHECK(event->channel == rest[i]);
      CHECK(event->eventnum == static_cast<std::int64_t>(i) + 1);
      CHECK(event->timestamp == (i < 3 ? 100 : 102));
    }
    CHECK(log.readNextEvent() == nullptr);
    const auto said = ReadHead(folder / "a");
    REQUIRE(said);
    CHECK(said->epoch == epoch);
    CHECK(said->subject.finished_map == finished_map);
    CHECK(said->subject.parameters == kMapping.parameters);
    fs::remove_all(folder / "a");
  }
}

TEST_CASE("a journal of an empty session may be gone on with") {
  const Folder folder;
  { Journal journal(folder / "a", kMapping); }
  CHECK(fs::file_size(folder / "a/journal.lcm") == 0);
  CHECK_FALSE(ReadHead(folder / "a"));
  Visited visited;
  std::int64_t epoch = 0;
  {
    Journal journal(folder / "a", kMapping, kRefuse, visited.Visit());
    epoch = journal.epoch();
    CHECK(epoch != 0);
    Append(journal, {100});
  }
  CHECK(Journal(folder / "a", kMapping, kRefuse, visited.Visit()).epoch() == epoch);
  CHECK(visited.utimes == std::vector<std::int64_t>{100});
}

TEST_CASE(
    "a tail that a power cut left is cut off behind the last whole scan, wherever it was torn, and that is said") {
  const Folder folder;
  const std::string whole = MakeKilled(folder / "a", Utimes(6));
  const std::string five = MakeKilled(folder / "b", Utimes(5));
  REQUIRE(whole.size() > five.size() + 100);
  const fs::path path = folder / "a/journal.lcm";
  const std::size_t last = whole.size() - five.size();  // bytes of the last scan
  for (const std::string& tail :
       {whole.substr(five.size(), last - 1), whole.substr(five.size(), 5), whole.substr(five.size(), last / 2),
        std::string(4096, '\0'), std::string(3000, '\x5a'), whole.substr(five.size(), 40) + std::string(4096, '\0')}) {
    Write(path, whole.substr(0, five.size()) + tail);
    Visited visited;
    CHECK(ReadJournal(folder / "a", kMapping, kRefuse, visited.Visit()).find("5 scans remain") != std::string::npos);
    CHECK(Content(path).size() == five.size() + tail.size());  // who reads only leaves it as it is
    Visited again;
    {
      Journal journal(folder / "a", kMapping, kRefuse, again.Visit());
      CHECK(again.utimes == Utimes(5));
      CHECK(journal.notice() == path.string() + ": torn by a power cut or a kill at byte " +
                                    std::to_string(five.size()) + " (event 15): the last " +
                                    std::to_string(tail.size()) + " bytes are left out; 5 scans remain");
      CHECK(fs::file_size(path) == five.size());
      Append(journal, {200});
    }
    Visited after;
    CHECK(ReadJournal(folder / "a", kMapping, kRefuse, after.Visit()).empty());
    CHECK(after.utimes.back() == 200);
    CHECK(after.utimes.size() == 6);
  }
}

TEST_CASE("a journal that a killed process left is whole, and that its session did not end in order is said") {
  const Folder folder;
  const std::string killed = MakeKilled(folder / "a", Utimes(4));
  Write(folder / "a/journal.lcm", killed);
  Visited visited;
  Journal journal(folder / "a", kMapping, kRefuse, visited.Visit());
  CHECK(visited.utimes == Utimes(4));
  CHECK(journal.notice().find("ended unexpectedly; 4 scans are complete") != std::string::npos);
  CHECK(Content(folder / "a/journal.lcm") == killed);
}

TEST_CASE("a journal torn before its first scan was whole begins anew, but another file is refused") {
  const Folder folder;
  const std::string whole = MakeKilled(folder / "a", Utimes(3));
  const fs::path path = folder / "a/journal.lcm";
  for (const std::string& torn :
       {whole.substr(0, 10), whole.substr(0, 60), whole.substr(0, 200), std::string(5000, '\0')}) {
    Write(path, torn);
    Visited visited;
    CHECK_FALSE(ReadHead(folder / "a"));
    Journal journal(folder / "a", kMapping, kRefuse, visited.Visit());
    CHECK(visited.utimes.empty());
    CHECK(journal.notice().find("0 scans remain") != std::string::npos);
    CHECK(fs::file_size(path) == 0);
  }
  for (const std::string& other : {std::string("x"), std::string("a text of somebody\n"), std::string(500, 'x')}) {
    Write(path, other);
    for (const OnDamage on_damage : {kRefuse, kTakeWhatIsBefore}) {
      CHECK(ErrorOf([&] { Journal(folder / "a", kMapping, on_damage, kIgnore); }).find(" is no journal") !=
            std::string::npos);
      CHECK(Content(path) == other);
    }
  }
}

TEST_CASE("damage in the middle is refused with its place, and what is before it is taken where that is allowed") {
  const Folder folder;
  const std::string whole = MakeJournal(folder / "a", Utimes(20));
  const std::string nine = MakeKilled(folder / "b", Utimes(9));
  const fs::path path = folder / "a/journal.lcm";
  std::string damaged = whole;
  damaged[nine.size() + 77] ^= 0x10;
  Write(path, damaged);
  const std::string place = "at byte " + std::to_string(nine.size()) + " (event 25)";
  for (int time = 0; time < 2; ++time) {
    const std::string error = ErrorOf([&] { Journal(folder / "a", kMapping, kRefuse, kIgnore); });
    CHECK(error.find(path.string() + " is damaged " + place + ", after its first 9 scans: --until-damage") == 0);
    CHECK(Content(path) == damaged);
  }
  for (const char* beside : {"a/journal.lcm.damaged", "a/journal.lcm.damaged2"}) {
    Write(path, damaged);
    Visited visited;
    Journal journal(folder / "a", kMapping, kTakeWhatIsBefore, visited.Visit());
    CHECK(visited.utimes == Utimes(9));
    CHECK(journal.notice().find("damaged " + place) != std::string::npos);
    CHECK(journal.notice().find("; the original file is now " + (folder / beside).string()) != std::string::npos);
    CHECK(Content(folder / beside) == damaged);
    CHECK(Content(path) == whole.substr(0, nine.size()));
  }
}

TEST_CASE("a scan that stands twice in a journal, or that is left out, is a damage although each is whole") {
  const Folder folder;
  const std::string whole = MakeJournal(folder / "a", Utimes(20));
  const std::size_t nine = MakeKilled(folder / "b", Utimes(9)).size();
  const std::size_t ten = MakeKilled(folder / "c", Utimes(10)).size();
  for (const std::string& damaged :
       {whole.substr(0, ten) + whole.substr(nine), whole.substr(0, nine) + whole.substr(ten)}) {
    Write(folder / "a/journal.lcm", damaged);
    Visited visited;
    const auto Read = [&] { ReadJournal(folder / "a", kMapping, kRefuse, visited.Visit()); };
    CHECK(ErrorOf(Read).find(" is damaged at byte ") != std::string::npos);
    CHECK(visited.utimes == Utimes(damaged.size() > whole.size() ? 10 : 9));
  }
}

TEST_CASE("a hole that was never on the disk is what a power cut leaves, and is kept beside with what follows") {
  const Folder folder;
  std::string killed = MakeKilled(folder / "a", Utimes(12));  // faster than the disk is told of
  const std::string four = MakeKilled(folder / "b", Utimes(4));
  killed.replace(four.size() + 10, 100, 100, '\0');
  Write(folder / "a/journal.lcm", killed);
  Visited visited;
  Journal journal(folder / "a", kMapping, kRefuse, visited.Visit());
  CHECK(visited.utimes == Utimes(4));
  CHECK(journal.notice().find("4 scans remain; the original file is now ") != std::string::npos);
  CHECK(Content(folder / "a/journal.lcm.damaged") == killed);
}

TEST_CASE("a thousand damages: each is cut off, refused, or changes nothing, and none is silent") {
  const Folder folder;
  const std::vector<std::int64_t> utimes = Utimes(40);
  const std::string whole = MakeJournal(folder / "a", utimes);
  const fs::path path = folder / "a/journal.lcm";
  Random random(14);
  const auto Below = [&](std::size_t most) {
    return static_cast<std::size_t>(random.Uniform(0.0, static_cast<double>(most)));
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
    Write(path, damaged);
    Visited visited;
    std::string said;
    const std::string error = ErrorOf([&] { said = ReadJournal(folder / "a", kMapping, kRefuse, visited.Visit()); });
    CAPTURE(number, at, size, said, error);
    REQUIRE(visited.utimes.size() <= utimes.size());
    CHECK(std::equal(visited.utimes.begin(), visited.utimes.end(), utimes.begin()));
    const bool all = visited.utimes == utimes;
    CHECK((all || !error.empty() || !said.empty()));
    CHECK((damaged == whole || all || !(error + said).empty()));
    if (!error.empty() && error.find("no journal") == std::string::npos) {
      Visited before;
      said = ReadJournal(folder / "a", kMapping, kTakeWhatIsBefore, before.Visit());
      CHECK(std::equal(before.utimes.begin(), before.utimes.end(), utimes.begin()));
      CHECK(said.find(std::to_string(before.utimes.size()) + " scans remain") != std::string::npos);
    }
    ++counts[!error.empty() ? "refused" : all ? "same" : "cut"];
  }
  CHECK(counts["refused"] > 500);
  CHECK(counts["cut"] > 100);
  CHECK(counts["refused"] + counts["cut"] + counts["same"] == 1000);
}

TEST_CASE("what was kept reaches the disk within a second, and a check tells how much") {
  const Folder folder;
  Journal journal(folder / "a", kMapping);
  Append(journal, {100});
  const auto size = static_cast<std::int64_t>(fs::file_size(folder / "a/journal.lcm"));
  std::int64_t synced = 0;
  for (std::int64_t utime = 101; synced == 0 && utime < 120; ++utime) {
    std::this_thread::sleep_for(std::chrono::milliseconds(utime == 101 ? 1000 : 100));
    Append(journal, {utime});
    lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
    while (const lcm::LogEvent* event = log.readNextEvent()) {
      journal_check_t check;
      if (check.decode(event->data, 0, event->datalen) > 0) synced = check.synced_bytes;
    }
  }
  CHECK(synced >= size);
}

TEST_CASE("a journal of something else, missing or in the way is refused by name") {
  const Folder folder;
  MakeJournal(folder / "map", {100, 101, 102});
  {
    Journal localization(folder / "loc", kLocalization);
    Append(localization, {100});
  }
  const std::string map_path = (folder / "map/journal.lcm").string();
  const auto Refused = [&](const std::string& name, const JournalSubject& subject) {
    return ErrorOf([&] { ReadJournal(folder / name, subject, kRefuse, kIgnore); });
  };
  CHECK(Refused("map", kMapping).empty());
  CHECK(Refused("map", kLocalization) ==
        map_path + " belongs to a run that made a map: choose another folder for the journal of a localization");
  CHECK(Refused("loc", kMapping).find("loc/journal.lcm belongs to a run that localised on the map of another folder") !=
        std::string::npos);
  CHECK(Refused("map", {false, {{"cell_size_m", "0.02"}}}) ==
        map_path + ": its map was made with cell_size_m = 0.05, not with 0.02");
  CHECK(Refused("map", {false, {{"of_a_later_version", "1"}}}).empty());
  CHECK(Refused("none", kMapping).find("none/journal.lcm") != std::string::npos);
  CHECK(ErrorOf([&] { ReadHead(folder / "none"); }).find("none/journal.lcm") != std::string::npos);
  CHECK(ErrorOf([&] { Journal(folder / "map", kMapping); }).find(map_path + " exists already") == 0);
}

TEST_CASE("a journal is taken over whole by another folder, and by its own") {
  const Folder folder;
  {
    Journal journal(folder / "a/journal", kMapping);
    Append(journal, {100, 101});
    Journal other(folder / "b/journal", kMapping);
  }
  const std::string content = Content(folder / "a/journal/journal.lcm");
  TakeOverJournal(folder / "a", folder / "a");
  CHECK(Content(folder / "a/journal/journal.lcm") == content);
  for (const char* name : {"b", "c"}) {
    TakeOverJournal(folder / "a", folder / name);
    CHECK(Content(folder / name / "journal/journal.lcm") == content);
    CHECK_FALSE(fs::exists(folder / name / "journal/journal.lcm.tmp"));
  }
  CHECK(ErrorOf([&] { TakeOverJournal(folder / "none", folder / "d"); }).find("there is no file ") == 0);
  RemoveJournal(folder / "b");
  CHECK_FALSE(fs::exists(folder / "b/journal/journal.lcm"));
  CHECK(fs::exists(folder / "c/journal/journal.lcm"));
}

}  // namespace crsm
