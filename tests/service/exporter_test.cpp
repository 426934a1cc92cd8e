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
#include "services/runtime/conversions.hpp"

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
    bus_->Subscribe<map_request_t>(kMapRequestChannel, [this](const map_request_t& request) {
      ++num_requests_;
      Answer(request);
    });
  }

  TestBus& bus() { return bus_; }
  std::int64_t num_scans() const { return num_scans_; }
  std::int64_t num_requests() const { return num_requests_; }
  const std::vector<TileChange>& tiles() const { return tiles_; }

  /// One more scan, told to everybody; with the tile that it has changed, if any.
  void Advance(const std::optional<TileChange>& tile = {}) {
    map_delta_t delta = Blank(num_scans_);
    delta.version = num_scans_ + 1;
    delta.matches = {ToMessage(MatchOf(num_scans_++))};
    delta.num_matches = 1;
    if (tile) {
      tiles_.push_back(*tile);
      delta.tiles = {ToMessage(*tile)};
      delta.num_tiles = 1;
    }
    bus_->Publish(kMapDeltaChannel, delta);
  }

  /// One more scan, told to nobody, and then another: who follows misses one and asks.
  void Skip() {
    ++num_scans_;
    Advance();
  }

  void BeginAnew(std::int64_t num_scans) {
    ++epoch_;
    num_scans_ = num_scans;
    Advance();
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
    delta.asked_utime = -1;
    return delta;
  }

  void Answer(const map_request_t& request) {
    constexpr std::int64_t kMatchesInPage = 100;
    constexpr std::size_t kTilesInPage = 4;
    const bool same_map = request.epoch == epoch_;
    map_delta_t page = Blank(same_map ? request.base_version : 0);
    page.recipient = request.requester;
    std::int64_t match = same_map ? request.first_match : 0;
    for (const auto end = std::min(num_scans_, match + kMatchesInPage); match < end; ++match) {
      page.matches.push_back(ToMessage(MatchOf(match)));
    }
    page.num_matches = static_cast<std::int32_t>(page.matches.size());
    page.next_match = static_cast<std::int32_t>(match);
    auto tile = same_map ? std::min(static_cast<std::size_t>(request.first_tile), tiles_.size()) : 0;
    if (page.base_version > 0) tile = tiles_.size();  // those were told before
    for (const auto end = std::min(tiles_.size(), tile + kTilesInPage); tile < end; ++tile) {
      page.tiles.push_back(ToMessage(tiles_[tile]));
    }
    page.num_tiles = static_cast<std::int32_t>(page.tiles.size());
    page.next_tile = tile < tiles_.size() ? static_cast<std::int32_t>(tile) : -1;
    bus_->Publish(kMapDeltaChannel, page);
  }

  TestBus bus_;
  std::int64_t epoch_ = 99;
  std::int64_t num_scans_;
  std::int64_t num_requests_ = 0;
  std::vector<TileChange> tiles_;
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
  CHECK(ScansIn(out) == 702);
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

  // A scan every 20 ms; now and then one is missed, and it is asked for as soon as the loop comes by.
  std::vector<double> waits_ms;
  for (int i = 0; i < 1500; ++i) {
    const auto next = Clock::now() + std::chrono::milliseconds(20);
    if (i % 10 == 0) {
      const std::int64_t before = owner.num_requests();
      const auto asked = Clock::now();
      owner.Skip();
      REQUIRE(owner.bus().Await([&] { return owner.num_requests() > before; }));
      waits_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - asked).count());
    } else {
      owner.Advance(i % 25 == 1 ? std::optional(owner.tiles()[static_cast<std::size_t>(i) % 489]) : std::nullopt);
    }
    owner.bus().Await([&] { return Clock::now() >= next; });
  }
  std::sort(waits_ms.begin(), waits_ms.end());
  fmt::print(
      "half a million scans, 5,000 m2: the loop came by within {:.0f} ms (median), {:.0f} ms (longest of {}); "
      "memory {:.1f} MB, {:.1f} MB after 30 s\n",
      waits_ms[waits_ms.size() / 2], waits_ms.back(), waits_ms.size(), before_mb, exporter.ResidentMb());
  const auto asked = Clock::now();
  exporter.Signal(SIGINT);
  REQUIRE(owner.bus().Await([&] { return !exporter.IsRunning(); }));
  fmt::print("written at the end within {:.1f} s\n", std::chrono::duration<double>(Clock::now() - asked).count());
  CHECK(NumLines(out / "trajectory.tum") == owner.num_scans());
}
