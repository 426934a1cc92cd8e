#include "services/map_updater/pages.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>

#include "catch.hpp"
#include "synthetic_scans.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr AnswerOptions kOptions{5, 32000};

/// The owner of a map of a room.
struct Owner {
  Owner() {
    UpdateParameters parameters = TestParameters().update;
    parameters.cell_size_m = 0.02;  // the room is about forty tiles, several messages large
    updater.emplace(parameters);
  }

  /// The next scan, taken a little further on.
  void Draw(MatchState state = MatchState::kOk) {
    const auto k = static_cast<double>(history.size());
    const ScanMatch match{100 + std::ssize(history), {0.03 * k, 0.01 * k, 0.0}, 0.9, 1, 1, 0, state};
    for (const auto& change : updater->Update(AllRays(ScanRoom(match.T_map_laser, match.utime, 180)), match).tiles) {
      map.Apply(change);
    }
    history.push_back(match);
    matches.Append(match);
    tracking.Add(match);
  }
  map_page_t Page(const map_request_t& request) const {
    return MakePage(request, *updater, {matches, tracking}, kOptions);
  }

  std::optional<MapUpdater> updater;
  ByteMap map{0.02};  ///< what all changes together make
  std::vector<ScanMatch> history;
  MatchStore matches;
  TrackingState tracking;
};

map_request_t Ask(std::int64_t base_version, std::int32_t first_tile, std::int32_t first_match) {
  return {.requester = 77,
          .question = 1,
          .epoch = kOptions.epoch,
          .base_version = base_version,
          .first_tile = first_tile,
          .first_match = first_match};
}

}  // namespace

TEST_CASE(
    "a page has what changed since the version that a replica holds: nothing of an empty map, or beyond the end") {
  constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
  const Owner empty;
  Owner owner;
  owner.Draw();
  owner.Draw(MatchState::kLost);
  struct Case {
    const Owner& of;
    map_request_t request;
    std::int32_t num_matches, next_match;
  };
  for (const Case& a :
       {Case{empty, Ask(0, 0, 0), 0, 0}, {owner, Ask(1, 0, 1), 1, 2}, {owner, Ask(kFar, kFar, kFar), 0, 2}}) {
    const map_page_t page = a.of.Page(a.request);
    CHECK(Decode<map_page_t>(Encode(page)));
    CHECK(page.request.requester == 77);
    CHECK(page.version == std::ssize(a.of.history));
    CHECK(page.num_tiles == 0);
    CHECK(page.next_tile == -1);
    CHECK(page.num_matches == a.num_matches);
    CHECK(page.next_match == a.next_match);
  }
}

TEST_CASE("page by page the whole map and all matches are given, each tile once") {
  Owner owner;
  for (int i = 0; i < 5; ++i) owner.Draw();
  for (int i = 0; i < 600; ++i) owner.Draw(MatchState::kLost);
  ByteMap map(0.02);
  std::vector<ScanMatch> matches;
  std::size_t num_tiles = 0;
  int num_pages = 0;
  for (map_page_t page = owner.Page(Ask(0, 0, 0));; page = owner.Page(Ask(0, page.next_tile, page.next_match))) {
    REQUIRE(++num_pages < 100);
    const auto bytes = Encode(page);
    CHECK(bytes.size() <= kOptions.most_bytes);
    CHECK(Decode<map_page_t>(bytes));
    CHECK(page.version == 605);
    num_tiles += page.tiles.size();
    for (const map_tile_t& tile : page.tiles) CHECK(map.Apply(FromMessage(tile)));
    for (const scan_match_t& match : page.matches) matches.push_back(FromMessage(match));
    if (page.next_tile < 0) break;
  }
  CHECK(num_pages > 1);
  CHECK(num_tiles == owner.updater->num_tiles());
  CHECK(matches == owner.history);
  CHECK(map.ToDenseGrid().cells == owner.map.ToDenseGrid().cells);
}

TEST_CASE("a replica of another map, or of none, is given everything from the start") {
  Owner owner;
  for (int i = 0; i < 3; ++i) owner.Draw();
  map_request_t request = Ask(2, 5, 2);
  for (const std::int64_t epoch : {std::int64_t{0}, kOptions.epoch + 1}) {
    request.epoch = epoch;
    map_page_t page = owner.Page(request);
    CHECK(Encode(page.request) == Encode(request));
    page.request = Ask(0, 0, 0);
    CHECK(Encode(page) == Encode(owner.Page(Ask(0, 0, 0))));
  }
}

