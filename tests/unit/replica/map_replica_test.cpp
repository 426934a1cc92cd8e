#include "services/replica/map_replica.hpp"

#include <algorithm>
#include <limits>

#include "catch.hpp"
#include "map_owner.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kRequester = 77;

/// A replica and the map that it keeps, with all matches or with the tracking state that follows from them.
class TestReplica {
 public:
  explicit TestReplica(bool wants_matches = true) : wants_matches_(wants_matches) {}

  void Handle(const std::vector<map_delta_t>& parts) {
    for (const map_delta_t& part : parts) replica.Handle(part);
  }

  /// Asks the owner until nothing is left to ask; how many pages that took.
  int Ask(const MapOwner& owner) {
    int num_pages = 0;
    for (; const auto request = replica.NextRequest(); ++num_pages) {
      REQUIRE(num_pages < 1000);
      const auto page = Decode<map_delta_t>(Encode(owner.Page(*request)));
      REQUIRE(page);
      replica.Handle(*page);
    }
    return num_pages;
  }

  void CheckSameAs(const MapOwner& owner) const {
    CHECK(replica.synced());
    CHECK(replica.version() == owner.version());
    if (wants_matches_) {
      CHECK(matches == owner.history);
    } else {
      CHECK(replica.tracking() == owner.tracking);
    }
    CHECK(map.geometry().cell_size_m() == MapOwner::kCellSize_m);
    CHECK(map.ToDenseGrid().cells == owner.map.ToDenseGrid().cells);
  }

 private:
  bool wants_matches_;

 public:
  ByteMap map{1.0};
  std::vector<ScanMatch> matches;
  int num_begins = 0;
  MapReplica replica{kRequester,
                     {[this](double cell_size_m) {
                        map = ByteMap(cell_size_m);
                        matches.clear();
                        ++num_begins;
                      },
                      [this](std::span<const TileChange> changes) {
                        for (const TileChange& change : changes) CHECK(map.Apply(change));
                      },
                      wants_matches_ ? [this](const ScanMatch& match) { matches.push_back(match); }
                                     : std::function<void(const ScanMatch&)>()}};
};

/// A replica in step with an owner that has drawn a few scans.
void Begin(TestReplica& replica, MapOwner& owner, int num_scans = 3) {
  for (int i = 0; i < num_scans; ++i) owner.Answer();
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

}  // namespace

TEST_CASE("a new replica asks for everything, and again until it is answered") {
  TestReplica replica;
  CHECK_FALSE(replica.replica.synced());
  CHECK(replica.num_begins == 0);
  for (int i = 0; i < 2; ++i) {
    const auto request = replica.replica.NextRequest();
    REQUIRE(request);
    CHECK(request->requester == kRequester);
    CHECK(request->epoch == 0);
    CHECK(request->base_version == 0);
    CHECK(request->first_tile == 0);
    CHECK(request->first_match == 0);
  }
}

TEST_CASE("a replica from the start follows the owner delta by delta") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  CHECK(replica.Ask(owner) == 1);
  for (int i = 0; i < 10; ++i) {
    replica.Handle(owner.Answer(i % 4 == 3 ? MatchState::kLost : MatchState::kOk));
    replica.CheckSameAs(owner);
    CHECK_FALSE(replica.replica.NextRequest());
  }
}

TEST_CASE("a replica whose map is put right moves what is remembered of the scans, that of this answer too") {
  const Pose2 T_new_old{0.5, -0.25, 0.1};
  MapOwner owner;
  TestReplica replica(false);
  if (GENERATE(true, false)) Begin(replica, owner);  // or the first scan, whose answer has several parts
  if (owner.version() == 0) replica.Ask(owner);
  std::vector<map_delta_t> parts = owner.Answer(MatchState::kOk, {T_new_old, 2, true});
  if (owner.version() == 1) REQUIRE(parts.size() > 1);
  std::reverse(parts.begin(), parts.end());
  replica.Handle(parts);
  replica.CheckSameAs(owner);
  const TrackingState& tracking = replica.replica.tracking();
  CHECK(tracking.recent().back().T_map_laser == T_new_old * owner.history.back().T_map_laser);
  CHECK(tracking.T_local_map() == Inverse(T_new_old));
  CHECK(tracking.trajectory() == 2);
  CHECK(tracking.floating());

  replica.Handle(owner.Answer());  // which is not moved
  replica.CheckSameAs(owner);
  replica.Handle(owner.Answer(MatchState::kLost, {T_new_old}));
  replica.CheckSameAs(owner);

  TestReplica late(false);
  late.Ask(owner);
  late.CheckSameAs(owner);
}

