// map_exporter beside an owner of a map that is forged: what it writes while a run goes on, and at its end.

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <utility>

#include "catch.hpp"
#include "common/logs/map_picture.hpp"
#include "common/logs/read_map.hpp"
#include "common/map/byte_map.hpp"
#include "common/results/results.hpp"
#include "map_owner.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

/// The match of the `number`-th scan: a robot on a spiral that is lost now and then.
ScanMatch MatchOf(std::int64_t number) {
  const double angle_rad = 0.003 * static_cast<double>(number);
  const double radius_m = std::min(30.0, 1e-3 * static_cast<double>(number));
  const auto [sin, cos] = ComputeSinCos(WrapAngle(angle_rad));
  ScanMatch match;
  match.utime = 1000000 + 100000 * number;
  match.T_map_laser = {radius_m * cos, radius_m * sin, WrapAngle(angle_rad)};
  match.fitness = 0.8;
  match.state = number == 0 ? MatchState::kFirst : number % 50 == 49 ? MatchState::kLost : MatchState::kOk;
  return match;
}

/// A whole tile of walls and floor that tells its place.
TileChange TileAt(TileIndex index) {
  TileBytes before;
  TileBytes cells;
  before.fill(kUnexploredByte);
  for (int i = 0; i < kTileCells; ++i) {
    cells[static_cast<std::size_t>(i)] = i % 17 == 0 ? static_cast<std::uint8_t>(index.x & 63) : kFreeByte;
  }
  return {index, PackRuns(before, cells)};
}

/// Owns a map of a given size on the bus.
class ForgedOwner : public MapOwner {
 public:
  ForgedOwner(const std::string& url, std::int64_t num_scans, int num_tiles)
      : MapOwner(UpdateParameters{.cell_size_m = 0.05}), bus_(url) {
    Advance(num_scans);
    const int side = static_cast<int>(std::ceil(std::sqrt(num_tiles)));
    for (int i = 0; i < num_tiles; ++i) Change(TileAt({i % side - side / 2, i / side - side / 2}));
    Serve(*bus_);
  }

  TestBus& bus() { return bus_; }

  /// More scans, that change nothing.
  void Advance(std::int64_t num_scans = 1) {
    for (std::int64_t i = 0; i < num_scans; ++i) Answer(MatchOf(version()), {});
  }

 private:
  TestBus bus_;
};

std::int64_t ScansIn(const fs::path& out) {
  const auto summary = nlohmann::json::parse(ReadFile(out / "summary.json"), nullptr, false);
  return summary.is_object() ? summary.value("scans", std::int64_t{-1}) : -1;
}

ino_t NumberOf(const fs::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

/// What the results are to be, but for parts of summary.json. No scan was heard of whose rays could be judged.
void WriteExpected(const fs::path& out, const MapOwner& owner) {
  Results results;
  results.grid = owner.map.ToDenseGrid();
  results.matches = owner.history;
  RunStatistics statistics;
  for (const ScanMatch& match : owner.history) statistics.Add(match);
  results.summary.emplace().values = statistics.values();
  results.summary->explored_area_m2 = ComputeExploredArea(results.grid);
  results.summary->verdict = Judge(statistics, owner.map);
  results.name = "out";
  WriteResults(out, results);
}

}  // namespace

TEST_CASE("map_exporter writes what has changed, adds to the trajectory what is new, and at the end the files of all") {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  const std::string url = MakeBusUrl();
  ForgedOwner owner(url, 1500, 30);
  Process exporter("map_exporter", {"--lcm-url", url, "--out", out, "--export-period-s", "0.1"}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  const auto AwaitWritten = [&] {
    REQUIRE(owner.bus().Await([&] { return ScansIn(out) == owner.version(); }));
    CHECK(std::cmp_equal(CountLines(ReadFile(out / "trajectory.tum")), owner.version()));
  };
  AwaitWritten();
  const ino_t map = NumberOf(out / "map.png");
  const ino_t trajectory = NumberOf(out / "trajectory.tum");
  const std::string lines = ReadFile(out / "trajectory.tum");

  owner.Advance(3);
  AwaitWritten();
  CHECK(NumberOf(out / "map.png") == map);
  CHECK(NumberOf(out / "trajectory.tum") == trajectory);
  CHECK(ReadFile(out / "trajectory.tum").find(lines) == 0);

  owner.Answer(MatchOf(owner.version()), std::vector{TileAt({20, 20})});
  AwaitWritten();
  CHECK(NumberOf(out / "map.png") != map);
  CHECK(NumberOf(out / "trajectory.tum") == trajectory);
  WriteExpected(folder / "expected", owner);
  folder.CheckSame("out", "expected", {"map.png", "trajectory.tum"});
  const std::string picture = FindPicture(out);  // that nobody replaces while map.yaml names it
  CHECK(picture != kMapPicture);
  CHECK(ReadFile(out / picture) == ReadFile(out / "map.png"));
  CHECK(ReadMap(out).cells == ReadMap(folder / "expected").cells);
  owner.Answer(MatchOf(owner.version()), std::vector{TileAt({21, 20})});
  AwaitWritten();
  CHECK(FindPicture(out) != picture);
  CHECK(fs::exists(out / picture));  // for who has read map.yaml before

  fs::remove(out / "trajectory.tum");  // by somebody
  owner.Advance();
  AwaitWritten();
  ++owner.epoch;
  owner.history.resize(700);  // after a power cut, say
  AwaitWritten();

  owner.Advance();
  exporter.Signal(SIGINT);  // while the last scan is not written yet
  REQUIRE(owner.bus().Await([&] { return !exporter.IsRunning(); }));
  CHECK(exporter.AwaitExit() == 0);
  WriteExpected(folder / "expected", owner);
  folder.CheckSame("out", "expected", {"map.png", "map.yaml", "trajectory.tum", "overview.png"});
  CHECK(NameNextPicture(out) == "map.1.png");  // the others are gone
  CHECK(ScansIn(out) == 701);
}

TEST_CASE("map_exporter writes nothing into what has come in the place of its folder, and says so") {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  const fs::path elsewhere = folder / "elsewhere";
  fs::create_directories(elsewhere);
  const std::string url = MakeBusUrl();
  ForgedOwner owner(url, 10, 30);
  Process exporter("map_exporter", {"--lcm-url", url, "--out", out, "--export-period-s", "0.1"}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  REQUIRE(owner.bus().Await([&] { return ScansIn(out) == owner.version(); }));
  fs::rename(out, folder / "moved");
  fs::create_directory_symlink(elsewhere, out);
  owner.Advance();
  REQUIRE(
      owner.bus().Await([&] { return exporter.errors().find("was removed, moved or replaced") != std::string::npos; }));
  exporter.Signal(SIGINT);
  REQUIRE(owner.bus().Await([&] { return !exporter.IsRunning(); }));
  CHECK(exporter.AwaitExit() == 1);
  CHECK(fs::is_empty(elsewhere));
}

TEST_CASE("map_exporter leaves earlier results as they are where no map comes") {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  fs::create_directories(out);
  for (const char* name : {"map.png", "trajectory.tum"}) std::ofstream(out / name) << "of an earlier run";
  Process exporter("map_exporter", {"--lcm-url", MakeBusUrl(), "--out", out}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  CHECK(exporter.Interrupt() == 0);
  for (const char* name : {"map.png", "trajectory.tum"}) CHECK(ReadFile(out / name) == "of an earlier run");
  CHECK(exporter.errors().find("map_exporter: no map came: the results in ") != std::string::npos);
}