TEST_CASE(
    "who looks at the map is told where the scans were taken by all that is known, a matcher as they were matched") {
  const UpdateParameters drawing = TestParameters().update;
  Mapper mapper(drawing, {true, 30.0});
  MatchStore matches;
  TrackingState tracking;
  for (int i = 0; i < 5; ++i) {
    const ScanMatch match = MatchedAt(100 + i, {0.5 * i, 0.0, 0.0});
    const CriticalRays scan = AllRays(ScanRoom(match.T_map_laser, match.utime, 180));
    mapper.Integrate(&scan, match);
    matches.Append(match);
    tracking.Add(match);
  }
  GraphUpdate update;
  update.keyframe = {0, 3};
  update.moved = {{{0, 3}, {{1.5, 0.75, 0.1}}}};  // this one and what follows it are elsewhere
  REQUIRE(mapper.Accept(update));

  for (const int first_match : {0, 2, 4}) {
    const map_request_t request = Ask(0, 0, first_match);
    const map_page_t page = MakePage(request, mapper.local(), {matches, tracking, &mapper}, kOptions);
    const map_page_t as_matched = MakePage(request, mapper.local(), {matches, tracking}, kOptions);
    REQUIRE((page.num_matches == 5 - first_match && as_matched.num_matches == 5 - first_match));
    for (int i = first_match; i < 5; ++i) {
      const auto at = static_cast<std::size_t>(i - first_match);
      ScanMatch expected = matches.At(i);
      CHECK(FromMessage(as_matched.matches[at]) == expected);
      expected.T_map_laser = mapper.BestPose(i, matches.At(i).T_map_laser);
      CHECK(FromMessage(page.matches[at]) == expected);
      CHECK((expected == matches.At(i)) == (i < 3));
    }
  }
}

TEST_CASE("with the last matches who looks at the map is told its loops, and in no other page") {
  constexpr int kNumScans = 700;
  Mapper mapper(TestParameters().update, {true, 30.0});
  MatchStore matches;
  TrackingState tracking;
  CriticalRays scan = AllRays(ScanRoom({}, 0, 4));
  for (int i = 0; i < kNumScans; ++i) {
    scan.utime = i;
    const ScanMatch match = MatchedAt(i, {0.5 * i, 0.0, 0.0});
    mapper.Integrate(i == 0 || i > kNumScans - 300 ? &scan : nullptr, match);
    matches.Append(match);
    tracking.Add(match);
  }
  GraphUpdate update;  // far more loops than a page may have
  update.keyframe = *mapper.graph().newest();
  REQUIRE(update.keyframe.number >= 250);
  for (int k = 1; k <= 250; ++k) update.closed.push_back({{0, k - 1}, {0, k}, {}});
  REQUIRE(mapper.Accept(update));

  map_request_t request = Ask(0, 0, 0);
  int num_pages = 0;
  for (bool last = false; !last; ++num_pages) {
    const map_page_t page = MakePage(request, mapper.local(), {matches, tracking, &mapper}, kOptions);
    CHECK(Encode(page).size() <= kOptions.most_bytes);
    REQUIRE(Decode<map_page_t>(Encode(page)));
    last = page.next_match == kNumScans;
    std::vector<PlacedLoop> loops;
    for (const map_loop_t& loop : page.loops) loops.push_back(FromMessage(loop));
    CHECK(loops == (last ? mapper.PlaceLoops() : std::vector<PlacedLoop>()));
    request = Ask(0, page.next_tile, page.next_match);
  }
  CHECK(num_pages > 1);
  CHECK(MakePage(request, mapper.local(), {matches, tracking}, kOptions).num_loops == 0);  // of a matcher's map
  const auto FindError = [&](bool settled, BackgroundMapError* beside) {
    request.settled = settled ? 1 : 0;
    const map_page_t page =
        MakePage(request, mapper.local(), {matches, tracking, &mapper, {}, [] { return std::vector<PlacedMark>(); }, beside}, kOptions);
    REQUIRE(page.num_layouts == 1);
    return FromMessage(page.layout[0]).error;
  };
  BackgroundMapError beside;
  CHECK(FindError(true, &beside));         // in the end
  CHECK_FALSE(FindError(false, nullptr));  // meanwhile who maps does not wait for it
  CHECK_FALSE(FindError(false, &beside));
  for (int i = 0; i < 1000 && !FindError(false, &beside); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(FindError(false, &beside));
}

TEST_CASE("who wants no matches gets none, and the tracking state with the last page") {
  Owner owner;
  for (int i = 0; i < 5; ++i) owner.Draw();
  bool last = false;
  for (std::int32_t tile = 0; !last;) {
    const map_page_t page = owner.Page(Ask(0, tile, -1));
    CHECK(Decode<map_page_t>(Encode(page)));
    CHECK(page.num_matches == 0);
    CHECK(page.next_match == -1);
    last = page.next_tile < 0;
    REQUIRE(page.num_tracking == (last ? 1 : 0));
    if (last) CHECK(FromMessage(page.tracking[0]) == owner.tracking);
    tile = page.next_tile;
  }
}

TEST_CASE("marks come with the last matches, to those who want matches, and with no piece") {
  Owner owner;
  owner.Draw();
  owner.Draw();
  const std::vector<PlacedMark> marks{FromMessage(PlacedMarkMessage())};
  const auto Page = [&](std::int32_t first_match, std::optional<int> component = {}) {
    Mapper mapper(TestParameters().update, {});
    return MakePage(Ask(0, 0, first_match), *owner.updater,
                    {owner.matches, owner.tracking, component ? &mapper : nullptr, component, [&] { return marks; }},
                    kOptions);
  };
  CHECK(Page(0).num_marks == 1);
  CHECK(Page(2).num_marks == 1);
  CHECK(Page(-1).num_marks == 0);
  CHECK(Page(0, 7).num_marks == 0);
  CHECK(FromMessage(Decode<map_page_t>(Encode(Page(0))).value().marks[0]) == marks[0]);
}

}  // namespace crsm
