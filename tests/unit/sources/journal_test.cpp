#include "services/sources/journal.hpp"

#include <lcm/lcm-cpp.hpp>

#include "catch.hpp"
#include "services/runtime/bus.hpp"
#include "source_helpers.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr JournalSubject kMapping{0.05, false};
constexpr JournalSubject kLocalization{0.05, true};

/// A folder, gone at the end of the test.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("crsm_journal_" + std::to_string(getpid()))) { fs::remove_all(path_); }
  ~Folder() { fs::remove_all(path_); }
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

CriticalRays Scan(std::int64_t utime) { return RaysOf(ScanRoom({}, utime, 10)); }
ScanMatch Match(std::int64_t utime) {
  return {utime, {0.1 * static_cast<double>(utime), 0.0, 0.0}, 0.5, 1, 1, 0, MatchState::kOk};
}

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
    return [this](const CriticalRays* scan, const ScanMatch& match) {
      CHECK(match == Match(match.utime));
      CHECK((scan != nullptr) == (match.utime % 3 != 0));
      if (scan) CHECK(*scan == Scan(match.utime));
      utimes.push_back(match.utime);
    };
  }
};

std::string Content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

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
    Journal journal(folder / "a", kMapping, visited.Visit());
    CHECK(journal.epoch() == epoch);
    CHECK(journal.num_cut_bytes() == 0);
    CHECK(visited.utimes.size() == 3 * static_cast<std::size_t>(session));
    Append(journal, {100 + 10 * session, 101 + 10 * session, 102 + 10 * session});
  }
  Visited visited;
  ReadJournal(folder / "a", kMapping, visited.Visit());
  CHECK(visited.utimes == std::vector<std::int64_t>{100, 102, 101, 110, 111, 112, 120, 121, 122});
  CHECK(Journal(folder / "b", kMapping).epoch() != epoch);
}

TEST_CASE("a journal is an LCM log that begins with its epoch, at the time of its first scan") {
  const Folder folder;
  std::int64_t epoch = 0;
  for (const bool finished_map : {false, true}) {
    {
      Journal journal(folder / "a", {0.05, finished_map});
      epoch = journal.epoch();
      Append(journal, {100});
    }
    lcm::LogFile log((folder / "a/journal.lcm").string(), "r");
    const lcm::LogEvent* event = log.readNextEvent();
    REQUIRE(event);
    CHECK(event->channel == (finished_map ? "FINISHED_MAP_EPOCH" : "MAP_EPOCH"));
    CHECK(event->timestamp == 100);
    map_delta_t head;
    REQUIRE(head.decode(event->data, 0, event->datalen) > 0);
    CHECK(head.epoch == epoch);
    CHECK(head.cell_size_m == 0.05);
    CHECK(log.readNextEvent()->channel == "CRITICAL_RAYS");
    CHECK(log.readNextEvent()->channel == "SCAN_MATCH");
    CHECK(log.readNextEvent() == nullptr);
    fs::remove_all(folder / "a");
  }
}

TEST_CASE("a journal of an empty session may be gone on with, and one without an epoch gets one") {
  const Folder folder;
  { Journal journal(folder / "a", kMapping); }
  Visited visited;
  std::int64_t epoch = 0;
  {
    Journal journal(folder / "a", kMapping, visited.Visit());
    epoch = journal.epoch();
    CHECK(epoch != 0);
    Append(journal, {100});
  }
  CHECK(Journal(folder / "a", kMapping, visited.Visit()).epoch() == epoch);
  CHECK(visited.utimes == std::vector<std::int64_t>{100});
}

TEST_CASE("a torn tail is passed over by who reads and cut off by who goes on") {
  const Folder folder;
  {
    Journal journal(folder / "a", kMapping);
    Append(journal, {100, 101, 103});
  }
  const fs::path path = folder / "a/journal.lcm";
  fs::resize_file(path, fs::file_size(path) - 5);
  const std::string torn = Content(path);
  Visited visited;
  ReadJournal(folder / "a", kMapping, visited.Visit());
  CHECK(visited.utimes == std::vector<std::int64_t>{100, 101});
  CHECK(Content(path) == torn);
  Visited again;
  Journal journal(folder / "a", kMapping, again.Visit());
  CHECK(again.utimes == visited.utimes);
  CHECK(journal.num_cut_bytes() > 0);
  CHECK(fs::file_size(path) + journal.num_cut_bytes() == torn.size());
}

TEST_CASE("a journal of something else, damaged, missing or in the way is refused by name") {
  const Folder folder;
  const VisitJournal ignore = [](const CriticalRays*, const ScanMatch&) {};
  {
    Journal map(folder / "map", kMapping);
    Append(map, {100, 101, 102});
    Journal localization(folder / "loc", kLocalization);
    Append(localization, {100});
  }
  const std::string map_path = (folder / "map/journal.lcm").string();
  const auto Refused = [&](const std::string& name, const JournalSubject& subject) {
    return ErrorOf([&] { ReadJournal(folder / name, subject, ignore); });
  };
  CHECK(Refused("map", kMapping).empty());
  CHECK(Refused("map", kLocalization) ==
        map_path + " is of a run that made a map: a localization needs a journal of its own");
  CHECK(Refused("loc", kMapping).find("loc/journal.lcm is of a run that localised on the map of another folder") !=
        std::string::npos);
  CHECK(Refused("map", {0.02, false}).find(map_path + ": its map has cells of 0.05 m, not of 0.02 m") == 0);
  CHECK(Refused("none", kMapping).find("none/journal.lcm") != std::string::npos);
  CHECK(ErrorOf([&] { Journal(folder / "map", kMapping); }).find(map_path + " is there already") == 0);
  std::string damaged = Content(map_path);
  for (std::size_t i = 0; i + 4 <= damaged.size(); ++i) {  // the second event's sync word
    if (i > 0 && damaged.compare(i, 4, "\xED\xA1\xDA\x01") == 0) {
      damaged[i] = 0;
      break;
    }
  }
  std::ofstream(map_path, std::ios::binary) << damaged;
  CHECK(Refused("map", kMapping).find(map_path + " is damaged in") == 0);
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
