// A map in several pieces: why its trajectories began, what hangs together, and what is told of it.

#include "common/graph/pieces.hpp"

#include <limits>

#include "catch.hpp"
#include "common/graph/mapper.hpp"
#include "graph/block.hpp"
#include "services/diagnosis/break_news.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 30.0};

UpdateParameters Drawing() {
  UpdateParameters drawing = TestParameters().update;
  drawing.update_distance_m = 0.2;
  drawing.update_angle_rad = 0.2;
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
  std::vector<ScanMatch> matches;

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
    const std::int64_t scan = std::ssize(matches);
    Random random(static_cast<std::uint64_t>(scan));
    const CriticalRays rays{1'000'000 * scan, SeeRays(walls, PlaceRoundBlock(way_m), random), {}};
    ScanMatch match = MatchedAt(rays.utime, Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(way_m));
    if (begins) match.state = MatchState::kFirst;
    match.map_version = scan;
    match.by_wheels = by_wheels_;
    mapper.Integrate(&rays, match);
    matches.push_back(match);
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
  CHECK(DescribeBreak(log.at(1).start) == "scan 6: lost for 1.2 s: a new trajectory begins");
  CHECK(DescribeBreak(log.at(2).start) == "scan 8: no scan came for 20.0 s: a new trajectory begins");
  CHECK(DescribeBreak(log.at(3).start) == "scan 9: the clock went back by 5.0 s: a new trajectory begins");
  Check(1, BreakReason::kLost, 1.2, 6);  // since the first scan
  Check(2, BreakReason::kGap, 20.0, 8);
  Check(3, BreakReason::kClock, 5.0, 9);
  Check(4, BreakReason::kSession, 0.2, 13);
  Check(5, BreakReason::kSession, 0.2, 14);
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
  CHECK(apart.pieces[0].way_m == Approx(59 * 0.25));
  CHECK(apart.OthersWithMap() == std::vector{2, 3});  // less than 3 m of way
  CHECK(apart.OthersWithMap({.least_way_m = 0.7}) == std::vector{2, 3, 4});
  REQUIRE(apart.breaks.size() == 3);
  CHECK(apart.breaks[0].scan == 20);
  CHECK(apart.breaks[0].piece_before == 3);
  CHECK(apart.breaks[0].piece == 1);
  CHECK_FALSE(apart.breaks[0].joined());
  CHECK(apart.breaks[2].piece == 4);
  const Pose2 end = Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(5.0 + 19 * 0.25);
  CHECK(Length(Inverse(end) * apart.breaks[0].T_map_before) < 1e-9);
  REQUIRE(drive.Join(0, 2));
  const MapPieces joined = drive.mapper.FindPieces();
  CHECK(joined.num_pieces == 3);
  CHECK(ScansOf(joined) == std::vector<std::int64_t>{60, 60, 4});
  CHECK(drive.mapper.FindPieceNumbers() == std::vector{1, 2, 1, 3});  // of two of one size the older one is shown
  REQUIRE(drive.mapper.PlaceLoops().size() == 1);
  CHECK(drive.mapper.PlaceLoops()[0].joins);
  drive.Add(MakeBlock(5), 36.0, false);  // an update is of a newer keyframe than the last
  REQUIRE(drive.Join(1, 2));
  BrokenDrive elsewhere({20, 20, 60});
  REQUIRE(elsewhere.Join(0, 1));
  CHECK(elsewhere.mapper.PlaceLoops().empty());  // on the map that is shown
  CHECK(ScansOf(drive.mapper.FindPieces()) == std::vector<std::int64_t>{120, 5});
  CHECK(drive.mapper.FindPieces().breaks[0].joined());
  CHECK_FALSE(drive.mapper.FindPieces().breaks[2].joined());
}

TEST_CASE("a break is where the last scan before it was matched, be it drawn or not") {
  BrokenDrive drive({20});
  const std::vector<Wall> walls = MakeBlock(5);
  const double last_m = 5.0 + 19 * 0.25 + 0.1;
  drive.Add(walls, last_m, false);  // not as far from the one before as is drawn
  CHECK(drive.mapper.graph().size() == 20);
  drive.Add(walls, 30.0, true);
  const Pose2 expected = Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(last_m);
  REQUIRE(drive.mapper.FindPieces().breaks.size() == 1);
  CHECK(Length(Inverse(expected) * drive.mapper.FindPieces().breaks[0].T_map_before) < 1e-9);
}

TEST_CASE("where the wheels bridge the breaks the map is one piece, and says how often it hangs on them alone") {
  BrokenDrive drive({20, 60, 40}, WheelMotion{{0.25, 0.0, 0.0}, 0.02, 0.01});
  const MapPieces bridged = drive.mapper.FindPieces();
  CHECK(bridged.num_pieces == 1);
  CHECK(bridged.num_breaks == 2);
  CHECK(bridged.num_bridged == 2);
  CHECK_FALSE(drive.mapper.BestMatch(119, drive.matches[119]).floating);
  const Keyframe& first = drive.mapper.graph().keyframe({1, 0});
  REQUIRE(first.by_wheels);
  CHECK(first.by_wheels->T_from_to.x_m > 0.2);
  REQUIRE(drive.Join(0, 1));
  CHECK(drive.mapper.FindPieces().num_bridged == 1);
  CHECK(BrokenDrive({20, 60, 40}).mapper.FindPieces().num_bridged == 0);
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
