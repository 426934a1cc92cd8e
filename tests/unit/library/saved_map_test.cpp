#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <crsm_slam/slam.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "common/logs/read_map.hpp"
#include "common/worlds/simulator.hpp"
#include "scratch.hpp"
#include "services/base/path_lock.hpp"
#include "services/journal/journal.hpp"

namespace crsm {
namespace {

/// The scans of a simulated drive, with where they were taken.
struct Drive {
  std::vector<crsm_slam::Scan> scans;
  std::vector<Pose2> T_start_laser;
};

Drive TakeDrive(const std::string& world, std::size_t most, std::uint64_t seed = 1) {
  Simulator simulator(LoadWorld(world), seed);
  Drive drive;
  while (const auto scan = simulator.Next()) {
    if (drive.scans.size() == most) break;
    drive.scans.push_back({scan->utime, scan->angle_min_rad, scan->angle_step_rad, scan->ranges_m});
    drive.T_start_laser.push_back(*simulator.TruePose());
  }
  return drive;
}

void CheckSameMap(const crsm_slam::Map& a, const crsm_slam::Map& b) {
  CHECK(a.width_cells == b.width_cells);
  CHECK(a.T_map_grid.x_m == b.T_map_grid.x_m);
  CHECK((a.cells == b.cells));
}

double DistanceOf(const crsm_slam::Pose& a, const Pose2& b) { return Distance({a.x_m, a.y_m, a.yaw_rad}, b); }

}  // namespace

TEST_CASE("a saved map is the same when it is loaded, and can be saved again, and mapped on") {
  const bool with_loops = GENERATE(true, false);
  CAPTURE(with_loops);
  const Drive drive = TakeDrive("block", with_loops ? 1600 : 300);
  const std::size_t num_first = with_loops ? 1300 : 200;
  const ScratchFolder folder;
  crsm_slam::Slam first({.preset = "sick", .loops = with_loops});
  for (std::size_t i = 0; i < num_first; ++i) first.Process(drive.scans[i]);
  const std::string path = folder.path().string() + "/run";
  first.Save(path);
  first.Save(path);  // in place of what was saved before
  crsm_slam::Slam second = crsm_slam::Slam::Load(path);
  CheckSameMap(second.MakeMap(), first.MakeMap());
  CHECK(ReadMap(path).cells == first.MakeMap().cells);
  CHECK(second.Trajectory().size() == num_first);
  CHECK(second.Loops().size() == first.Loops().size());
  second.Save(folder.path().string() + "/again");
  CHECK_FALSE(std::filesystem::exists(path + "/earlier.1"));
  crsm_slam::Slam().Save(path);  // of another map: what is there is kept
  CHECK(crsm_slam::Slam::Load(path + "/earlier.1").Trajectory().size() == first.Trajectory().size());
  CheckSameMap(crsm_slam::Slam::Load(folder.path().string() + "/again").MakeMap(), first.MakeMap());

  int num_lost = 0;
  for (std::size_t i = num_first; i < drive.scans.size(); ++i) {
    num_lost += second.Process(drive.scans[i]).state == crsm_slam::State::kLost;
  }
  CHECK(num_lost == 0);
  CHECK(second.Trajectory().size() == drive.scans.size());
  CHECK(DistanceOf(second.Trajectory().back().T_map_laser, drive.T_start_laser.back()) < 0.2);
  CHECK(second.Loops().empty() != with_loops);
  CHECK_THROWS_AS(second.Process(drive.scans[5]), std::invalid_argument);  // its utime is in the map
}

TEST_CASE("no map is saved over another one, and no other state of a map over a later one") {
  const Drive drive = TakeDrive("demo", 90);
  const ScratchFolder folder;
  const std::string path = folder.path().string();
  const auto NumScansIn = [&](const std::string& name) {
    return crsm_slam::Slam::Load(path + name).Trajectory().size();
  };
  crsm_slam::Slam one({.preset = "sick"});
  crsm_slam::Slam other({.preset = "sick"});
  for (std::size_t i = 0; i < 60; ++i) one.Process(drive.scans[i]);
  for (std::size_t i = 0; i < 30; ++i) other.Process(drive.scans[i]);
  one.Save(path);
  CHECK(one.LoadNotice().empty());
  other.Save(path);
  CHECK(other.LoadNotice() == "the results of another map in " + path + " are now in " + path + "/earlier.1");
  one.Save(path);
  CHECK(NumScansIn("") == 60);
  CHECK(NumScansIn("/earlier.1") == 60);
  CHECK(NumScansIn("/earlier.2") == 30);

  crsm_slam::Slam later = crsm_slam::Slam::Load(path);
  for (std::size_t i = 60; i < 90; ++i) later.Process(drive.scans[i]);
  later.Save(path);  // the same map, further on
  CHECK_FALSE(std::filesystem::exists(path + "/earlier.3"));
  one.Save(path);
  CHECK(NumScansIn("") == 60);
  CHECK(NumScansIn("/earlier.3") == 90);
}

TEST_CASE("a map whose summary is of another one is not loaded, and the folder is named") {
  const Drive drive = TakeDrive("demo", 30);
  const ScratchFolder folder;
  const std::string path = folder.path().string();
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.Save(path + "/one");
  crsm_slam::Slam().Save(path + "/other");
  std::filesystem::copy_file(path + "/other/summary.json", path + "/one/summary.json",
                             std::filesystem::copy_options::overwrite_existing);
  CHECK(ErrorOf([&] {
          crsm_slam::Slam::Load(path + "/one");
        }).starts_with(path + "/one: its summary.json is of another map than its journal"));
}

TEST_CASE("a folder to which somebody writes is not saved to, and who it is is said") {
  const Drive drive = TakeDrive("demo", 30);
  const ScratchFolder folder;
  const std::string path = folder.path().string();
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.Save(path);
  std::filesystem::create_directory(path + "/log");
  for (const char* name : {"", "/journal/journal.lcm", "/log"}) {  // of slam_offline, map_updater, run_stack
    const PathLock lock("--out", path + name);
    const std::string error = ErrorOf([&] { crsm_slam::Slam().Save(path); });
    CHECK(error.starts_with("Save: " + path + name + ": process " + std::to_string(getpid()) + " ("));
    CHECK(error.ends_with(" writes there; stop it, or choose another path"));
  }
  CHECK(crsm_slam::Slam::Load(path).Trajectory().size() == 30);
  CHECK_FALSE(std::filesystem::exists(path + "/earlier.1"));
}

TEST_CASE("a saved map has its verdict, its identity and its other pieces") {
  Drive drive = TakeDrive("block", 700);
  drive.scans.erase(drive.scans.begin() + 300, drive.scans.begin() + 600);
  for (std::size_t i = 300; i < drive.scans.size(); ++i)
    drive.scans[i].utime += 60'000'000;  // a minute later, elsewhere
  const ScratchFolder folder;
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.Save(folder.path().string());
  const auto summary = nlohmann::json::parse(BytesOf(folder / "summary.json"));
  const crsm_slam::Verdict verdict = slam.Judge();
  CHECK(summary["verdict"]["lines"] == nlohmann::json(verdict.lines));
  CHECK(summary["scans"] == 400);
  CHECK(summary["ended"] == true);
  CHECK(summary["identity"] == FormatIdentity(ReadHead(folder / "journal")->epoch));
  CHECK(summary["pieces"]["count"] == 2);
  CHECK(ReadMap(folder / "pieces/2").cells.size() > 1000);
  const std::string path = BytesOf(folder / "pieces/2/trajectory.tum");
  CHECK(std::count(path.begin(), path.end(), '\n') == 100);
}

TEST_CASE("a map whose journal is not whole says what is missing") {
  const Drive drive = TakeDrive("demo", 60);
  const ScratchFolder folder;
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.Save(folder.path().string());
  CHECK(crsm_slam::Slam::Load(folder.path().string()).LoadNotice().empty());
  const std::filesystem::path journal = folder / "journal/journal.lcm";
  std::filesystem::resize_file(journal, std::filesystem::file_size(journal) / 2);
  const crsm_slam::Slam half = crsm_slam::Slam::Load(folder.path().string());
  const std::size_t num_scans = half.Trajectory().size();
  CHECK((num_scans > 10 && num_scans < 50));
  CHECK(half.LoadNotice().starts_with(journal.string() + ": torn by a power cut or a kill at byte "));
  CHECK(half.LoadNotice().ends_with(" bytes are left out; " + std::to_string(num_scans) + " scans remain"));
  half.Save(folder.path().string());  // of what is left out somebody may still make something
  CHECK(std::filesystem::exists(folder / "earlier.1/journal/journal.lcm"));
}

TEST_CASE("what a save that was killed has left is removed by the next") {
  const Drive drive = TakeDrive("demo", 10);
  const ScratchFolder folder;
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  std::filesystem::create_directory(folder / "journal.tmp");
  folder.Write("journal.tmp/journal.lcm", "half");
  for (const char* name : {".map.png.999999999.tmp", ".graph.g2o.999999999.tmp"}) folder.Write(name, "half");
  slam.Save(folder.path().string());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    CAPTURE(entry.path().string());
    CHECK(entry.path().string().find("tmp", folder.path().string().size()) == std::string::npos);
  }
}

