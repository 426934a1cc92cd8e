// map_exporter beside an owner of a map that is forged: what it writes while a run goes on, and at its end.

#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "common/map/byte_map.hpp"
#include "common/results/results.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

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

/// Owns a map of a given size on the bus and answers who asks for it.
class ForgedOwner {
 public:
  ForgedOwner(const std::string& url, std::int64_t num_scans, int num_tiles) : bus_(url), num_scans_(num_scans) {
    const int side = static_cast<int>(std::ceil(std::sqrt(num_tiles)));
    for (int i = 0; i < num_tiles; ++i) tiles_.push_back(TileAt({i % side - side / 2, i / side - side / 2}));
    changed_in_.resize(tiles_.size(), 1);
    bus_->Subscribe<map_request_t>(kMapRequestChannel, [this](const map_request_t& request) {
      CHECK(request.whole == 1);
      Answer(request);
    });
  }

  TestBus& bus() { return bus_; }
  std::int64_t num_scans() const { return num_scans_; }
  const std::vector<TileChange>& tiles() const { return tiles_; }

  /// One more scan; with the tile that it has changed, if any.
  void Advance(const std::optional<TileChange>& tile = {}) {
    ++num_scans_;
    if (!tile) return;
    tiles_.push_back(*tile);
    changed_in_.push_back(num_scans_);
  }

  void BeginAnew(std::int64_t num_scans) {
    ++epoch_;
    num_scans_ = num_scans;
  }

 private:
  map_delta_t Blank(std::int64_t base_version) const {
    map_delta_t delta{};
    delta.utime = 1;
    delta.epoch = epoch_;
    delta.base_version = base_version;
    delta.version = num_scans_;
    delta.cell_size_m = 0.05;
    delta.num_parts = 1;
    return delta;
  }

  void Answer(const map_request_t& request) {
    constexpr std::int64_t kMatchesInPage = 100;
    constexpr std::size_t kTilesInPage = 4;
    const bool same_map = request.epoch == epoch_;
    map_delta_t page = Blank(same_map ? request.base_version : 0);
    page.num_requests = 1;
    page.request = {request};
    std::int64_t match = same_map ? request.first_match : 0;
    for (const auto end = std::min(num_scans_, match + kMatchesInPage); match < end; ++match) {
      page.matches.push_back(ToMessage(MatchOf(match)));
    }
    page.num_matches = static_cast<std::int32_t>(page.matches.size());
    page.next_match = static_cast<std::int32_t>(match);
    auto tile = same_map ? std::min(static_cast<std::size_t>(request.first_tile), tiles_.size()) : 0;
    for (; tile < tiles_.size() && page.tiles.size() < kTilesInPage; ++tile) {
      if (changed_in_[tile] > page.base_version) page.tiles.push_back(ToMessage(tiles_[tile]));
    }
    page.num_tiles = static_cast<std::int32_t>(page.tiles.size());
    page.next_tile = tile < tiles_.size() ? static_cast<std::int32_t>(tile) : -1;
    bus_->Publish(kWholeMapChannel, page);
  }

  TestBus bus_;
  std::int64_t epoch_ = 99;
  std::int64_t num_scans_;
  std::vector<TileChange> tiles_;
  std::vector<std::int64_t> changed_in_;  ///< version, by tile
};

std::int64_t ScansIn(const fs::path& out) {
  const auto summary = nlohmann::json::parse(ReadFile(out / "summary.json"), nullptr, false);
  return summary.is_object() ? summary.value("scans", std::int64_t{-1}) : -1;
}