TEST_CASE("who wants all matches gets them as they were matched, however the map is moved") {
  MapOwner owner;
  TestReplica replica;
  Begin(replica, owner);
  replica.Handle(owner.Answer(MatchState::kOk, {Pose2{0.5, -0.25, 0.1}}));
  replica.CheckSameAs(owner);
}

TEST_CASE("a replica has the loops of the last page of matches, until it is told others or begins anew") {
  MapOwner owner;
  TestReplica replica;
  Begin(replica, owner);
  owner.Answer(MatchState::kLost);  // changes nothing: its page is the only one
  const PlacedLoop loop{{1.0, 2.0, 0.5}, {1.5, 2.0, -0.5}, true};
  const auto Tell = [&](const std::vector<PlacedLoop>& loops, std::int32_t matches_left) {
    replica.replica.Doubt();
    map_delta_t page = owner.Page(replica.replica.NextRequest().value());
    page.next_match -= matches_left;
    page.num_matches -= matches_left;
    page.matches.resize(static_cast<std::size_t>(page.num_matches));
    for (const PlacedLoop& each : loops) page.loops.push_back(ToMessage(each));
    page.num_loops = static_cast<std::int32_t>(page.loops.size());
    replica.replica.Handle(page);
    return replica.replica.loops();
  };
  CHECK(Tell({loop}, 1).empty());  // there is more to come
  CHECK(Tell({loop, {}}, 0) == std::vector<PlacedLoop>{loop, {}});
  CHECK(Tell({loop}, 0) == std::vector<PlacedLoop>{loop});
  replica.CheckSameAs(owner);
  MapOwner another;
  replica.replica.Doubt();
  replica.Ask(another);
  CHECK(replica.replica.loops().empty());
}

TEST_CASE("a late joiner gets the map page by page") {
  MapOwner owner;
  for (int i = 0; i < 5; ++i) owner.Answer();
  for (int i = 0; i < 600; ++i) owner.Answer(MatchState::kLost);
  TestReplica replica(GENERATE(true, false));
  CHECK(replica.Ask(owner) > 1);
  replica.CheckSameAs(owner);
  replica.Handle(owner.Answer());
  replica.CheckSameAs(owner);
}

TEST_CASE("a map that changes while its pages are under way is whole in the end") {
  MapOwner owner;
  for (int i = 0; i < 5; ++i) owner.Answer();
  TestReplica replica(GENERATE(true, false));
  int num_pages = 0;
  for (; const auto request = replica.replica.NextRequest(); ++num_pages) {
    REQUIRE(num_pages < 1000);
    const map_delta_t page = owner.Page(*request);
    if (num_pages < 20) replica.Handle(owner.Answer());  // overtakes the page
    replica.replica.Handle(page);
  }
  replica.CheckSameAs(owner);
}

TEST_CASE("a lost version is noticed with the next one and healed") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  owner.Answer();
  const auto next = owner.Answer();
  replica.Handle(next);
  CHECK_FALSE(replica.replica.synced());
  CHECK(replica.replica.version() == 3);
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("any lost part keeps the version out; the part sent again completes it") {
  MapOwner reference;
  const std::size_t num_parts = reference.Answer().size();
  REQUIRE(num_parts > 1);
  for (std::size_t lost = 0; lost < num_parts; ++lost) {
    MapOwner owner;
    TestReplica replica;
    replica.Ask(owner);
    const auto parts = owner.Answer();
    for (std::size_t i = 0; i < num_parts; ++i) {
      if (i != lost) replica.replica.Handle(parts[i]);
    }
    CHECK(replica.replica.version() == 0);
    CHECK(replica.map.tiles().entries().empty());
    replica.Handle(parts);
    replica.CheckSameAs(owner);
  }
}

