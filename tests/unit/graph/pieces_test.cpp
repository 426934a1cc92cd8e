// A map in several pieces: why its trajectories began, what hangs together, and what is told of it.

#include "common/graph/pieces.hpp"

#include <algorithm>
#include <numeric>

#include "catch.hpp"
#include "common/graph/mapper.hpp"
#include "common/graph/whole_map.hpp"
#include "graph/block.hpp"
#include "services/diagnosis/break_news.hpp"
#include "services/map_updater/pages.hpp"
#include "services/replica/map_replica.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 30.0};

UpdateParameters Drawing() {
  UpdateParameters drawing = TestParameters().update;
  drawing.update_distance_m = 0.2;
  return drawing;
}

ScanMatch At(std::int64_t utime, MatchState state) {
  ScanMatch match = MatchedAt(utime, {});
  match.state = state;
  return match;
}

/// A scan a second, each 0.25 m further round the block, with a new trajectory where it is said.
struct BrokenDrive {
  Mapper mapper{Drawing(), kLoops};
  MatchStore matches;
  TrackingState tracking;

  /// by_wheels: of every step, also over the breaks.
  explicit BrokenDrive(const std::vector<int>& lengths, const std::optional<WheelMotion>& by_wheels = std::nullopt)
      : by_wheels_(by_wheels) {
    const std::vector<Wall> walls = MakeBlock(5);
    double way_m = 5.0;
    for (const int length : lengths) {
      for (int i = 0; i < length; ++i, way_m += 0.25) Add(walls, way_m, i == 0);
    }
  }

  void Add(const std::vector<Wall>& walls, double way_m, bool begins) {
    const std::int64_t scan = matches.size();
    Random random(static_cast<std::uint64_t>(scan));
    const CriticalRays rays{1'000'000 * scan, SeeRays(walls, PlaceRoundBlock(way_m), random), {}};
    ScanMatch match = MatchedAt(rays.utime, Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(way_m));
    if (begins) match.state = MatchState::kFirst;
    match.map_version = scan;
    match.by_wheels = by_wheels_;
    mapper.Integrate(&rays, match);
    matches.Append(match);
    tracking.Add(match);
  }

  /// As a loop between the newest keyframes of two trajectories.
  bool Join(int older, int newer) {
    const KeyframeGraph& graph = mapper.graph();
    GraphUpdate update;
    update.keyframe = *graph.newest();
    update.previous = mapper.last_update();
    update.closed = {{graph.LastOf(older), graph.LastOf(newer), {}}};
    return mapper.Accept(update);
  }

 private:
  std::optional<WheelMotion> by_wheels_;
};

std::vector<std::int64_t> ScansOf(const MapPieces& pieces) {
  std::vector<std::int64_t> scans;
  for (const MapPiece& piece : pieces.pieces) scans.push_back(piece.scans);
  return scans;
}

}  // namespace

