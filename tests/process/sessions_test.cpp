// Later sessions: a map that goes on where an earlier run left it, and one that stays as it is while a robot is
// localised on it; in one process and in many.

#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>

#include "catch.hpp"
#include "common/scan/ray_selector.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/lcm_event_log.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

/// The scans `first` to `last`, in a log.
std::string WritePart(const TemporaryFolder& folder, const std::vector<LaserScan>& scans, std::size_t first,
                      std::size_t last) {
  return folder.Write(
      {scans.begin() + static_cast<std::ptrdiff_t>(first), scans.begin() + static_cast<std::ptrdiff_t>(last)},
      "part_" + std::to_string(first) + "_" + std::to_string(last) + ".lcm");
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

/// Scans of the simulated robot on another day: noise of another seed, from the middle of its way on.
std::vector<LaserScan> OtherDay(std::size_t count) {
  std::vector<LaserScan> scans = TakeScans("sim:demo", 300 + count, 1, 2);
  scans.erase(scans.begin(), scans.begin() + 300);
  return scans;
}

}  // namespace

TEST_CASE(
    "a journal in sessions, by one process or by many, holds what that of one session holds, and earlier ones stay") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 240, 2);
  folder.Map(WritePart(folder, scans, 0, 240), "whole");
  folder.Map(WritePart(folder, scans, 0, 90), "first");
  const auto before = ReadFolder(folder / "first");
  folder.MapWithStack(WritePart(folder, scans, 90, 150), "second", {"--resume", folder / "first"});
  folder.Map(WritePart(folder, scans, 150, 240), "second", {"--resume", folder / "second"});
  folder.CheckSame("second", "whole");
  CHECK(ReadFolder(folder / "first") == before);

  const auto events = ReadEvents(folder / "whole/journal/journal.lcm");
  const auto Count = [&](const std::string& channel) {
    return std::count_if(events.begin(), events.end(), [&](const auto& event) { return event.first == channel; });
  };
  CHECK(Count(kJournalHeadChannel) == 1);
  CHECK(Count(kScanMatchChannel) == 240);
  CHECK(Count(kCriticalRaysChannel) > 10);  // of the scans that were drawn
  CHECK(Count(kCriticalRaysChannel) < 120);
  CHECK(ReadEvents(folder / "second/journal/journal.lcm") == events);
}

TEST_CASE("a run that ended before its log did is finished by the whole log with --resume") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 300, 2);
  const std::string log = WritePart(folder, scans, 0, 300);
  folder.Map(log, "whole");
  folder.MapWithStack(WritePart(folder, scans, 0, 80), "out");

  const std::string said = folder.Map(log, "offline", {"--resume", folder / "out"}).errors;
  CHECK(said.find(" scans were in the map already and were skipped (utime_repeated)") != std::string::npos);
  folder.CheckSame("offline", "whole");
  folder.MapWithStack(log, "out", {"--resume", folder / "out"});
  folder.CheckSame("out", "whole");

  folder.MapWithStack(log, "out", {"--resume", folder / "out"});  // nothing left to map
  folder.CheckSame("out", "whole");
  CHECK(folder.Summary("out")["counts"]["map_updater.utime_repeated"] == 299);
}

TEST_CASE("a drive whose clock gives the times of the map anew is mapped as one, and the map stays right") {
  const TemporaryFolder folder;
  const std::string first = WritePart(folder, TakeScans("sim:demo", 900, 2), 0, 900);
  std::vector<LaserScan> scans = TakeScans("sim:demo", 1000, 1, 2);  // other noise, from elsewhere on, the same times
  scans.erase(scans.begin(), scans.begin() + 300);
  for (LaserScan& scan : scans) scan.utime -= 300 * 100'000;
  const std::string second = folder.Write(scans, "second.lcm");
  folder.Map(first, "map");
  const std::string said = folder.Map(second, "both", {"--resume", folder / "map"}).errors;
  CHECK(said.find(second + ": the map has other scans of the same times: another drive") != std::string::npos);
  CHECK(folder.Summary("both")["scans"] == 1600);
  CHECK(folder.Summary("both")["verdict"]["trust"] != "bad");

  // Each of the two is known again.
  for (const auto& [log, num] : {std::pair(first, "900"), std::pair(second, "700")}) {
    const std::string again = folder.Map(log, std::string("again_") + num, {"--resume", folder / "both"}).errors;
    CHECK(again.find(std::string(num) + " scans were in the map already and were skipped") != std::string::npos);
    folder.CheckSame(std::string("again_") + num, "both");
  }

  // The processes know scans by their times alone: they are not led to mix them up.
  const Ended stack = folder.Run(
      "run_stack", {second, "--out", folder / "stack", "--resume", folder / "map", "--lcm-url", MakeBusUrl()});
  CHECK(stack.exit_code == 1);
  CHECK(stack.errors.find("run_stack: " + second + ": the map of " + (folder / "map").string() +
                          " has other scans of the same times") == 0);
  CHECK(stack.errors.find("slam_offline " + second + " --resume ") != std::string::npos);
  CHECK_FALSE(fs::exists(folder / "stack"));
}