TEST_CASE("a lost part is healed by pages too, when the replica doubts or the next version comes") {
  for (const bool doubt : {true, false}) {
    MapOwner owner;
    TestReplica replica;
    replica.Ask(owner);
    replica.replica.Handle(owner.Answer().front());
    if (doubt) {
      replica.replica.Doubt();
    } else {
      replica.Handle(owner.Answer());
    }
    CHECK_FALSE(replica.replica.synced());
    replica.Ask(owner);
    replica.CheckSameAs(owner);
  }
}

TEST_CASE("parts in any order make the same version") {
  MapOwner owner;
  TestReplica replica;
  replica.Ask(owner);
  auto parts = owner.Answer();
  std::reverse(parts.begin(), parts.end());
  replica.Handle(parts);
  replica.CheckSameAs(owner);
}

TEST_CASE("messages that come twice change nothing") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  for (int i = 0; i < 2; ++i) owner.Answer();
  while (const auto request = replica.replica.NextRequest()) {
    const map_delta_t page = owner.Page(*request);
    for (int i = 0; i < 3; ++i) replica.replica.Handle(page);
  }
  replica.CheckSameAs(owner);
  const auto parts = owner.Answer();
  for (int i = 0; i < 3; ++i) replica.Handle(parts);
  replica.CheckSameAs(owner);
}

TEST_CASE("an old page that comes late does no harm") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  for (int i = 0; i < 5; ++i) owner.Answer();
  std::vector<map_delta_t> pages;
  for (int i = 0; i < 100 && replica.replica.NextRequest(); ++i) {
    pages.push_back(owner.Page(*replica.replica.NextRequest()));
    if (i % 2 == 1) replica.replica.Handle(pages.front());
    replica.replica.Handle(pages.back());
  }
  replica.CheckSameAs(owner);
  for (const map_delta_t& page : pages) replica.replica.Handle(page);
  replica.CheckSameAs(owner);
}

TEST_CASE("pages for another replica are not its own") {
  MapOwner owner;
  TestReplica replica;
  for (int i = 0; i < 5; ++i) owner.Answer();
  replica.replica.Handle(owner.Page({kRequester + 1, 1, 0, 0, 0, 0, -1, 0, 0, 0}));
  CHECK(replica.map.tiles().entries().empty());
  CHECK(replica.matches.empty());
  CHECK_FALSE(replica.replica.synced());
}

TEST_CASE("an owner that lost its map is followed from the start of the new one") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  MapOwner anew;
  replica.Handle(anew.Answer());
  CHECK_FALSE(replica.replica.synced());
  replica.Ask(anew);
  CHECK(replica.num_begins == 2);
  replica.CheckSameAs(anew);
  replica.Handle(anew.Answer());
  replica.CheckSameAs(anew);
}

TEST_CASE("an owner that began anew and overtook the replica is told from the old one") {
  for (const int num_scans : {3, 4, 5, 8}) {  // behind, level, the very next version, far ahead
    MapOwner owner;
    TestReplica replica;
    Begin(replica, owner, 4);
    MapOwner anew;
    for (int i = 1; i < num_scans; ++i) anew.Answer(MatchState::kLost);
    replica.Handle(anew.Answer());
    CHECK_FALSE(replica.replica.synced());
    CHECK(replica.matches == owner.history);  // nothing is thrown away before the owner has said so
    replica.Ask(anew);
    CHECK(replica.num_begins == 2);
    CHECK(replica.replica.epoch() == anew.epoch);
    replica.CheckSameAs(anew);
  }
}

TEST_CASE("a delta of a map that nobody owns makes the replica ask, and changes nothing") {
  MapOwner owner;
  TestReplica replica;
  Begin(replica, owner);
  for (const std::int64_t version : {0, 3, 4, 1000}) {
    map_delta_t delta = owner.AnswerAgain(5);
    delta.epoch = owner.epoch + 1000;
    delta.version = delta.base_version = version;
    replica.replica.Handle(delta);
    CHECK_FALSE(replica.replica.synced());
    CHECK(replica.Ask(owner) == 1);
    CHECK(replica.num_begins == 1);
    replica.CheckSameAs(owner);
  }
}

