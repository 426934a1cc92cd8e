// Later sessions: a map that goes on where an earlier run left it, and one that stays as it is while a robot is
// localised on it; in one process and in many.

#include <algorithm>
#include <csignal>
#include <fstream>

#include "catch.hpp"
#include "common/scan/ray_selector.hpp"
#include "processes.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/lcm_event_log.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::string kRunStack = CRSM_SOURCE_DIR "/scripts/run_stack";
const std::vector<std::string> kMapFiles{"map.png", "map.yaml", "trajectory.tum"};

void CheckSameFiles(const fs::path& folder, const fs::path& expected, const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    INFO(folder / file);
    const std::string content = ReadFile(folder / file);
    CHECK_FALSE(content.empty());
    CHECK(content == ReadFile(expected / file));
  }
}

/// Every second scan of the simulated robot, `first` to `last` of them, in a log.
std::string WritePart(const TemporaryFolder& folder, const std::vector<LaserScan>& scans, std::size_t first,
                      std::size_t last) {
  const fs::path path = folder / ("part_" + std::to_string(first) + "_" + std::to_string(last) + ".lcm");
  WriteScans({scans.begin() + static_cast<std::ptrdiff_t>(first), scans.begin() + static_cast<std::ptrdiff_t>(last)},
             path);
  return path.string();
}

std::string MapOffline(const TemporaryFolder& folder, const std::string& log, const std::string& out,
                       std::vector<std::string> flags = {}) {
  flags.insert(flags.end(), {log, "--out", folder / out});
  Process process("slam_offline", flags, folder / "log");
  REQUIRE(process.AwaitExit() == 0);
  return process.errors();
}

void MapWithStack(const TemporaryFolder& folder, const std::string& log, const std::string& out,
                  std::vector<std::string> flags = {}) {
  flags.insert(flags.begin(), {log, "--out", folder / out, "--lcm-url", MakeBusUrl()});
  Process process(kRunStack, flags, folder / "log");
  const int exit_code = process.AwaitExit();
  INFO(process.errors());
  REQUIRE(exit_code == 0);
}

/// Channel and data of every event but the checks, which tell of sessions and disks, the head, whose epoch is drawn,
/// and what loops have brought, which comes when it is found.
std::vector<std::pair<std::string, std::string>> ReadEvents(const fs::path& journal) {
  LcmEventLog log(journal.string());
  std::vector<std::pair<std::string, std::string>> events;
  while (const auto event = log.Next()) {
    if (event->channel == kJournalCheckChannel || event->channel == kPoseGraphChannel) continue;
    events.emplace_back(event->channel, event->channel == kJournalHeadChannel ? "" : std::string(event->data));
  }
  return events;
}

/// The name and the content of every file in a folder.
std::map<std::string, std::string> ReadFolder(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[entry.path().string()] = ReadFile(entry.path());
  }
  return files;
}

/// Scans of the simulated robot on another day: noise of another seed, from the middle of its way on.
std::vector<LaserScan> OtherDay(std::size_t count) {
  const auto source = OpenLaserSource("sim:demo", {2});
  std::vector<LaserScan> scans;
  for (std::size_t i = 0; i < 300; ++i) source->Next();
  while (scans.size() < count) scans.push_back(source->Next().value());
  return scans;
}

}  // namespace

TEST_CASE("a log mapped in three sessions, by one process or by many in turn, gives the files of one session") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 240, 2);
  const std::string all = WritePart(folder, scans, 0, 240);
  MapOffline(folder, all, "whole");
  fs::remove(all);
  const std::vector<std::string> parts{WritePart(folder, scans, 0, 90), WritePart(folder, scans, 90, 150),
                                       WritePart(folder, scans, 150, 240)};

  MapOffline(folder, parts[0], "mixed_1");
  const auto before = ReadFolder(folder / "mixed_1");
  MapWithStack(folder, parts[1], "mixed_2", {"--resume", folder / "mixed_1"});
  MapOffline(folder, parts[2], "mixed_3", {"--resume", folder / "mixed_2"});
  CheckSameFiles(folder / "mixed_3", folder / "whole", kMapFiles);
  CHECK(ReadFolder(folder / "mixed_1") == before);

  MapWithStack(folder, parts[0], "own");
  MapOffline(folder, parts[1], "own", {"--resume", folder / "own"});
  MapWithStack(folder, parts[2], "own", {"--resume", folder / "own"});
  CheckSameFiles(folder / "own", folder / "whole", kMapFiles);

  const auto events = ReadEvents(folder / "whole/journal/journal.lcm");
  const auto CountOf = [&](const std::string& channel) {
    return std::count_if(events.begin(), events.end(), [&](const auto& event) { return event.first == channel; });
  };
  CHECK(CountOf(kJournalHeadChannel) == 1);
  CHECK(CountOf(kScanMatchChannel) == 240);
  CHECK(CountOf(kCriticalRaysChannel) > 10);  // of the scans that were drawn
  CHECK(CountOf(kCriticalRaysChannel) < 120);
  for (const char* out : {"mixed_3", "own"}) {
    INFO(out);
    CHECK(ReadEvents(folder / out / "journal/journal.lcm") == events);
  }
}

