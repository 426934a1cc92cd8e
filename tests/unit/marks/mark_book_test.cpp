#include "common/marks/mark_book.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "graph/block.hpp"
#include "graph/nth.hpp"

namespace crsm {
namespace {

using Judgement = MarkBook::Judgement;

/// A drive along a corridor of a block: a keyframe every half metre, a second and half a metre apart.
struct Drive {
  explicit Drive(int num_keyframes) : mapper(Drawing(), {true, 30.0}) {
    const std::vector<Wall> walls = MakeBlock(5);
    for (int i = 0; i < num_keyframes; ++i) {
      const Pose2 T_world_laser = PlaceRoundBlock(5.0 + 0.5 * i);
      Random random(static_cast<std::uint64_t>(i));
      const std::int64_t utime = 1'000'000 * i;
      matches.push_back(MatchedAt(utime, Inverse(PlaceRoundBlock(5.0)) * T_world_laser));
      if (i == 0) matches.back().state = MatchState::kFirst;
      const CriticalRays scan{utime, SeeRays(walls, T_world_laser, random), {}};
      REQUIRE(mapper.Integrate(&scan, matches.back()).delta.drawn);
    }
  }

  static UpdateParameters Drawing() {
    UpdateParameters drawing = TestParameters().update;
    drawing.update_distance_m = 0.3;
    return drawing;
  }

  std::optional<ScanAt> At(std::int64_t scan) const {
    const bool is_there = scan >= 0 && scan < std::ssize(matches);
    return is_there ? std::optional(ScanAt{scan, matches[static_cast<std::size_t>(scan)]}) : std::nullopt;
  }

  /// Seen at the time of a scan, `x_m` ahead and `y_m` to the left of the laser.
  Judgement See(MarkBook& book, const std::string& id, int scan, double x_m, double y_m, double radius_m = 0.5,
                std::int64_t later_us = 0) const {
    Mark mark{1'000'000 * scan + later_us, id, "victim", "", MarkAction::kSeen, false, radius_m, {{x_m, y_m}}};
    const auto fixed = FixByLaser(mark, At(scan), later_us > 0 ? At(scan + 1) : std::nullopt, mapper);
    REQUIRE(fixed);
    const Judgement judgement = book.Judge(*fixed);
    REQUIRE(book.Add(*fixed, mapper));
    return judgement;
  }

  /// The keyframes from one number on are moved by a loop.
  void Move(int first, const Pose2& T_new_old) {
    GraphUpdate update;
    update.previous = mapper.last_update();
    update.keyframe = Nth(mapper.graph().size() - 1);
    PoseStretch& moved = update.moved.emplace_back(PoseStretch{Nth(first), {}});
    for (int k = first; k < mapper.graph().size(); ++k) {
      moved.poses.push_back(T_new_old * crsm::At(mapper.best_poses(), Nth(k)));
    }
    REQUIRE(mapper.Accept(update));
  }