TEST_CASE("why a trajectory began follows from the scans before it") {
  TrajectoryLog log;
  std::int64_t utime = 10'000'000;
  int num = 1;
  const auto Next = [&](std::int64_t step_us, MatchState state) { log.Add(At(utime += step_us, state), num); };
  Next(0, MatchState::kFirst);
  for (int i = 0; i < 5; ++i) Next(200'000, MatchState::kLost);
  ++num;
  Next(200'000, MatchState::kFirst);
  Next(200'000, MatchState::kOk);
  ++num;
  Next(20'000'000, MatchState::kFirst);
  ++num;
  Next(-5'000'000, MatchState::kFirst);
  for (int i = 0; i < 3; ++i) Next(200'000, MatchState::kOk);
  ++num;
  Next(200'000, MatchState::kFirst);
  ++num;
  Next(200'000, MatchState::kFirst);
  REQUIRE(log.size() == 6);
  const auto Check = [&](int trajectory, BreakReason reason, double seconds, std::int64_t scan) {
    CAPTURE(trajectory);
    CHECK(log.at(trajectory).start.reason == reason);
    CHECK(log.at(trajectory).start.seconds == Approx(seconds));
    CHECK(log.at(trajectory).start.scan == scan);
  };
  Check(1, BreakReason::kLost, 1.2, 6);  // since the first scan
  Check(2, BreakReason::kGap, 20.0, 8);
  Check(3, BreakReason::kClock, 5.0, 9);
  Check(4, BreakReason::kSession, 0.2, 13);
  Check(5, BreakReason::kLost, 0.2, 14);  // where hardly anything was matched, one lost scan is enough
  CHECK(log.at(0).num_matched == 1);
  CHECK(log.at(1).num_matched == 2);
  CHECK(log.EndOf(0) == 6);
  CHECK(log.EndOf(5) == log.num_scans());
}

TEST_CASE("times at both ends of what a clock can say do no harm") {
  TrajectoryLog log;
  log.Add(At(std::numeric_limits<std::int64_t>::max(), MatchState::kFirst), 1);
  log.Add(At(0, MatchState::kFirst), 2);
  CHECK(log.at(1).start.reason == BreakReason::kClock);
  CHECK(log.at(1).start.seconds == Approx(9.2e12).epsilon(0.01));
}

TEST_CASE("the pieces of a map are counted by size, and a join makes one of two") {
  BrokenDrive drive({20, 60, 40, 4});
  const MapPieces apart = drive.mapper.FindPieces();
  CHECK(apart.num_pieces == 4);
  CHECK(apart.num_breaks == 3);
  CHECK(apart.num_matched == 124);
  CHECK(ScansOf(apart) == std::vector<std::int64_t>{60, 40, 20, 4});
  CHECK(apart.num_elsewhere() == 64);
  CHECK(apart.pieces[0].way_m == Approx(59 * 0.25));
  CHECK(apart.OthersWithMap() == std::vector{2, 3});  // less than 3 m of way
  REQUIRE(apart.breaks.size() == 3);
  CHECK(apart.breaks[0].scan == 20);
  CHECK(apart.breaks[0].piece_before == 3);
  CHECK(apart.breaks[0].piece == 1);
  CHECK_FALSE(apart.breaks[0].joined());
  CHECK(apart.breaks[2].piece == 4);
  const Pose2 end = Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(5.0 + 19 * 0.25);
  CHECK(Length(Inverse(end) * apart.breaks[0].T_map_before) < 1e-9);
  CHECK(drive.mapper.PlaceLoops().empty());

  REQUIRE(drive.Join(0, 2));
  const MapPieces joined = drive.mapper.FindPieces();
  CHECK(joined.num_pieces == 3);
  CHECK(ScansOf(joined) == std::vector<std::int64_t>{60, 60, 4});
  CHECK(drive.mapper.FindPieceNumbers() == std::vector{1, 2, 1, 3});  // of two of one size the older one is shown
  REQUIRE(drive.mapper.PlaceLoops().size() == 1);
  CHECK(drive.mapper.PlaceLoops()[0].joins);
  drive.Add(MakeBlock(5), 36.0, false);  // an update is of a newer keyframe than the last
  REQUIRE(drive.Join(1, 2));
  CHECK(drive.mapper.FindPieces().num_elsewhere() == 5);
  CHECK(drive.mapper.FindPieces().breaks[0].joined());
  CHECK_FALSE(drive.mapper.FindPieces().breaks[2].joined());
}

TEST_CASE("where the wheels bridge the breaks the map is one piece, and says how often it hangs on them alone") {
  BrokenDrive drive({20, 60, 40}, WheelMotion{{0.25, 0.0, 0.0}, 0.02, 0.01});
  const MapPieces bridged = drive.mapper.FindPieces();
  CHECK(bridged.num_pieces == 1);
  CHECK(bridged.num_breaks == 2);
  CHECK(bridged.num_bridged == 2);
  CHECK(bridged.num_elsewhere() == 0);
  CHECK_FALSE(drive.mapper.MoveToBest(119, drive.matches.At(119)).floating);
  const Keyframe& first = drive.mapper.graph().keyframe({1, 0});
  REQUIRE(first.by_wheels);
  CHECK(first.by_wheels->T_from_to.x_m > 0.2);
  REQUIRE(drive.Join(0, 1));
  CHECK(drive.mapper.FindPieces().num_bridged == 1);
  CHECK(BrokenDrive({20, 60, 40}).mapper.FindPieces().num_bridged == 0);
}

TEST_CASE("loops of another piece are not on the map that is shown") {
  BrokenDrive drive({20, 20, 60});
  REQUIRE(drive.Join(0, 1));
  CHECK(drive.mapper.FindPieces().num_pieces == 2);
  CHECK(drive.mapper.PlaceLoops().empty());
}

TEST_CASE("of hundreds of breaks the newest are listed, and of as many pieces the largest") {
  BrokenDrive drive(std::vector(230, 1));
  const MapPieces pieces = drive.mapper.FindPieces();
  CHECK(pieces.num_pieces == 230);
  CHECK(pieces.pieces.size() == MapPieces::kMostPieces);
  CHECK(pieces.num_breaks == 229);
  REQUIRE(pieces.breaks.size() == MapPieces::kMostBreaks);
  CHECK(pieces.breaks.back().scan == 229);
  CHECK(pieces.OthersWithMap().empty());
}

TEST_CASE("a replica that turns to a piece gets its scans and its map, and of a piece that is not there nothing") {
  BrokenDrive drive({20, 120, 40, 30});
  REQUIRE(drive.Join(0, 3));  // piece 2 is in two parts
  std::vector<ScanMatch> told;
  std::optional<ByteMap> map;
  MapReplica replica(7,
                     {[&](double cell_size_m) {
                        map.emplace(cell_size_m);
                        told.clear();
                      },
                      [&](std::span<const TileChange> changes) {
                        for (const TileChange& change : changes) REQUIRE(map->Apply(change));
                      },
                      [&](const ScanMatch& match) { told.push_back(match); }},
                     MapReplica::View::kWhole);
  const auto Fetch = [&](int piece) {
    if (piece != 1) replica.TurnTo(piece);
    const Mapper& mapper = drive.mapper;
    const int component = mapper.FindComponent(piece);
    std::int64_t num_scans = 0;
    for (const Mapper::ScanRun& run : mapper.FindScans(component)) num_scans += run.end - run.first;
    WholeMap drawn(Drawing());
    const int all = mapper.graph().size();
    piece == 1 ? drawn.Draw(mapper, all) : drawn.Draw(mapper, component, num_scans, all);
    Answered answered{drive.matches, drive.tracking, &mapper};
    if (piece != 1) answered.component = component;
    for (int i = 0; i < 100; ++i) {
      const auto request = replica.NextRequest();
      if (!request) break;
      CHECK(request->piece == (piece == 1 ? 0 : piece));
      const map_page_t page = MakePage(*request, drawn.map(), answered, {90 + piece, 6000});
      REQUIRE(Decode<map_page_t>(Encode(page)));
      replica.Handle(page);
    }
    CHECK(replica.synced());
    CHECK(replica.version() == static_cast<std::int64_t>(told.size()));
    if (piece == 1) return drawn;
    std::size_t num_tiles = 0;
    for (; num_tiles < drawn.map().num_tiles(); ++num_tiles) CHECK(drawn.map().TileSince(num_tiles, 0));
    CHECK((num_tiles > 0) == (component >= 0));
    return drawn;
  };
  Fetch(1);
  CHECK(told.size() == 210);
  REQUIRE(replica.pieces());
  CHECK(*replica.pieces() == drive.mapper.FindPieces());
  Fetch(2);
  CHECK_FALSE(replica.pieces());
  REQUIRE(told.size() == 50);
  CHECK(told[19].utime == 19'000'000);
  CHECK(told[20].utime == 180'000'000);
  CHECK(told[20].state == MatchState::kFirst);  // as it was matched
  CHECK(told[20].T_map_laser == drive.mapper.BestPose(180, drive.matches.At(180).T_map_laser));
  Fetch(3);
  CHECK(told.size() == 40);
  Fetch(9);
  CHECK(told.empty());
  CHECK(replica.version() == 0);
}

TEST_CASE("on the terminal stands where a trajectory begins and where it is joined, once") {
  BrokenDrive drive({20, 20});
  BreakNews news;
  const auto now = BreakNews::Clock::now();
  const auto Look = [&] { return news.Look(drive.mapper, now); };
  CHECK(Look() == std::vector<std::string>{"scan 20: another session: a new trajectory begins"});
  CHECK(Look().empty());
  REQUIRE(drive.Join(0, 1));
  CHECK(Look() == std::vector<std::string>{"what was mapped from scan 20 on is joined with an older part of the map"});
  CHECK(Look().empty());
  GraphUpdate update;
  update.previous = drive.mapper.last_update();
  update.rejected = {{drive.mapper.graph().LastOf(0), drive.mapper.graph().LastOf(1), {}}};
  drive.Add(MakeBlock(5), 15.0, false);
  update.keyframe = *drive.mapper.graph().newest();
  REQUIRE(drive.mapper.Accept(update));
  REQUIRE(Look().size() == 1);

  BreakNews later;
  later.Skip(drive.mapper);
  CHECK(later.Look(drive.mapper, now).empty());
}

TEST_CASE("a break is said by its reason") {
  CHECK(DescribeBreak({0, 5, BreakReason::kLost, 1.26, {}}) == "scan 5: lost for 1.3 s: a new trajectory begins");
  CHECK(DescribeBreak({0, 5, BreakReason::kGap, 9.0, {}}) == "scan 5: no scan came for 9.0 s: a new trajectory begins");
  CHECK(DescribeBreak({0, 5, BreakReason::kClock, 2.0, {}}) ==
        "scan 5: the clock went back by 2.0 s: a new trajectory begins");
}

TEST_CASE("hundreds of breaks do not flood the terminal, and those that were left out are counted") {
  BrokenDrive drive(std::vector(200, 1));
  BreakNews news;
  const auto now = BreakNews::Clock::now();
  CHECK(news.Look(drive.mapper, now).size() == 10);
  CHECK(news.Look(drive.mapper, now).empty());
  drive.Add(MakeBlock(5), 60.0, true);
  const auto lines = news.Look(drive.mapper, now + std::chrono::seconds(20));
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].find("(189 such lines before it were left out)") != std::string::npos);
}

}  // namespace crsm
