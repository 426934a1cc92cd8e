#include "services/map_updater/answers.hpp"

#include <algorithm>
#include <limits>

#include "catch.hpp"
#include "map_owner.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr std::size_t kMostBytes = MapOwner::kMostBytes;
constexpr std::size_t kLargestTileMessageBytes = kMaxRunBytes + 300;

constexpr std::int64_t kEpoch = 5;
const MapGeometry kGeometry(0.05);

/// The owner of the map that is asked for.
struct Owner : MapOwner {
  Owner() { epoch = kEpoch; }
};

/// A delta of whole tiles, or of tiles with one changed cell each.
MapDelta MakeDelta(int num_tiles, bool whole) {
  MapDelta delta{8, true, {}};
  for (int i = 0; i < num_tiles; ++i) {
    TileChange change{{i % 64, i / 64}, {0, 0, 0, 1, 9}};
    if (whole) change.runs.assign(kMaxRunBytes, 16);
    delta.tiles.push_back(std::move(change));
  }
  return delta;
}

map_request_t Ask(std::int64_t base_version, std::int32_t first_tile, std::int32_t first_match) {
  return {77, 1, kEpoch, base_version, first_tile, first_match, -1, 0, 0, 0};
}

}  // namespace

TEST_CASE("a match that changed nothing is answered by one empty part") {
  const ScanMatch match{5, {1.0, 2.0, 0.5}, 0.9, 10, 20, 7, MatchState::kLost};
  const auto parts = MakeParts({8, false, {}}, match, kGeometry, {kEpoch, kMostBytes});
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].utime == 5);
  CHECK(parts[0].epoch == kEpoch);
  CHECK(parts[0].version == 8);
  CHECK(parts[0].base_version == 7);
  CHECK(parts[0].cell_size_m == 0.05);
  CHECK(parts[0].num_parts == 1);
  CHECK(parts[0].num_requests == 0);
  CHECK(parts[0].num_tiles == 0);
  REQUIRE(parts[0].num_matches == 1);
  CHECK(FromMessage(parts[0].matches[0]) == match);
  CHECK(Decode<map_delta_t>(Encode(parts[0])));
}

TEST_CASE("a large change is split into well-formed parts of a size that hold each tile once, in order") {
  const auto most_bytes = GENERATE(as<std::size_t>{}, 32000, 1400, 48000);
  for (const bool whole : {true, false}) {
    for (const int num_tiles : {1, 7, 100, 6000}) {
      const MapDelta delta = MakeDelta(whole ? std::min(num_tiles, 100) : num_tiles, whole);
      const auto parts = MakeParts(delta, {5, {}, 0.9, 1, 1, 7, MatchState::kOk}, kGeometry, {kEpoch, most_bytes});
      CAPTURE(most_bytes, whole, num_tiles, parts.size());
      std::size_t next = 0;
      int num_wrong = 0;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto bytes = Encode(parts[i]);
        CHECK(bytes.size() <= (parts[i].num_tiles == 1 ? std::max(most_bytes, kLargestTileMessageBytes) : most_bytes));
        CHECK(Decode<map_delta_t>(bytes));
        CHECK(parts[i].part == static_cast<int>(i));
        CHECK(parts[i].num_parts == static_cast<int>(parts.size()));
        CHECK(parts[i].num_matches == (i == 0 ? 1 : 0));
        for (const map_tile_t& tile : parts[i].tiles)
          num_wrong += FromMessage(tile).index != delta.tiles.at(next++).index;
      }
      CHECK(num_wrong == 0);
      CHECK(next == delta.tiles.size());
    }
  }
}