TEST_CASE("a delta that leads on from a version that is not held is not applied, whatever version it makes") {
  const bool wants_matches = GENERATE(true, false);
  for (const std::int64_t base_version : {0, 2, 4}) {
    MapOwner owner;
    TestReplica replica(wants_matches);
    Begin(replica, owner);
    const auto before = replica.map.ToDenseGrid().cells;
    auto parts = owner.Answer();
    for (map_delta_t& part : parts) part.base_version = base_version;
    replica.Handle(parts);
    CHECK(replica.replica.version() == 3);
    CHECK_FALSE(replica.replica.synced());
    CHECK(replica.map.ToDenseGrid().cells == before);
    replica.Ask(owner);
    replica.CheckSameAs(owner);
  }
}

TEST_CASE("a page of what changed since a later version than the one held does not make up for what is between") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  for (int i = 0; i < 6; ++i) owner.Answer();
  replica.replica.Doubt();
  map_delta_t page =
      owner.Page({kRequester, 2, owner.epoch, owner.version(), 0, 3, -1, 0, 0, 0});  // no tile has changed since
  REQUIRE(page.num_tiles == 0);
  page.next_tile = -1;  // it says that it is the last one
  page.request = {replica.replica.NextRequest().value()};
  replica.replica.Handle(page);
  CHECK_FALSE(replica.replica.synced());
  CHECK(replica.replica.version() == 3);
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a late page of the old map does no lasting harm") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  const map_delta_t late = owner.Page({kRequester, 1, owner.epoch, 1, 0, 1, -1, 0, 0, 0});
  MapOwner anew;
  replica.Handle(anew.Answer());
  replica.Ask(anew);
  replica.replica.Handle(late);
  replica.Ask(anew);
  replica.CheckSameAs(anew);
}

TEST_CASE("pages that answer a question in the replica's name that it did not ask are left out, and counted") {
  using Change = std::function<void(map_request_t&)>;
  const std::vector<Change> changes{
      [](auto& request) { request.first_tile = std::numeric_limits<std::int32_t>::max(); },
      [](auto& request) { request.first_tile += 1; },
      [](auto& request) { request.first_match += 1; },
      [](auto& request) { request.first_match = request.first_match < 0 ? 0 : -1; },
      [](auto& request) { request.base_version += 1; },
      [](auto& request) { request.epoch += 1; },
      [](auto& request) { request.asked_utime = 101; },
      [](auto& request) { request.whole = 1; },
      [](auto& request) { request.settled = 1; },
      [](auto& request) { request.question += 1; },
  };
  const bool wants_matches = GENERATE(true, false);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    INFO(i);
    MapOwner owner;
    for (int k = 0; k < 5; ++k) owner.Answer();
    TestReplica replica(wants_matches);
    std::int64_t num_forged = 0;
    while (const auto request = replica.replica.NextRequest()) {
      map_request_t forged = *request;
      changes[i](forged);
      replica.replica.Handle(owner.Page(forged));  // before the answer to the replica's own, and behind it
      CHECK(replica.replica.num_forged() == ++num_forged);
      CHECK(replica.replica.NextRequest()->question == request->question);
      replica.replica.Handle(owner.Page(*request));
      replica.replica.Handle(owner.Page(forged));
      ++num_forged;
    }
    CHECK(replica.replica.num_forged() == num_forged);
    replica.CheckSameAs(owner);
  }
}

TEST_CASE("a question that is asked again keeps its number, and an answer that comes twice is nobody's forgery") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  for (int i = 0; i < 5; ++i) owner.Answer();
  std::int64_t last_question = 0;
  while (const auto request = replica.replica.NextRequest()) {
    CHECK(request->question == last_question + 1);
    CHECK(replica.replica.NextRequest()->question == request->question);
    last_question = request->question;
    for (int i = 0; i < 2; ++i) replica.replica.Handle(owner.Page(*request));
  }
  CHECK(last_question > 1);
  CHECK(replica.replica.num_forged() == 0);
  replica.CheckSameAs(owner);
}