  Mapper mapper;
  std::vector<ScanMatch> matches;
};

Mark OnMap(std::int64_t utime, const std::string& id, std::vector<Point> points,
           MarkAction action = MarkAction::kSeen) {
  return {utime, id, "keep-out", "stairs", action, true, 0.1, std::move(points)};
}

const std::vector<Point> kTriangle{{0.0, 0.0}, {2.0, 0.0}, {1.0, 1.0}};

void CheckAt(const Point& point, double x_m, double y_m, double tolerance_m = 1e-9) {
  CHECK(std::abs(point.x_m - x_m) < tolerance_m);
  CHECK(std::abs(point.y_m - y_m) < tolerance_m);
}

}  // namespace

TEST_CASE(
    "sightings of one id are one place: the mean by 1 / radius^2, with a covariance that knows how far they lie "
    "apart") {
  const Drive drive(6);
  MarkBook book;
  CHECK(book.empty());
  drive.See(book, "v", 2, 3.0, 1.0, 0.2);  // the laser at 1 m: at x 4 m
  PlacedMark mark = book.Place(drive.mapper).at(0);
  CheckAt(mark.points.at(0), 4.0, 1.0);
  CHECK(mark.covariance == std::array{0.2 * 0.2, 0.0, 0.2 * 0.2});
  drive.See(book, "v", 4, 2.6, 1.0, 0.4);  // the laser at 2 m: at x 4.6 m, with a quarter of the weight
  mark = book.Place(drive.mapper).at(0);
  REQUIRE(book.Place(drive.mapper).size() == 1);
  CheckAt(mark.points.at(0), (4.0 * 25.0 + 4.6 * 6.25) / 31.25, 1.0);
  CHECK(mark.num_sightings == 2);
  CHECK(mark.utime == 4'000'000);
  const double apart = 25.0 * 0.12 * 0.12 + 6.25 * 0.48 * 0.48;
  CHECK(std::abs(mark.covariance[0] - (1.0 + apart) / 31.25) < 1e-12);
  CHECK(std::abs(mark.covariance[2] - 1.0 / 31.25) < 1e-12);
  CHECK_FALSE(mark.floating);
}

TEST_CASE("what a book tells by keyframes lies where it says that places lie, also when a loop has moved them") {
  Drive drive(30);
  MarkBook book;
  drive.See(book, "v", 2, 3.0, 1.0, 0.4);
  drive.See(book, "v", 22, 1.0, 1.0, 0.2);  // which tells more
  REQUIRE(book.Add(FixOnMap(OnMap(1, "zone", {{0.5, 0.5}, {12.6, 0.5}, {12.6, 1.0}}), drive.mapper), drive.mapper));
  for (const double moved_m : {0.0, 2.0}) {
    if (moved_m > 0.0) drive.Move(20, {0.0, moved_m, 0.3});
    const auto placed = book.Place(drive.mapper);
    const auto anchored = book.Anchor(drive.mapper);
    REQUIRE(anchored.size() == placed.size());
    CHECK(anchored[0].points.at(0).keyframe == Nth(22));
    for (std::size_t i = 0; i < placed.size(); ++i) {
      CHECK(anchored[i].mark.id == placed[i].id);
      CHECK(anchored[i].mark.num_sightings == placed[i].num_sightings);
      REQUIRE(anchored[i].points.size() == placed[i].points.size());
      for (std::size_t k = 0; k < placed[i].points.size(); ++k) {
        const auto& [keyframe, at] = anchored[i].points[k];
        const Pose2 lies = crsm::At(drive.mapper.best_poses(), keyframe) * Pose2{at.x_m, at.y_m, 0.0};
        CheckAt(placed[i].points[k], lies.x_m, lies.y_m);
      }
      const double yaw_rad = crsm::At(drive.mapper.best_poses(), anchored[i].points[0].keyframe).yaw_rad;
      const auto turned = TurnCovariance(anchored[i].mark.covariance, yaw_rad);
      for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(turned[k] - placed[i].covariance[k]) < 1e-9);
    }
  }
}

TEST_CASE("sightings at one keyframe count as those at several do") {
  const Drive drive(6);
  MarkBook one;
  MarkBook each;
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    const double x_m = 5.0 + random.Uniform(-0.5, 0.5);
    const double y_m = random.Uniform(-0.5, 0.5);
    drive.See(one, "v", 2, x_m - 1.0, y_m, 0.3, i);
    drive.See(each, "v", i % 6, x_m - 0.5 * (i % 6), y_m, 0.3, i / 6);
  }
  const PlacedMark a = one.Place(drive.mapper).at(0);
  const PlacedMark b = each.Place(drive.mapper).at(0);
  CheckAt(a.points[0], b.points[0].x_m, b.points[0].y_m, 4e-5);  // in 40 us the robot has driven on
  CHECK(a.num_sightings == 40);
  // Of one keyframe the spread is kept as a number: the same along both axes.
  CHECK(std::abs(a.covariance[0] + a.covariance[2] - b.covariance[0] - b.covariance[2]) < 1e-6);
}

TEST_CASE("a mark between two scans is fixed where the laser was then; far from all scans, or at a lost one, nowhere") {
  Drive drive(6);
  Mark mark{2'250'000, "v", "victim", "", MarkAction::kSeen, false, 0.5, {{1.0, 0.0}}};
  MarkBook book;
  REQUIRE(book.Add(*FixByLaser(mark, drive.At(2), drive.At(3), drive.mapper), drive.mapper));
  CheckAt(book.Place(drive.mapper).at(0).points.at(0), 2.125, 0.0);
  mark = {2'250'000, "w", "victim", "", MarkAction::kSeen, false, 0.5, {{1.0, 0.0}}};
  drive.matches[3].state = MatchState::kLost;
  REQUIRE(book.Add(*FixByLaser(mark, drive.At(2), drive.At(3), drive.mapper), drive.mapper));
  CheckAt(book.Place(drive.mapper).at(1).points.at(0), 2.0, 0.0);  // by the scan before it alone
  mark.utime = 9'000'000;
  CHECK_FALSE(FixByLaser(mark, drive.At(5), std::nullopt, drive.mapper));
  CHECK_FALSE(FixByLaser(mark, std::nullopt, std::nullopt, drive.mapper));
  mark.utime = 4'000'000;
  drive.matches[4].state = MatchState::kLost;
  CHECK_FALSE(FixByLaser(mark, drive.At(4), std::nullopt, drive.mapper));
}

