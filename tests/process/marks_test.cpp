// Places with names: on the bus, in the journal, with a killed owner, and in the files of results.

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "catch.hpp"
#include "common/results/mark_files.hpp"
#include "processes.hpp"
#include "services/bus/bus_role.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

mark_t Seen(std::int64_t utime, const std::string& id, double x_m) {
  return ToMessage(Mark{utime, id, "victim", "", MarkAction::kSeen, false, 0.3, {{x_m, 0.0}}});
}

/// Who sends marks until each is answered, as the type asks for.
struct Reporter {
  explicit Reporter(TestBus& of) : bus(of) {
    bus->Subscribe<mark_t>(kMarkAnswerChannel, [this](const mark_t& mark) {
      std::erase_if(left, [&](const mark_t& sent) { return sent.id == mark.id && sent.utime == mark.utime; });
    });
  }
  bool Send(std::vector<mark_t> marks) {
    left = std::move(marks);
    return bus.Await([&] {
      for (const mark_t& mark : std::vector<mark_t>(left)) bus->Publish(kMarkChannel, mark);
      return left.empty();
    });
  }

  TestBus& bus;
  std::vector<mark_t> left;
};

/// As the files of a run have it.
std::optional<PlacedMark> FindMark(const fs::path& out, const std::string& id) {
  for (const PlacedMark& mark : ReadMarks(out)) {
    if (mark.id == id) return mark;
  }
  return std::nullopt;
}

}  // namespace

TEST_CASE("marks reach the results, each once, though the owner of the map is killed again and again") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 300, 2);
  const std::string log = folder.Write(scans, "run.lcm");
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  Reporter sender(bus);
  int num_matches = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t&) { ++num_matches; });
  Process stack = folder.StartStack(log, "out", url, {"--rate", "8"});
  REQUIRE(bus.Await([&] { return num_matches > 0; }));
  std::size_t num_sent = 0;
  for (int round = 0; round < 4; ++round) {
    REQUIRE(bus.Await([&] { return num_matches > 40 * round + 10; }));
    std::vector<mark_t> marks;
    for (int i = 0; i < 10; ++i) {
      const std::size_t scan = static_cast<std::size_t>(40 * round + i);
      marks.push_back(Seen(scans[scan].utime, "v" + std::to_string(i % 2), 1.0));
      ++num_sent;
    }
    if (round > 0) kill(FindChild(stack.pid(), "map_updater"), SIGKILL);
    REQUIRE(sender.Send(marks));
    REQUIRE(sender.Send(marks));  // once more: they are known
  }
  REQUIRE(bus.Await([&] { return !stack.IsRunning(); }));
  CHECK(stack.AwaitExit() == 0);
  std::size_t num_kept = 0;
  for (const PlacedMark& mark : ReadMarks(folder / "out")) num_kept += static_cast<std::size_t>(mark.num_sightings);
  CHECK(num_kept == num_sent);
  CHECK(ReadMarks(folder / "out").size() == 2);
  // Who goes on with the map has them as well, and adds to them.
  std::ofstream(folder / "more.csv") << "x_m,y_m,kind,name\n1,2,door,front\n";
  folder.Map(folder.Write(TakeScans("sim:demo", 20, 2, 2), "more.lcm"), "more",
             {"--resume", folder / "out", "--marks", folder / "more.csv"});
  CHECK(ReadMarks(folder / "more").size() == 3);
  CHECK(FindMark(folder / "more", "v0")->num_sightings == FindMark(folder / "out", "v0")->num_sightings);
  CHECK(FindMark(folder / "more", "door of line 2")->name == "front");
}

TEST_CASE("whoever sees a place may say so; who has the role of a guide alone moves and removes it") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 200, 2);
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  Reporter sender(bus);
  int num_matches = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t&) { ++num_matches; });
  Process stack = folder.StartStack(folder.Write(scans, "run.lcm"), "out", url, {"--rate", "3", "--team", "Pandora"});
  REQUIRE(bus.Await([&] { return num_matches > 20; }));
  REQUIRE(sender.Send({Seen(scans[10].utime, "a", 1.0), Seen(scans[10].utime, "b", 2.0)}));
  const mark_t remove = ToMessage(Mark{7, "a", "", "", MarkAction::kRemoved, true, 0.1, {}});
  const mark_t move = ToMessage(Mark{8, "b", "hazard", "gas", MarkAction::kMoved, true, 0.1, {{0.5, 0.25}}});
  CHECK(bus.Await([&] {
    bus->Publish(kMarkChannel, remove);
    return stack.errors().find("MARK from ") != std::string::npos;
  }));
  CHECK(stack.errors().find(" is refused: only map_viewer, or another process with the role guide") !=
        std::string::npos);
  {
    const BusRole role({url, ""}, kGuideRole);
    CHECK(sender.Send({remove, move}));
  }
  // What cannot be, and what nobody can be sure of, is counted, and the run goes on.
  mark_t far = Seen(scans[10].utime + 3'600'000'000, "c", 1.0);
  mark_t no_number = Seen(scans[10].utime, "d", NAN);
  CHECK(bus.Await([&] {
    bus->Publish(kMarkChannel, far);
    bus->Publish(kMarkChannel, no_number);
    return bus.Count("map_updater.MARK_malformed") > 0 && bus.Count("map_updater.marks_refused") > 1;
  }));
  REQUIRE(bus.Await([&] { return !stack.IsRunning(); }));
  CHECK(stack.AwaitExit() == 0);
  const auto marks = ReadMarks(folder / "out");
  REQUIRE(marks.size() == 1);
  CHECK(marks[0].id == "b");
  CHECK(marks[0].kind == "hazard");
  CHECK(std::hypot(marks[0].points[0].x_m - 0.5, marks[0].points[0].y_m - 0.25) < 1e-9);
  CHECK(fs::file_size(folder / "out/map.tif") > 1000);
}