TEST_CASE("a run that ended before its log did is finished by the whole log with --resume") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 300, 2);
  const std::string log = WritePart(folder, scans, 0, 300);
  MapOffline(folder, log, "whole");
  MapWithStack(folder, WritePart(folder, scans, 0, 80), "out");

  const std::string said = MapOffline(folder, log, "offline", {"--resume", folder / "out"});
  CHECK(said.find(" scans were in the map already and were skipped (utime_repeated)") != std::string::npos);
  CheckSameFiles(folder / "offline", folder / "whole", kMapFiles);
  MapWithStack(folder, log, "out", {"--resume", folder / "out"});
  CheckSameFiles(folder / "out", folder / "whole", kMapFiles);

  MapWithStack(folder, log, "out", {"--resume", folder / "out"});  // nothing left to map
  CheckSameFiles(folder / "out", folder / "whole", kMapFiles);
  CHECK(ReadFile(folder / "out/summary.json").find("\"map_updater.utime_repeated\": 299,") != std::string::npos);
}

TEST_CASE("on a finished map the processes find the poses that one process finds, and the map stays as it is") {
  const TemporaryFolder folder;
  const std::string log = WritePart(folder, TakeScans("sim:demo", 1500, 2), 0, 1500);
  MapOffline(folder, log, "map");
  const auto before = ReadFolder(folder / "map");
  const std::string other_day = WritePart(folder, OtherDay(150), 0, 150);

  MapOffline(folder, other_day, "offline", {"--localize", folder / "map"});
  MapWithStack(folder, other_day, "stack", {"--localize", folder / "map"});
  CheckSameFiles(folder / "offline", folder / "map", {"map.png", "map.yaml"});
  CheckSameFiles(folder / "stack", folder / "offline", kMapFiles);
  CHECK(ReadEvents(folder / "stack/journal/journal.lcm") == ReadEvents(folder / "offline/journal/journal.lcm"));
  CHECK(ReadFile(folder / "stack/trajectory.tum") != ReadFile(folder / "map/trajectory.tum"));
  CHECK(ReadFile(folder / "offline/summary.json").find("\"scans\": 150,") != std::string::npos);
  CHECK(ReadFolder(folder / "map") == before);

  const std::vector<std::string> start{"--localize", folder / "map", "--start", "0,0,0"};  // wrong, so that it shows
  MapOffline(folder, other_day, "offline_from", start);
  MapWithStack(folder, other_day, "stack_from", start);
  CheckSameFiles(folder / "stack_from", folder / "offline_from", kMapFiles);
  CHECK(ReadFile(folder / "stack_from/trajectory.tum") != ReadFile(folder / "stack/trajectory.tum"));

  // What a localization leaves is no map to go on with.
  Process resumed("slam_offline", {other_day, "--out", folder / "x", "--resume", folder / "offline"}, folder / "log");
  CHECK(resumed.AwaitExit() == 1);
  CHECK(resumed.errors().find("belongs to a run that localised on the map of another folder") != std::string::npos);
}

TEST_CASE("a map_updater that is killed while a robot is localised goes on with the same map, history and epoch") {
  const TemporaryFolder folder;
  MapOffline(folder, WritePart(folder, TakeScans("sim:demo", 1500, 2), 0, 1500), "map");
  const std::string other_day = WritePart(folder, OtherDay(200), 0, 200);
  MapOffline(folder, other_day, "offline", {"--localize", folder / "map"});

  const std::string config = folder / "config.toml";
  const std::string keys =
      "localize = '" + (folder / "map").string() + "'\njournal = '" + (folder / "out/journal").string() + "'\n";
  std::ofstream(config) << keys;
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  TestBus bus(url);
  std::int64_t epoch = 0;
  int num_epochs = 0;
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& delta) {
    num_epochs += delta.epoch != epoch;
    epoch = delta.epoch;
  });
  Stack stack({url, folder / "out", {"--config", config}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(other_day, "max"));
  std::ofstream(config) << keys << "resume = true\n";
  for (const std::int64_t version : {20, 60, 100}) {
    REQUIRE(watcher.AwaitVersion(version));
    REQUIRE(stack.Start("map_updater"));
  }
  CHECK(stack.Finish());
  CHECK(bus.Await([&] { return epoch != 0; }));
  bus->Wait(0);
  CHECK(num_epochs == 1);
  CheckSameFiles(folder / "out", folder / "offline", kMapFiles);
}