TEST_CASE("where a loop moves a wing of the map by two metres, its places move along, and no others") {
  Drive drive(30);
  MarkBook book;
  drive.See(book, "near", 2, 1.0, 0.5);
  drive.See(book, "far", 25, 1.0, 0.5);
  REQUIRE(book.Add(FixOnMap(OnMap(1, "zone", {{0.5, 0.5}, {12.6, 0.5}, {12.6, 1.0}}), drive.mapper), drive.mapper));
  const auto before = book.Place(drive.mapper);
  CheckAt(before[1].points[0], 13.5, 0.5);
  drive.Move(20, {0.0, 2.0, 0.0});
  const auto after = book.Place(drive.mapper);
  CHECK(after[0] == before[0]);
  CheckAt(after[1].points[0], 13.5, 2.5);
  CheckAt(after[2].points[0], 0.5, 0.5);  // each point of an outline with the keyframe nearest to it
  CheckAt(after[2].points[1], 12.6, 2.5);
  // What was seen from both sides of the bend is one place still, and less sure.
  drive.See(book, "both", 10, 6.0, 0.0, 0.5);
  drive.See(book, "both", 25, -1.5, 0.0, 0.5);  // 11 m along: now 2 m aside
  const PlacedMark both = book.Place(drive.mapper).at(3);
  CheckAt(both.points[0], 11.0, 1.0);
  CHECK(std::sqrt(both.covariance[2]) > 0.7);
  CHECK(std::sqrt(both.covariance[0]) < 0.36);
}

TEST_CASE("a mark that comes again is known; one that was removed comes back by who moves it alone") {
  const Drive drive(6);
  MarkBook book;
  CHECK(drive.See(book, "v", 2, 3.0, 1.0) == Judgement::kNew);
  const auto once = book.Place(drive.mapper);
  CHECK(drive.See(book, "v", 2, 9.0, 9.0) == Judgement::kKnown);
  CHECK(book.Place(drive.mapper) == once);
  CHECK(book.Judge(OnMap(7, "w", {}, MarkAction::kRemoved)) == Judgement::kUnknown);
  const FixedMark removed{{9, "v", "", "", MarkAction::kRemoved, false, 0.5, {}}, {}};
  REQUIRE(book.Add(removed, drive.mapper));
  CHECK(book.Place(drive.mapper).empty());
  CHECK(book.Judge(removed) == Judgement::kKnown);
  CHECK(drive.See(book, "v", 3, 3.0, 1.0) == Judgement::kRemoved);
  CHECK(book.Place(drive.mapper).empty());
  const FixedMark moved = FixOnMap(OnMap(11, "v", {{2.0, 3.0}}, MarkAction::kMoved), drive.mapper);
  REQUIRE(book.Add(moved, drive.mapper));
  CHECK(book.Judge(moved) == Judgement::kKnown);
  CHECK(drive.See(book, "v", 2, 9.0, 9.0) == Judgement::kKnown);  // sent again, late
  const PlacedMark mark = book.Place(drive.mapper).at(0);
  CheckAt(mark.points[0], 2.0, 3.0);
  CHECK(mark.kind == "keep-out");
  CHECK(mark.num_sightings == 1);
}

TEST_CASE("an outline is changed by who moves it alone") {
  const Drive drive(6);
  MarkBook book;
  REQUIRE(book.Add(FixOnMap(OnMap(1, "zone", kTriangle), drive.mapper), drive.mapper));
  CHECK(book.Judge(OnMap(2, "zone", kTriangle)) == Judgement::kIsOutline);
  CHECK(drive.See(book, "zone", 2, 1.0, 1.0) == Judgement::kIsOutline);
  CHECK(book.Place(drive.mapper).at(0).points.size() == 3);
  REQUIRE(book.Add(FixOnMap(OnMap(3, "zone", {{1.0, 1.0}}, MarkAction::kMoved), drive.mapper), drive.mapper));
  CHECK_FALSE(book.Place(drive.mapper).at(0).is_outline());
}