TEST_CASE("what a match has brought about is said once, in the first part") {
  const Pose2 T_new_old{0.25, -0.5, 1.0 / 3.0};
  const ScanMatch match{5, {}, 0.9, 1, 1, 7, MatchState::kOk};
  for (const int num_tiles : {0, 100}) {
    const MapDelta delta = MakeDelta(num_tiles, true);
    const auto parts = MakeParts(delta, match, kGeometry, {kEpoch, kMostBytes}, {T_new_old, 3, true});
    REQUIRE((parts.size() > 1) == (num_tiles > 0));
    for (const map_delta_t& part : parts) {
      const auto bytes = Encode(part);
      CHECK(bytes.size() <= kMostBytes);
      CHECK(Decode<map_delta_t>(bytes));
      REQUIRE(part.num_moved == (part.part == 0 ? 1 : 0));
      if (part.part == 0) CHECK(FromMessage(part.T_new_old[0]) == T_new_old);
      CHECK(part.trajectory == (part.part == 0 ? 3 : 0));
      CHECK(part.floating == (part.part == 0 ? 1 : 0));
    }
    for (const map_delta_t& part : MakeParts(delta, match, kGeometry, {kEpoch, kMostBytes})) CHECK(part.num_moved == 0);
  }
}

TEST_CASE("the page of an empty map is empty and the last") {
  const Owner owner;
  const map_delta_t page = owner.Page(Ask(0, 0, 0));
  REQUIRE(page.num_requests == 1);
  CHECK(page.request[0].requester == 77);
  CHECK(page.version == 0);
  CHECK(page.num_tiles == 0);
  CHECK(page.num_matches == 0);
  CHECK(page.next_tile == -1);
  CHECK(page.next_match == 0);
  CHECK(Decode<map_delta_t>(Encode(page)));
}

TEST_CASE("page by page the whole map and all matches are given, each tile once") {
  Owner owner;
  for (int i = 0; i < 5; ++i) owner.Answer();
  for (int i = 0; i < 600; ++i) owner.Answer(MatchState::kLost);
  ByteMap map(MapOwner::kCellSize_m);
  std::vector<ScanMatch> matches;
  std::size_t num_tiles = 0;
  int num_pages = 0;
  for (map_delta_t page = owner.Page(Ask(0, 0, 0));; page = owner.Page(Ask(0, page.next_tile, page.next_match))) {
    REQUIRE(++num_pages < 100);
    const auto bytes = Encode(page);
    CHECK(bytes.size() <= kMostBytes);
    CHECK(Decode<map_delta_t>(bytes));
    CHECK(page.version == 605);
    num_tiles += page.tiles.size();
    for (const map_tile_t& tile : page.tiles) CHECK(map.Apply(FromMessage(tile)));
    for (const scan_match_t& match : page.matches) matches.push_back(FromMessage(match));
    if (page.next_tile < 0) break;
  }
  CHECK(num_pages > 1);
  CHECK(num_tiles == owner.num_tiles());
  CHECK(matches == owner.history);
  CHECK(map.ToDenseGrid().cells == owner.map.ToDenseGrid().cells);
}

TEST_CASE("a replica that holds a version is given only what changed since") {
  Owner owner;
  owner.Answer();
  owner.Answer(MatchState::kLost);
  const map_delta_t page = owner.Page(Ask(1, 0, 1));
  CHECK(page.num_tiles == 0);
  CHECK(page.next_tile == -1);
  CHECK(page.num_matches == 1);
  CHECK(page.next_match == 2);
}

TEST_CASE("a replica of another map, or of none, is given everything from the start") {
  Owner owner;
  for (int i = 0; i < 3; ++i) owner.Answer();
  map_request_t request = Ask(2, 5, 2);
  for (const std::int64_t epoch : {std::int64_t{0}, kEpoch + 1}) {
    request.epoch = epoch;
    map_delta_t page = owner.Page(request);
    CHECK((page.num_requests == 1 && Encode(page.request[0]) == Encode(request)));
    page.request = {Ask(0, 0, 0)};
    CHECK(Encode(page) == Encode(owner.Page(Ask(0, 0, 0))));
  }
}