TEST_CASE("map_updater answers a match that comes again after others with the version that there is") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process updater("map_updater", {"--lcm-url", url, "--lockstep"}, folder / "log");
  REQUIRE(updater.AwaitReady());
  TestBus bus(url);
  std::vector<map_delta_t> parts;
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& part) { parts.push_back(part); });
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 2, 10);
  const auto Send = [&](const LaserScan& scan, MatchState state) {
    parts.clear();
    bus->Publish(kCriticalRaysChannel, ToMessage(RaySelector({}).Select(scan)));
    bus->Publish(kScanMatchChannel, ToMessage(ScanMatch{scan.utime, {}, 0.5, 1, 1, 0, state}));
    REQUIRE(bus.Await([&] { return !parts.empty() && parts.size() >= static_cast<std::size_t>(parts[0].num_parts); }));
  };
  Send(scans[0], MatchState::kFirst);
  CHECK(parts.front().num_tiles > 0);
  Send(scans[1], MatchState::kOk);
  Send(scans[0], MatchState::kOk);
  REQUIRE(parts.size() == 1);
  CHECK(parts.front().utime == scans[0].utime);
  CHECK(parts.front().version == 2);
  CHECK(parts.front().base_version == 2);
  CHECK(parts.front().num_tiles == 0);
  CHECK(parts.front().num_matches == 0);
  CHECK(updater.Interrupt() == 0);
}

TEST_CASE("sessions that cannot be are refused in one line") {
  const TemporaryFolder folder;
  const std::string log = WritePart(folder, TakeScans("sim:demo", 20, 2), 0, 20);
  const std::string map = folder / "map";
  MapOffline(folder, log, "map");
  const auto before = ReadFolder(map);
  const auto CheckRefused = [&](std::vector<std::string> flags, const std::string& expected, bool also_stack = true) {
    flags.insert(flags.begin(), log);
    for (const std::string& program : {std::string("slam_offline"), kRunStack}) {
      if (program == kRunStack && !also_stack) continue;
      Process process(program, flags, folder / "log");
      CHECK(process.AwaitExit() != 0);
      const std::string errors = process.errors();
      INFO(program << " " << errors);
      CHECK(errors.find(expected) != std::string::npos);
      CHECK(std::count(errors.begin(), errors.end(), '\n') == 1);
    }
  };
  const std::string out = folder / "out";
  const std::string nothing = folder / "nothing";
  CheckRefused({"--out", out, "--resume", map, "--localize", map}, "give only one of them");
  CheckRefused({"--out", map, "--localize", map}, "--localize " + map + ": this folder must stay as it is");
  CheckRefused({"--out", out, "--resume", nothing}, nothing + "/journal/journal.lcm");
  CheckRefused({"--out", out, "--localize", nothing}, nothing + "/journal/journal.lcm");
  CheckRefused({"--out", out, "--localize", map, "--start", "1,2"}, "--start: '1,2' is not X,Y,YAW", false);
  CheckRefused({"--out", out, "--resume", map, "--cell-size-m", "0.1"},
               "--cell-size-m 0.1: the map of " + map + "/journal was made with 0.05", false);
  Process own_log("slam_offline", {map + "/journal/journal.lcm", "--out", map}, folder / "log");
  CHECK(own_log.AwaitExit() == 2);
  CHECK(own_log.errors().find("the log to read is the journal in this folder") != std::string::npos);
  CHECK(ReadFolder(map) == before);
}