TEST_CASE("no sender fills the memory: places, outlines, keyframes and sightings have an end") {
  const Drive drive(2);
  MarkBook book;
  for (std::size_t i = 0; i < MarkBook::kMostMarks; ++i) {
    REQUIRE(book.Add(FixOnMap(OnMap(1, std::to_string(i), {{1.0, 1.0}}), drive.mapper), drive.mapper));
  }
  const Mark more = OnMap(1, "more", {{1.0, 1.0}});
  CHECK(book.Judge(more) == Judgement::kFull);
  REQUIRE(book.Add(FixOnMap(more, drive.mapper), drive.mapper));
  CHECK(book.Place(drive.mapper).size() == MarkBook::kMostMarks);
  REQUIRE(book.Add({{2, "7", "", "", MarkAction::kRemoved, false, 0.5, {}}, {}}, drive.mapper));
  CHECK(book.Judge(more) == Judgement::kNew);  // what was removed gives way
  REQUIRE(book.Add(FixOnMap(more, drive.mapper), drive.mapper));
  CHECK(book.Place(drive.mapper).size() == MarkBook::kMostMarks);

  MarkBook outlines;
  const std::vector<Point> largest(Mark::kMostPoints, Point{1.0, 2.0});
  std::size_t num = 0;
  while (outlines.Judge(OnMap(1, std::to_string(num), largest)) == Judgement::kNew) {
    REQUIRE(outlines.Add(FixOnMap(OnMap(1, std::to_string(num), largest), drive.mapper), drive.mapper));
    ++num;
  }
  CHECK(num == MarkBook::kMostOutlinePoints / Mark::kMostPoints);
  CHECK(outlines.Judge(OnMap(2, "0", largest, MarkAction::kMoved)) == Judgement::kNew);  // in place of its own

  MarkBook sightings;
  for (int i = 0; i < 2 * MarkBook::kMostOfGroup; ++i) {
    CHECK(drive.See(sightings, "v", 1, 1.0, 0.0, 0.5, i) ==
          (i < MarkBook::kMostOfGroup ? Judgement::kNew : Judgement::kKnown));
  }
  CHECK(sightings.Place(drive.mapper).at(0).num_sightings == MarkBook::kMostOfGroup);
}

TEST_CASE("what poses carry beyond all maps is not told, and sightings from one end to the other can be") {
  Drive drive(20);
  MarkBook book;
  drive.See(book, "far", 15, 1e6, 0.0);  // from 7.5 m on
  CHECK(book.Place(drive.mapper).empty());
  drive.See(book, "wide", 2, -1e6 + 2.0, -1e6, 0.001);
  drive.See(book, "wide", 3, 1e6 - 2.0, 1e6, 0.001);
  const auto placed = book.Place(drive.mapper);
  REQUIRE(placed.size() == 1);
  CHECK(placed[0].covariance[0] > 0.9e12);
  CHECK(placed[0].covariance[0] < 1e14);  // as the wire takes it
}

TEST_CASE("a mark of a keyframe that is not there is refused, as one with other points than it says") {
  const Drive drive(6);
  MarkBook book;
  const Mark mark = OnMap(1, "v", {{1.0, 1.0}});
  CHECK_FALSE(book.Add({mark, {{Nth(6), {1.0, 1.0}}}}, drive.mapper));
  CHECK_FALSE(book.Add({mark, {}}, drive.mapper));
  CHECK(book.empty());
  CHECK(book.Add({mark, {{std::nullopt, {1.0, 1.0}}}}, drive.mapper));
}

TEST_CASE("a place on a piece that is not joined with the map floats, in the frame of its own piece") {
  Drive drive(20);
  const std::vector<Wall> walls = MakeBlock(9);
  for (int i = 0; i < 5; ++i) {
    const Pose2 T_world_laser = PlaceRoundBlock(30.0 + 0.5 * i);
    Random random(static_cast<std::uint64_t>(i));
    const std::int64_t utime = 1'000'000 * (20 + i);
    drive.matches.push_back(MatchedAt(utime, {0.5 * i, 0.0, 0.0}));
    if (i == 0) drive.matches.back().state = MatchState::kFirst;
    const CriticalRays scan{utime, SeeRays(walls, T_world_laser, random), {}};
    REQUIRE(drive.mapper.Integrate(&scan, drive.matches.back()).delta.drawn);
  }
  MarkBook book;
  drive.See(book, "there", 22, 1.0, 0.0);
  drive.See(book, "both", 22, 1.0, 0.0);
  drive.See(book, "both", 3, 1.0, 0.0);
  const auto placed = book.Place(drive.mapper);
  CHECK(placed[0].floating);
  CHECK_FALSE(placed[1].floating);  // where it is on the map that is shown, that alone counts
  CHECK(placed[1].num_sightings == 1);
  CheckAt(placed[1].points[0], 2.5, 0.0);
}

}  // namespace crsm