TEST_CASE("on a finished map the processes find the poses that one process finds, and the map stays as it is") {
  const TemporaryFolder folder;
  const std::string log = WritePart(folder, TakeScans("sim:demo", 1500, 2), 0, 1500);
  folder.Map(log, "map");
  const auto before = ReadFolder(folder / "map");
  const std::string other_day = WritePart(folder, OtherDay(150), 0, 150);

  folder.Map(other_day, "offline", {"--localize", folder / "map"});
  folder.MapWithStack(other_day, "stack", {"--localize", folder / "map"});
  folder.CheckSame("offline", "map", {"map.png", "map.yaml"});
  folder.CheckSame("stack", "offline");
  CHECK(ReadEvents(folder / "stack/journal/journal.lcm") == ReadEvents(folder / "offline/journal/journal.lcm"));
  CHECK(ReadFile(folder / "stack/trajectory.tum") != ReadFile(folder / "map/trajectory.tum"));
  CHECK(folder.Summary("offline")["scans"] == 150);
  CHECK(ReadFolder(folder / "map") == before);

  const std::vector<std::string> start{"--localize", folder / "map", "--start", "0,0,0"};  // wrong, so that it shows
  folder.Map(other_day, "offline_from", start);
  folder.MapWithStack(other_day, "stack_from", start);
  folder.CheckSame("stack_from", "offline_from");
  CHECK(ReadFile(folder / "stack_from/trajectory.tum") != ReadFile(folder / "stack/trajectory.tum"));

  // What a localization leaves is no map to go on with.
  const Ended resumed = folder.Run("slam_offline", {other_day, "--out", folder / "x", "--resume", folder / "offline"});
  CHECK(resumed.exit_code == 1);
  CHECK(resumed.errors.find("belongs to a run that localised on the map of another folder") != std::string::npos);
}

TEST_CASE("a map_updater that is killed while a robot is localised goes on with the same map, history and epoch") {
  const TemporaryFolder folder;
  folder.Map(WritePart(folder, TakeScans("sim:demo", 1500, 2), 0, 1500), "map");
  const std::string other_day = WritePart(folder, OtherDay(200), 0, 200);
  folder.Map(other_day, "offline", {"--localize", folder / "map"});

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
  folder.CheckSame("out", "offline");
}

TEST_CASE("map_updater answers a match that comes again after others with the match that is in the map") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process updater("map_updater", {"--lcm-url", url, "--lockstep"}, folder / "log");
  REQUIRE(updater.AwaitReady());
  TestBus bus(url);
  std::int64_t version = 0;
  std::vector<scan_answer_t> answers;
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& part) { version = part.version; });
  bus->Subscribe<scan_answer_t>(kScanAnswerChannel, [&](const scan_answer_t& answer) { answers.push_back(answer); });
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 2, 10);
  const auto Send = [&](const LaserScan& scan, double x_m) {
    bus->Publish(kCriticalRaysChannel, ToMessage(RaySelector({}).Select(scan)));
    bus->Publish(kScanMatchChannel, ToMessage(ScanMatch{scan.utime, {x_m, 0.0, 0.0}, 0.5, 1, 1, 0, MatchState::kOk}));
  };
  Send(scans[0], 0.0);
  REQUIRE(bus.Await([&] { return version == 1; }));
  Send(scans[1], 0.0);
  REQUIRE(bus.Await([&] { return version == 2; }));
  Send(scans[0], 1.0);
  REQUIRE(bus.Await([&] { return !answers.empty(); }));
  CHECK(answers.front().utime == scans[0].utime);
  CHECK(answers.front().requester == 0);
  REQUIRE(answers.front().num_matches == 1);
  CHECK(answers.front().matches[0].x_m == 0.0);
  bus->Publish(kScanRequestChannel, scan_request_t{1, 77});
  REQUIRE(bus.Await([&] { return answers.size() == 2; }));
  CHECK(answers.back().utime == 1);
  CHECK(answers.back().requester == 77);
  CHECK(answers.back().num_matches == 0);
  CHECK(version == 2);
  CHECK(updater.Interrupt() == 0);
}

TEST_CASE("sessions that cannot be are refused in one line") {
  const TemporaryFolder folder;
  const std::string log = WritePart(folder, TakeScans("sim:demo", 20, 2), 0, 20);
  const std::string map = folder / "map";
  folder.Map(log, "map");
  const auto before = ReadFolder(map);
  const std::string out = folder / "out";
  const std::string nothing = folder / "nothing";
  struct Case {
    std::vector<std::string> flags;
    std::string expected;
    int exit_code = 2;
  };
  const std::vector<Case> cases{
      {{"--out", out, "--resume", map, "--localize", map}, "give only one of them"},
      {{"--out", map, "--localize", map}, "--localize " + map + ": this folder must stay as it is"},
      {{"--out", out, "--resume", nothing}, nothing + "/journal/journal.lcm", 1},
      {{"--out", out, "--localize", nothing}, nothing + "/journal/journal.lcm", 1},
      {{"--out", out, "--localize", map, "--start", "1,2"}, "--start: '1,2' is not X,Y,YAW"},
      {{"--out", out, "--resume", map, "--cell-size-m", "0.1"}, "--cell-size-m 0.1: the map of " + map + "/journal"}};
  for (Case one : cases) {
    one.flags.insert(one.flags.begin(), log);
    folder.CheckRefused("slam_offline", one.flags, one.expected, one.exit_code);
    const bool also_stack = one.flags.back() != "1,2" && one.flags.back() != "0.1";  // its services refuse these
    if (also_stack) folder.CheckRefused("run_stack", one.flags, one.expected, one.exit_code);
  }
  folder.CheckRefused("slam_offline", {map + "/journal/journal.lcm", "--out", map}, "--out", 2);
  CHECK(ReadFolder(map) == before);
}