TEST_CASE(
    "who looks at the map is told where the scans were taken by all that is known, a matcher as they were matched") {
  const UpdateParameters drawing = TestParameters().update;
  Mapper mapper(drawing, {true, 30.0, 10});
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

  const AnswerOptions options{kEpoch, kMostBytes};
  for (const int first_match : {0, 2, 4}) {
    const map_request_t request = Ask(0, 0, first_match);
    const map_delta_t page = MakePage(request, mapper.local(), {matches, tracking, &mapper}, options);
    const map_delta_t as_matched = MakePage(request, mapper.local(), {matches, tracking}, options);
    REQUIRE(page.num_matches == 5 - first_match);
    REQUIRE(as_matched.num_matches == 5 - first_match);
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
  Mapper mapper(TestParameters().update, {true, 30.0, 10});
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

  const AnswerOptions options{kEpoch, kMostBytes};
  map_request_t request = Ask(0, 0, 0);
  int num_pages = 0;
  for (bool last = false; !last; ++num_pages) {
    const map_delta_t page = MakePage(request, mapper.local(), {matches, tracking, &mapper}, options);
    CHECK(Encode(page).size() <= kMostBytes);
    REQUIRE(Decode<map_delta_t>(Encode(page)));
    last = page.next_match == kNumScans;
    std::vector<PlacedLoop> loops;
    for (const map_loop_t& loop : page.loops) loops.push_back(FromMessage(loop));
    CHECK(loops == (last ? mapper.PlaceLoops() : std::vector<PlacedLoop>()));
    request = Ask(0, page.next_tile, page.next_match);
  }
  CHECK(num_pages > 1);
  CHECK(MakePage(request, mapper.local(), {matches, tracking}, options).num_loops == 0);  // of a matcher's map
}

TEST_CASE("an answer given again after others says which version there is, and changes nothing") {
  Owner owner;
  for (int i = 0; i < 3; ++i) owner.Answer();
  const auto answer = Decode<map_delta_t>(Encode(owner.AnswerAgain(101)));
  REQUIRE(answer);
  CHECK(answer->utime == 101);
  CHECK(answer->epoch == kEpoch);
  CHECK(answer->version == 3);
  CHECK(answer->base_version == 3);
  CHECK(answer->num_requests == 0);
  CHECK(answer->num_tiles == 0);
  CHECK(answer->num_matches == 0);
}

TEST_CASE("a request beyond what there is gets nothing") {
  Owner owner;
  owner.Answer();
  const std::int32_t far = std::numeric_limits<std::int32_t>::max();
  const map_delta_t page = owner.Page(Ask(far, far, far));
  CHECK(page.num_tiles == 0);
  CHECK(page.num_matches == 0);
  CHECK(page.next_tile == -1);
  CHECK(page.next_match == 1);
}

TEST_CASE("who wants no matches gets none, and the tracking state with the last page") {
  Owner owner;
  for (int i = 0; i < 5; ++i) owner.Answer();
  bool last = false;
  for (std::int32_t tile = 0; !last;) {
    const map_delta_t page = owner.Page(Ask(0, tile, -1));
    CHECK(Decode<map_delta_t>(Encode(page)));
    CHECK(page.num_matches == 0);
    CHECK(page.next_match == -1);
    last = page.next_tile < 0;
    REQUIRE(page.num_tracking == (last ? 1 : 0));
    if (last) CHECK(FromMessage(page.tracking[0]) == owner.tracking);
    tile = page.next_tile;
  }
}

TEST_CASE("who asks about a scan is told its match, or that it is not in the map") {
  Owner owner;
  for (int i = 0; i < 3; ++i) owner.Answer();
  map_request_t request = Ask(3, 0, -1);
  for (const std::int64_t utime : {100, 102}) {
    request.asked_utime = utime;
    const map_delta_t page = owner.Page(request);
    CHECK(page.request[0].asked_utime == utime);
    REQUIRE(page.num_asked == 1);
    CHECK(FromMessage(page.asked[0]) == owner.history[static_cast<std::size_t>(utime - 100)]);
    CHECK(Decode<map_delta_t>(Encode(page)));
  }
  for (const std::int64_t utime : {0, 99, 103}) {
    request.asked_utime = utime;
    CHECK(owner.Page(request).request[0].asked_utime == utime);
    CHECK(owner.Page(request).num_asked == 0);
  }
}

}  // namespace crsm

#include "services/map_updater/answers.cpp"  // in no library: it is map_updater's own