ino_t NumberOf(const fs::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

std::int64_t NumLines(const fs::path& path) {
  const std::string text = ReadFile(path);
  return std::count(text.begin(), text.end(), '\n');
}

/// What the results are to be.
void WriteExpected(const fs::path& out, const ForgedOwner& owner) {
  ByteMap map(0.05);
  for (const TileChange& tile : owner.tiles()) map.Apply(tile);
  std::vector<ScanMatch> matches;
  for (std::int64_t i = 0; i < owner.num_scans(); ++i) matches.push_back(MatchOf(i));
  Results results;
  results.grid = map.ToDenseGrid();
  results.matches = matches;
  results.summary_json = "{}\n";
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
    REQUIRE(owner.bus().Await([&] { return ScansIn(out) == owner.num_scans(); }));
    CHECK(NumLines(out / "trajectory.tum") == owner.num_scans());
  };
  AwaitWritten();
  const ino_t map = NumberOf(out / "map.png");
  const ino_t trajectory = NumberOf(out / "trajectory.tum");
  const std::string lines = ReadFile(out / "trajectory.tum");

  for (int i = 0; i < 3; ++i) owner.Advance();
  AwaitWritten();
  CHECK(NumberOf(out / "map.png") == map);
  CHECK(NumberOf(out / "trajectory.tum") == trajectory);
  CHECK(ReadFile(out / "trajectory.tum").find(lines) == 0);

  owner.Advance(TileAt({20, 20}));
  AwaitWritten();
  CHECK(NumberOf(out / "map.png") != map);
  CHECK(NumberOf(out / "trajectory.tum") == trajectory);
  WriteExpected(folder / "expected", owner);
  for (const char* file : {"map.png", "map.yaml", "trajectory.tum"}) {
    CHECK(ReadFile(out / file) == ReadFile(folder / "expected" / file));
  }

  fs::remove(out / "trajectory.tum");  // by somebody
  owner.Advance();
  AwaitWritten();
  owner.BeginAnew(700);  // after a power cut, say
  AwaitWritten();

  owner.Advance();
  exporter.Signal(SIGINT);  // while the last scan is not written yet
  REQUIRE(owner.bus().Await([&] { return !exporter.IsRunning(); }));
  CHECK(exporter.AwaitExit() == 0);
  WriteExpected(folder / "expected", owner);
  for (const char* file : {"map.png", "map.yaml", "trajectory.tum", "overview.png"}) {
    INFO(file);
    CHECK(ReadFile(out / file) == ReadFile(folder / "expected" / file));
  }
  CHECK(ScansIn(out) == 701);
}

// Prints figures, which a busy machine makes larger; not of the usual tests: service_tests "[large]"
TEST_CASE("map_exporter never stands still for long, at half a million scans and 5,000 m2", "[.large]") {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  const std::string url = MakeBusUrl();
  ForgedOwner owner(url, 500000, 489);
  Process exporter("map_exporter", {"--lcm-url", url, "--out", out, "--export-period-s", "1"}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  REQUIRE(owner.bus().Await([&] { return ScansIn(out) == 500000; }));
  const double before_mb = exporter.ResidentMb();

  double longest_ms = 0.0;
  owner.bus()->Subscribe<service_status_t>(ServiceStatusChannel("map_exporter"),
                                           [&](const service_status_t& status) { longest_ms = status.latency_max_ms; });
  for (int i = 0; i < 1500; ++i) {  // a scan every 20 ms
    const auto next = Clock::now() + std::chrono::milliseconds(20);
    owner.Advance(i % 25 == 1 ? std::optional(owner.tiles()[static_cast<std::size_t>(i) % 489]) : std::nullopt);
    owner.bus().Await([&] { return Clock::now() >= next; });
  }
  fmt::print(
      "half a million scans, 5,000 m2: messages waited for {:.0f} ms at most; memory {:.1f} MB, {:.1f} MB after 30 s\n",
      longest_ms, before_mb, exporter.ResidentMb());
  const auto asked = Clock::now();
  exporter.Signal(SIGINT);
  REQUIRE(owner.bus().Await([&] { return !exporter.IsRunning(); }));
  fmt::print("written at the end within {:.1f} s\n", std::chrono::duration<double>(Clock::now() - asked).count());
  CHECK(NumLines(out / "trajectory.tum") == owner.num_scans());
}