TEST_CASE("a map that is gone on with, or localised on, keeps its parameters, and refuses others by name") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 120, 2);
  const std::string all = WritePart(folder, scans, 0, 120);
  const std::vector<std::string> made_with{"--range-max-m",       "6",  "--angle-scale", "0.999",
                                           "--update-distance-m", "0.2"};
  MapOffline(folder, all, "whole", made_with);
  const std::string first = WritePart(folder, scans, 0, 60);
  MapOffline(folder, first, "first", made_with);
  const std::string map = folder / "first";

  MapOffline(folder, all, "later", {"--resume", map});  // no word of the parameters
  CheckSameFiles(folder / "later", folder / "whole", kMapFiles);
  MapOffline(folder, all, "same", {"--resume", map, "--range-max-m", "6", "--num-evaluations", "1999"});
  MapOffline(folder, all, "localised", {"--localize", map});
  CHECK(ReadFile(folder / "localised/map.png") == ReadFile(folder / "first/map.png"));
  CHECK(ReadFile(folder / "localised/summary.json").find("\"range_max_m\": 6.0") != std::string::npos);

  std::ofstream(folder / "config.toml") << "seed = 1\nangle_scale = 1.0\n";
  const std::string config = folder / "config.toml";
  const auto CheckRefused = [&](const std::string& program, std::vector<std::string> flags, const std::string& said) {
    Process process(program, flags, folder / "log");
    CHECK(process.AwaitExit() != 0);
    const std::string errors = process.errors();
    INFO(errors);
    CHECK(errors.find(said) != std::string::npos);
    CHECK(std::count(errors.begin(), errors.end(), '\n') == 1);
  };
  const std::string was = ": the map of " + map + "/journal was made with ";
  for (const std::string how : {"--resume", "--localize"}) {
    const auto CheckOffline = [&](const std::string& flag, const std::string& value, const std::string& said) {
      CheckRefused("slam_offline", {all, "--out", folder / "x", how, map, flag, value}, said);
    };
    CheckOffline("--range-max-m", "30", "--range-max-m 30" + was + "6; remove this setting, or set --range-max-m 6");
    CheckOffline("--preset", "sick", "sick:");
    CheckOffline("--config", config, config + ":2: angle_scale = 1" + was + "0.999");
  }
  CHECK_FALSE(fs::exists(folder / "x/map.png"));

  // map_updater hears scans that ray_selector made: both are told the laser's parameters, or neither maps.
  const std::vector<std::string> updater{"--lcm-url", MakeBusUrl(), "--journal", map + "/journal", "--resume"};
  CheckRefused("map_updater", updater,
               "was made with --range-max-m 6 --angle-scale 0.999: give map_updater and ray_selector the same flags");
  std::vector<std::string> told = updater;
  told.insert(told.end(), {"--range-max-m", "6", "--angle-scale", "0.999"});
  Process process("map_updater", told, folder / "log");
  CHECK(process.AwaitReady());
  CHECK(process.Interrupt() == 0);
  told.insert(told.end(), {"--update-distance-m", "0.4"});
  CheckRefused("map_updater", told, "--update-distance-m 0.4" + was + "0.2");
}

TEST_CASE("a journal with zeros at its end is gone on with, and one that is damaged in the middle when that is said") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 60, 2);
  const std::string log = WritePart(folder, scans, 0, 60);
  MapOffline(folder, log, "map");
  const fs::path journal = folder / "map/journal/journal.lcm";
  const std::string whole = ReadFile(journal);
  const std::string url = MakeBusUrl();
  const auto Start = [&](std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--lcm-url", url, "--journal", folder / "map/journal", "--resume"});
    return Process("map_updater", flags, folder / "log");
  };

  std::ofstream(journal, std::ios::binary) << whole + std::string(5000, '\0');
  Process torn = Start({});
  CHECK(torn.AwaitReady());
  CHECK(torn.errors().find("the last 5000 bytes are left out; 60 scans remain") != std::string::npos);
  CHECK(torn.Interrupt() == 0);
  CHECK(ReadFile(journal) == whole);

  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 4;
  std::ofstream(journal, std::ios::binary) << damaged;
  Process refused = Start({});
  CHECK(refused.AwaitExit() == 1);
  CHECK(refused.errors().find(" is damaged at byte ") != std::string::npos);
  CHECK(refused.errors().find("--until-damage") != std::string::npos);
  CHECK(ReadFile(journal) == damaged);
  const std::string said = MapOffline(folder, log, "localised", {"--localize", folder / "map", "--until-damage"});
  CHECK(said.find(": damaged at byte ") != std::string::npos);
  Process taken = Start({"--until-damage"});
  CHECK(taken.AwaitReady());
  CHECK(taken.errors().find(" scans remain; the original file is now ") != std::string::npos);
  CHECK(taken.Interrupt() == 0);
  CHECK(ReadFile(journal.string() + ".damaged") == damaged);
}

TEST_CASE("a log whose gzip is cut short is mapped up to there, and that is said in one line") {
  const TemporaryFolder folder;
  const std::string log = WritePart(folder, TakeScans("sim:demo", 60, 2), 0, 60);
  const std::string whole = Compress(ReadFile(log));
  const std::string cut = folder / "cut.lcm.gz";
  std::ofstream(cut, std::ios::binary) << whole.substr(0, whole.size() / 2);
  const std::string said =
      cut + " is cut short or damaged at its end: only the scans before that were read (truncated)\n";
  CHECK(MapOffline(folder, cut, "out").find("slam_offline: " + said) != std::string::npos);
  CHECK(ReadFile(folder / "out/summary.json").find("\"truncated\": 1") != std::string::npos);
  Process converter("laser_publisher", {cut, "--lcm-url", "file://" + (folder / "x.lcm").string() + "?mode=w"},
                    folder / "log");
  CHECK(converter.AwaitExit() == 0);
  CHECK(converter.errors().find("laser_publisher: " + said) != std::string::npos);
  CHECK(MapOffline(folder, log, "all").find("truncated") == std::string::npos);
}