TEST_CASE("a map that is gone on with, or localised on, keeps its parameters, and refuses others by name") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 120, 2);
  const std::string all = WritePart(folder, scans, 0, 120);
  const std::vector<std::string> made_with{"--range-max-m",       "6",  "--angle-scale", "0.999",
                                           "--update-distance-m", "0.2"};
  folder.Map(all, "whole", made_with);
  const std::string first = WritePart(folder, scans, 0, 60);
  folder.Map(first, "first", made_with);
  const std::string map = folder / "first";

  folder.Map(all, "later", {"--resume", map});  // no word of the parameters
  folder.CheckSame("later", "whole");
  folder.Map(all, "same", {"--resume", map, "--range-max-m", "6", "--seed", "7"});
  folder.Map(all, "localised", {"--localize", map});
  CHECK(ReadFile(folder / "localised/map.png") == ReadFile(folder / "first/map.png"));
  CHECK(folder.Summary("localised")["parameters"]["slam_offline"]["range_max_m"] == 6.0);

  std::ofstream(folder / "config.toml") << "seed = 1\nangle_scale = 1.0\n";
  const std::string config = folder / "config.toml";
  const std::string was = ": the map of " + map + "/journal was made with ";
  for (const std::string how : {"--resume", "--localize"}) {
    for (const auto& [flag, value, said] : std::vector<std::array<std::string, 3>>{
             {"--range-max-m", "30", "--range-max-m 30" + was + "6; remove this setting, or set --range-max-m 6"},
             {"--preset", "sick", "sick:"},
             {"--config", config, config + ":2: angle_scale = 1" + was + "0.999"}}) {
      folder.CheckRefused("slam_offline", {all, "--out", folder / "x", how, map, flag, value}, said, 2);
    }
  }
  CHECK_FALSE(fs::exists(folder / "x/map.png"));

  // map_updater hears scans that ray_selector made: both are told the laser's parameters, or neither maps.
  const std::vector<std::string> updater{"--lcm-url", MakeBusUrl(), "--journal", map + "/journal", "--resume"};
  folder.CheckRefused("map_updater", updater, "--range-max-m 6 --angle-scale 0.999: give map_updater and ray_selector",
                      2);
  std::vector<std::string> told = updater;
  told.insert(told.end(), {"--range-max-m", "6", "--angle-scale", "0.999"});
  Process process("map_updater", told, folder / "log");
  CHECK(process.AwaitReady());
  CHECK(process.Interrupt() == 0);
  told.insert(told.end(), {"--update-distance-m", "0.4"});
  folder.CheckRefused("map_updater", told, "--update-distance-m 0.4" + was + "0.2", 2);
}

TEST_CASE("where the scans contradicted the sweep of a preset, the map is localised on with the same preset") {
  const TemporaryFolder folder;
  const std::string log = WritePart(folder, TakeScans("sim:demo", 700), 0, 700);
  folder.Map(log, "map", {"--preset", "rplidar-a1"});
  REQUIRE(folder.Summary("map")["parameters"]["slam_offline"]["sweep_s"] == 0.0);
  folder.Map(log, "localised", {"--preset", "rplidar-a1", "--localize", folder / "map"});
  CHECK(folder.Summary("localised")["parameters"]["slam_offline"]["sweep_s"] == 0.0);
  folder.CheckRefused("slam_offline", {log, "--out", folder / "x", "--localize", folder / "map", "--sweep-s", "0.15"},
                      "--sweep-s 0.15: the map of", 2);
}

TEST_CASE("a journal with zeros at its end is gone on with, and one that is damaged in the middle when that is said") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 60, 2);
  const std::string log = WritePart(folder, scans, 0, 60);
  folder.Map(log, "map");
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
  const std::string said = folder.Map(log, "localised", {"--localize", folder / "map", "--until-damage"}).errors;
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
  CHECK(folder.Map(cut, "out").errors.find("slam_offline: " + said) != std::string::npos);
  CHECK(folder.Summary("out")["counts"]["truncated"] == 1);
  const Ended converted =
      folder.Run("laser_publisher", {cut, "--lcm-url", "file://" + (folder / "x.lcm").string() + "?mode=w"});
  CHECK(converted.exit_code == 0);
  CHECK(converted.errors.find("laser_publisher: " + said) != std::string::npos);
  CHECK(folder.Map(log, "all").errors.find("truncated") == std::string::npos);
}