TEST_CASE("a map takes the settings with it that it was made with, and no others") {
  const Drive drive = TakeDrive("demo", 30);
  const ScratchFolder folder;
  crsm_slam::Slam slam({.preset = "sick", .cell_size_m = 0.1});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.Save(folder.path().string());
  CHECK(crsm_slam::Slam::Load(folder.path().string()).MakeMap().cell_size_m == 0.1);
  CHECK(crsm_slam::Slam::Load(folder.path().string(), {.seed = 7}).MakeMap().cell_size_m == 0.1);
  CHECK_THROWS_WITH(crsm_slam::Slam::Load(folder.path().string(), {.cell_size_m = 0.05}),
                    "cell_size_m: the map in " + folder.path().string() + " was made with 0.1, not with 0.05");
  CHECK_THROWS_AS(crsm_slam::Slam::Load(folder.path().string() + "/nothing"), std::runtime_error);
  CHECK_THROWS_AS(slam.Save("/proc/nowhere"), std::runtime_error);
  CHECK_THROWS_AS(crsm_slam::Slam::Load(folder.path().string(), {}, crsm_slam::Pose{std::nan(""), 0.0, 0.0}),
                  std::invalid_argument);
}

TEST_CASE("on a finished map scans are localised, where the start is told and where it is not") {
  const Drive drive = TakeDrive("demo", 1000);
  const Drive later = TakeDrive("demo", 1000, 2);
  const ScratchFolder folder;
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.Save(folder.path().string());
  constexpr std::size_t kFrom = 700;
  const Pose2& start = drive.T_start_laser[kFrom];
  const bool told = GENERATE(true, false);
  auto localised =
      crsm_slam::Slam::Load(folder.path().string(), {},
                            told ? std::optional(crsm_slam::Pose{start.x_m, start.y_m, start.yaw_rad}) : std::nullopt);
  localised.FinishMap();
  const crsm_slam::Map before = localised.MakeMap();
  for (std::size_t i = kFrom; i < later.scans.size(); ++i) {
    const crsm_slam::Step step = localised.Process(later.scans[i]);
    CHECK_FALSE(step.drawn);
    if (i > kFrom + 10) CHECK(DistanceOf(step.T_map_laser, later.T_start_laser[i]) < 0.2);
  }
  CheckSameMap(localised.MakeMap(), before);
  CHECK(localised.Trajectory().size() == later.scans.size() - kFrom);
  CHECK_THROWS_AS(localised.Save(folder.path().string()), std::logic_error);
  CHECK(localised.Judge().trust == crsm_slam::Trust::kGood);
}