TEST_CASE("what was answered before the loops were looked for is not taken as settled") {
  MapOwner owner;
  TestReplica replica;
  Begin(replica, owner);
  replica.replica.Doubt();
  const map_delta_t unsettled = owner.Page(replica.replica.NextRequest().value());
  replica.replica.AwaitSettled();
  replica.replica.Handle(unsettled);
  CHECK_FALSE(replica.replica.synced());
  CHECK(replica.replica.NextRequest()->settled == 1);
  replica.Ask(owner);
  replica.CheckSameAs(owner);
  CHECK(replica.replica.num_forged() == 0);
}

TEST_CASE("an answer given again after others changes nothing; who lacks its version asks") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  replica.replica.Handle(owner.AnswerAgain(100));
  replica.CheckSameAs(owner);
  owner.Answer();
  replica.replica.Handle(owner.AnswerAgain(100));
  CHECK_FALSE(replica.replica.synced());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("an owner whose map is an older state of the same is followed back") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  for (int i = 0; i < 2; ++i) owner.Answer();
  MapOwner ahead;
  ahead.epoch = owner.epoch;
  Begin(replica, ahead, 5);
  replica.Handle(owner.Answer());
  CHECK_FALSE(replica.replica.synced());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("an owner that lost its map while pages were under way is followed too") {
  MapOwner owner;
  TestReplica replica;
  for (int i = 0; i < 5; ++i) owner.Answer();
  for (int i = 0; i < 2; ++i) replica.replica.Handle(owner.Page(*replica.replica.NextRequest()));
  REQUIRE_FALSE(replica.replica.synced());
  REQUIRE_FALSE(replica.matches.empty());
  MapOwner anew;
  anew.Answer();
  replica.Ask(anew);
  replica.CheckSameAs(anew);
}

TEST_CASE("parts that together have more tiles than a map are dropped, and the owner is asked") {
  MapOwner owner;
  TestReplica replica;
  Begin(replica, owner);
  map_delta_t part = owner.Answer().front();
  part.num_parts = 4096;
  part.matches.clear();
  part.tiles.assign(4096, {0, 0, 5, {0, 0, 0, 1, 9}});
  for (part.part = 1; part.part <= 4; ++part.part) replica.replica.Handle(part);
  CHECK_FALSE(replica.replica.NextRequest());  // as many as a map may have
  part.tiles.resize(1);
  replica.replica.Handle(part);
  CHECK(replica.replica.NextRequest());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("of parts that were dropped because they had too many tiles, none is taken for the owner's") {
  MapOwner owner;
  TestReplica replica;
  replica.Ask(owner);
  const auto parts = owner.Answer();
  REQUIRE(parts.size() > 1);
  for (map_delta_t forged : {parts.front(), parts.back()}) {
    forged.matches.clear();
    forged.tiles.assign(forged.part == 0 ? kMostTiles : 1, {0, 0, 5, {0, 0, 0, 1, 9}});
    replica.replica.Handle(forged);
  }
  CHECK(replica.replica.NextRequest());
  replica.Handle(parts);  // the owner's own, sent again: the version without a page
  replica.CheckSameAs(owner);
}

TEST_CASE("a page with cells of another size than the map's is not the owner's, and changes nothing") {
  for (const bool synced : {true, false}) {
    MapOwner owner;
    TestReplica replica;
    Begin(replica, owner);
    owner.Answer();
    if (!synced) replica.replica.Doubt();
    map_delta_t page = owner.Page({kRequester, 2, owner.epoch, 3, 0, 3, -1, 0, 0, 0});
    page.cell_size_m = 0.05;
    if (!synced) page.request = {replica.replica.NextRequest().value()};
    replica.replica.Handle(page);
    CHECK(replica.replica.version() == 3);
    CHECK(replica.num_begins == 1);
    CHECK(replica.map.geometry().cell_size_m() == MapOwner::kCellSize_m);
  }
}

TEST_CASE("a page that was not asked for, of another epoch and with other cells, changes nothing") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  MapOwner other;
  for (int i = 0; i < 5; ++i) other.Answer();
  map_delta_t page = other.Page({kRequester, 1, other.epoch, 0, 0, 0, -1, 0, 0, 0});
  page.cell_size_m = 0.5;
  replica.replica.Handle(page);
  CHECK(replica.num_begins == 1);
  replica.CheckSameAs(owner);
}