TEST_CASE("slam_offline and the processes fix the same marks to the same places; slam_eval export gives them out") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 200, 2);
  const std::string log = folder.Write(scans, "run.lcm");
  const auto Seconds = [&](std::size_t scan) { return std::to_string(static_cast<double>(scans[scan].utime) * 1e-6); };
  std::ofstream(folder / "marks.csv") << "time_s,x_m,y_m,kind,id,radius_m\n"
                                      << Seconds(50) << ",1,0,victim,v,0.3\n"
                                      << Seconds(90) << ",1,0,victim,v,0.3\n"
                                      << ",0;3;3,0;0;2,keep-out,zone,0.3\n"
                                      << "999999,,,door,lost,\n";
  const Ended offline = folder.Map(log, "offline", {"--marks", folder / "marks.csv"});
  CHECK(offline.errors.find("marks.csv:5: is left out: no scan was matched within 0.5 s") != std::string::npos);
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  Reporter sender(bus);
  int num_matches = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t&) { ++num_matches; });
  Process stack = folder.StartStack(log, "out", url, {"--rate", "8"});
  REQUIRE(bus.Await([&] { return num_matches > 100; }));
  REQUIRE(sender.Send({Seen(scans[50].utime, "v", 1.0), Seen(scans[90].utime, "v", 1.0)}));
  REQUIRE(bus.Await([&] { return !stack.IsRunning(); }));
  const auto one = FindMark(folder / "offline", "v");
  const auto other = FindMark(folder / "out", "v");
  REQUIRE((one && other));
  CHECK(std::hypot(one->points[0].x_m - other->points[0].x_m, one->points[0].y_m - other->points[0].y_m) < 0.05);
  CHECK(one->num_sightings == other->num_sightings);

  const Ended exported =
      folder.Run("slam_eval", {"export", folder / "offline", "--out", folder / "export", "--team", "Pandora"});
  CHECK(exported.exit_code == 0);
  CHECK(exported.output.find("2 places; in ") == 0);
  for (const char* name : {"map.tif", "keepout.png", "keepout.yaml", "marks.csv"})
    CHECK(fs::exists(folder / "export" / name));
  CHECK(ReadFile(folder / "export/marks.geojson") == ReadFile(folder / "offline/marks.geojson"));
  folder.CheckRefused("slam_eval", {"export", folder / "nowhere"}, "nowhere", 1);

  const std::string edits = folder / "my_edits.json";
  std::ofstream(edits)
      << R"({"crop_m": [[-1, -1], [3, 3]], "erase": [{"outline_m": [[0,0],[1,0],[1,1]]}], "turn_deg": 20})";
  const std::string map = ReadFile(folder / "offline/map.png");
  const Ended edited = folder.Run("slam_eval", {"export", folder / "offline", "--edits", edits});
  CHECK(edited.exit_code == 0);
  CHECK(edited.output.find("map_edited.png, map_edited.yaml, keepout_edited.png, keepout_edited.yaml\n") !=
        std::string::npos);
  CHECK(ReadFile(folder / "offline/map.png") == map);
  CHECK(ReadFile(folder / "offline/map_edited.png") != map);
  CHECK(ReadFile(folder / "offline/map_edited.yaml").find("\nimage: map_edited.png\n") != std::string::npos);
  CHECK(ReadFile(folder / "offline/edits.json").find("\"T_edited_map\"") != std::string::npos);
  std::ofstream(edits) << R"({"crop_m": [[-1, -1], [3, "NaN"]]})";
  const std::string before = ReadFile(folder / "offline/map_edited.png");
  folder.CheckRefused("slam_eval", {"export", folder / "offline", "--edits", edits}, "my_edits.json: crop_m[1]: ", 1);
  folder.CheckRefused("slam_eval", {"export", folder / "offline", "--edits", "/no/such.json"}, "/no/such.json", 1);
  CHECK(ReadFile(folder / "offline/map_edited.png") == before);
  std::ofstream(folder / "bad.csv") << "kind,colour\n";
  folder.CheckRefused("slam_offline", {log, "--out", folder / "bad", "--marks", folder / "bad.csv"},
                      "bad.csv:1: 'colour'", 1);
  CHECK_FALSE(fs::exists(folder / "bad"));
}