TEST_CASE("a second drive is joined with the first where it comes to the same places") {
  const Drive drive = TakeDrive("demo", 1000);
  crsm_slam::Slam slam({.preset = "sick"});
  for (const auto& scan : drive.scans) slam.Process(scan);
  slam.BeginDrive();
  for (std::size_t i = 400; i < 1000; ++i) {
    crsm_slam::Scan scan = drive.scans[i];
    scan.utime += 10'000'000'000;
    slam.Process(scan);
  }
  const auto trajectory = slam.Trajectory();
  CHECK(trajectory.back().piece == 1);
  CHECK(trajectory[1000].state == crsm_slam::State::kFirst);
  CHECK(DistanceOf(trajectory.back().T_map_laser, drive.T_start_laser[999]) < 0.2);
}

TEST_CASE("the changes since a version of the map are all that differs") {
  const Drive drive = TakeDrive("block", 1600);
  crsm_slam::Slam slam({.preset = "sick"});
  std::map<std::pair<int, int>, crsm_slam::MapChanges::Tile> known;
  std::int64_t version = 0;
  CHECK(slam.ChangesSince(0).tiles.empty());
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    slam.Process(drive.scans[i]);
    if (i % 400 != 399) continue;
    const crsm_slam::MapChanges changes = slam.ChangesSince(version);
    CHECK(changes.version > version);
    version = changes.version;
    for (const auto& tile : changes.tiles) known[{tile.x_cells, tile.y_cells}] = tile;
  }
  CHECK(slam.ChangesSince(version).version == version);
  CHECK(slam.ChangesSince(version).tiles.empty());
  CHECK(slam.ChangesSince(0).tiles.size() == known.size());
  const crsm_slam::Map map = slam.MakeMap();
  const auto left = static_cast<int>(std::lround(map.T_map_grid.x_m / map.cell_size_m));
  const auto low = static_cast<int>(std::lround(map.T_map_grid.y_m / map.cell_size_m));
  int num_wrong = 0;
  for (int y = 0; y < map.height_cells; ++y) {
    for (int x = 0; x < map.width_cells; ++x) {
      const int column = left + x;
      const int row = low + y;
      const auto tile = known.find({column & ~63, row & ~63});
      const std::uint8_t told =
          tile == known.end() ? 127 : tile->second.cells[static_cast<std::size_t>((row & 63) * 64 + (column & 63))];
      num_wrong += told != map.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width_cells) +
                                     static_cast<std::size_t>(x)];
    }
  }
  CHECK(num_wrong == 0);
}