TEST_CASE("a delta with cells of another size than the map's is not the owner's, and changes nothing") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  auto parts = owner.Answer();
  auto forged = parts;
  for (map_delta_t& part : forged) part.cell_size_m = 0.5;
  replica.Handle(forged);
  CHECK(replica.replica.version() == 3);
  replica.Handle(parts);
  replica.CheckSameAs(owner);
}

TEST_CASE("a next version that was not the owner's is found out by the owner's, and the map is fetched anew") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  map_delta_t forged = owner.AnswerAgain(999);
  forged.base_version = 3;
  forged.version = 4;
  forged.num_tiles = 1;
  forged.tiles = {{50, 50, 5, {0, 0, 0, 1, 0}}};
  forged.num_matches = 1;
  forged.matches = {ScanMatchMessage()};
  replica.replica.Handle(forged);
  REQUIRE(replica.replica.version() == 4);
  replica.Handle(owner.Answer());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a replica that doubts takes the next version, when it comes, without a page") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  replica.replica.Doubt();
  const auto next = owner.Answer();
  const auto after_next = owner.Answer();
  replica.Handle(next);
  CHECK(replica.replica.synced());
  replica.Handle(after_next);
  replica.CheckSameAs(owner);
}

TEST_CASE("versions in another order are taken as far as they lead on, and the owner is asked for the rest") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  const auto one = owner.Answer();
  const auto two = owner.Answer();
  replica.Handle(two);
  replica.Handle(one);
  CHECK(replica.replica.version() == 4);
  CHECK_FALSE(replica.replica.synced());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("the owner is asked about a scan until it has answered, and the answer is of that scan alone") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  for (const std::int64_t utime : {101, 5}) {  // one is in the map, the other is not
    CHECK_FALSE(replica.replica.AnswerAbout(utime));
    replica.replica.AskAbout(utime);
    for (int i = 0; i < 2; ++i) {
      const auto request = replica.replica.NextRequest();
      REQUIRE(request);
      CHECK(request->asked_utime == utime);
    }
    map_delta_t other = owner.Page(*replica.replica.NextRequest());
    other.request[0].asked_utime = utime + 1;
    replica.replica.Handle(other);
    CHECK_FALSE(replica.replica.AnswerAbout(utime));
    CHECK(replica.Ask(owner) == 1);
    REQUIRE(replica.replica.AnswerAbout(utime));
    CHECK(replica.replica.AnswerAbout(utime)->match.has_value() == (utime == 101));
  }
  CHECK_FALSE(replica.replica.AnswerAbout(101));
  replica.replica.AskAbout(5);
  CHECK_FALSE(replica.replica.NextRequest());  // it is answered already
  replica.replica.ForgetAnswer();
  replica.replica.AskAbout(5);
  CHECK(replica.replica.NextRequest());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a question is answered while pages are under way, too") {
  MapOwner owner;
  for (int i = 0; i < 3; ++i) owner.Answer();
  TestReplica replica(false);
  replica.replica.AskAbout(102);
  replica.replica.Handle(owner.Page(*replica.replica.NextRequest()));
  CHECK_FALSE(replica.replica.synced());
  REQUIRE(replica.replica.AnswerAbout(102));
  CHECK(replica.replica.AnswerAbout(102)->match == owner.history[2]);
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a last page whose tracking state is of another version is not taken") {
  MapOwner owner;
  TestReplica replica(false);
  Begin(replica, owner);
  owner.Answer();
  replica.replica.Doubt();
  map_delta_t page = owner.Page(*replica.replica.NextRequest());
  for (; page.next_tile >= 0; page = owner.Page(*replica.replica.NextRequest())) replica.replica.Handle(page);
  page.tracking.front().num_scans = 3;
  replica.replica.Handle(page);
  CHECK_FALSE(replica.replica.synced());
  page.tracking.clear();
  replica.replica.Handle(page);
  CHECK_FALSE(replica.replica.synced());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a version with the wrong number of matches makes the replica begin again") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  Begin(replica, owner);
  auto parts = owner.Answer();
  parts.front().matches.push_back(parts.front().matches.front());
  parts.front().num_matches = 2;
  replica.Handle(parts);
  CHECK_FALSE(replica.replica.synced());
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

}  // namespace crsm