TEST_CASE("the local pose makes no jump where a loop closes, and the pose on the map does") {
  const Drive drive = TakeDrive("block", 1600);
  crsm_slam::Slam slam({.preset = "sick", .angle_scale = 1.004});  // so that the path drifts
  double longest_m = 0.0;
  double longest_local_m = 0.0;
  std::optional<crsm_slam::Step> last;
  for (const auto& scan : drive.scans) {
    const crsm_slam::Step step = slam.Process(scan);
    const auto Between = [](const crsm_slam::Pose& a, const crsm_slam::Pose& b) {
      return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
    };
    if (last) {
      longest_m = std::max(longest_m, Between(last->T_map_laser, step.T_map_laser));
      longest_local_m = std::max(longest_local_m, Between(last->T_local_laser, step.T_local_laser));
    }
    last = step;
  }
  CHECK_FALSE(slam.Loops().empty());
  CHECK(longest_m > 0.4);
  CHECK(longest_local_m < 0.3);
}

TEST_CASE("the verdict says whether the map can be trusted, and why") {
  const Drive drive = TakeDrive("demo", 1000);
  crsm_slam::Slam good({.preset = "sick"});
  crsm_slam::Slam bad({.preset = "sick"});
  for (crsm_slam::Scan scan : drive.scans) {
    good.Process(scan);
    scan.angle_step_rad *= 0.5f;  // of a laser that says its angles wrongly
    bad.Process(scan);
  }
  const crsm_slam::Verdict verdict = good.Judge();
  CHECK(verdict.trust == crsm_slam::Trust::kGood);
  CHECK(verdict.lines.front().starts_with("1000 of 1000 scans mapped"));
  CHECK(verdict.off_m.has_value());
  CHECK(bad.Judge().trust != crsm_slam::Trust::kGood);
}

TEST_CASE("a sweep is deskewed by the times of its beams") {
  Simulator simulator(LoadWorld("arena"), 1);
  std::vector<crsm_slam::Scan> scans;
  std::vector<Pose2> truth;
  constexpr double kSweep_s = 0.15;
  while (const auto scan = simulator.Next()) {
    scans.push_back({scan->utime, scan->angle_min_rad, scan->angle_step_rad, scan->ranges_m});
    const auto num_beams = static_cast<double>(scan->ranges_m.size());
    for (double beam = 0.0; beam < num_beams; ++beam)
      scans.back().times_s.push_back(static_cast<float>(kSweep_s * (beam / (num_beams - 1.0) - 1.0)));
    truth.push_back(*simulator.TruePose());
  }
  const auto Error = [&](bool with_times) {
    crsm_slam::Slam slam({.preset = "rplidar-a1", .sweep_s = 0.0, .beam_times = with_times});
    for (const auto& scan : scans) slam.Process(scan);
    return DistanceOf(slam.Trajectory().back().T_map_laser, truth.back());
  };
  CHECK(Error(true) < 0.03);
  CHECK(Error(false) > Error(true));
  crsm_slam::Slam slam;
  crsm_slam::Scan spoilt = scans.front();
  spoilt.times_s.pop_back();
  CHECK_THROWS_AS(slam.Process(spoilt), std::invalid_argument);
  spoilt.times_s.push_back(3.0f);
  CHECK_THROWS_AS(slam.Process(spoilt), std::invalid_argument);
}

TEST_CASE("settings are what their names say, whether they are given as numbers or as text") {
  const auto CellSize = [](const crsm_slam::Settings& settings) {
    crsm_slam::Slam slam(settings);
    slam.Process(TakeDrive("demo", 1).scans.front());
    return slam.MakeMap().cell_size_m;
  };
  CHECK(CellSize({.preset = "urg-04lx", .cell_size_m = 0.125}) == 0.125);
  CHECK(CellSize({.cell_size_m = 0.125, .values = {{"cell_size_m", "0.25"}}}) == 0.25);
  CHECK_THROWS_WITH(crsm_slam::Slam({.cell_size_m = 5.0}), "cell_size_m: '5' is not a number from 0.005 to 1");
  CHECK_THROWS_WITH(crsm_slam::Slam({.rays_max = 3}), "rays_max: '3' is not a whole number from 6 to 4096");
}

}  // namespace crsm
