#include "services/replica/map_replica.hpp"

#include <limits>

#include "test_replica.hpp"

namespace crsm {

TEST_CASE("a new replica asks for everything, and again until it is answered") {
  TestReplica replica;
  CHECK_FALSE(replica.replica.synced());
  CHECK(replica.num_begins == 0);
  for (int i = 0; i < 2; ++i) {
    const auto request = replica.replica.NextRequest();
    REQUIRE(request);
    CHECK(Encode(*request) == Encode(map_request_t{.requester = TestReplica::kRequester, .question = 1, .whole = 1}));
  }
}

TEST_CASE("a replica has the loops of the last page of matches, until it is told others or begins anew") {
  MapOwner owner;
  TestReplica replica;
  replica.Begin(owner);
  const map_loop_t loop{{1.0, 2.0, 0.5}, {1.5, 2.0, -0.5}, 1, 0};
  const auto Tell = [&](const std::vector<map_loop_t>& loops, bool last) {
    owner.Answer(MatchState::kLost);  // changes nothing: its page is the only one
    owner.loops = loops;
    replica.replica.RequestUpdate();
    map_page_t page = owner.Page(replica.replica.NextRequest().value());
    if (!last) {
      page.next_match -= 1;
      page.num_matches = 0;
      page.matches.clear();
    }
    replica.replica.Handle(page);
    return replica.replica.loops();
  };
  CHECK(Tell({loop}, false).empty());  // there is more to come
  CHECK(Tell({loop, {}}, true) == std::vector<PlacedLoop>{FromMessage(loop), {}});
  CHECK(Tell({loop}, true) == std::vector<PlacedLoop>{FromMessage(loop)});
  replica.CheckSameAs(owner);
  MapOwner another;
  replica.replica.RequestUpdate();
  replica.Ask(another);
  CHECK(replica.replica.loops().empty());
}

TEST_CASE("a replica has the marks of the owner, also those that come, move and go while the map stays as it is") {
  MapOwner owner;
  TestReplica replica;
  replica.Begin(owner);
  placed_mark_t mark = PlacedMarkMessage();
  for (const auto& marks : {std::vector{mark}, {mark, mark}, {mark}, {}}) {
    owner.marks = marks;
    replica.replica.RequestUpdate();
    replica.Ask(owner);
    CHECK(replica.replica.marks().size() == marks.size());
    if (!marks.empty()) CHECK(replica.replica.marks().back() == FromMessage(mark));
  }
  replica.CheckSameAs(owner);
  owner.marks = {mark};
  replica.replica.RequestUpdate();
  replica.Ask(owner);
  MapOwner another;
  replica.replica.RequestUpdate();
  replica.Ask(another);
  CHECK(replica.replica.marks().empty());
}

TEST_CASE(
    "a late joiner gets the map page by page, whole in the end though it changes meanwhile, and then what is new") {
  MapOwner owner;
  for (int i = 0; i < 605; ++i) owner.Answer(i < 5 ? MatchState::kOk : MatchState::kLost);
  TestReplica replica(GENERATE(true, false));
  int num_pages = 0;
  for (; const auto request = replica.replica.NextRequest(); ++num_pages) {
    REQUIRE(num_pages < 1000);
    const map_page_t page = owner.Page(*request);
    if (num_pages < 20) owner.Answer();  // overtakes the page
    replica.replica.Handle(page);
  }
  REQUIRE(num_pages > 20);
  replica.CheckSameAs(owner);
  owner.Answer();
  replica.replica.RequestUpdate();
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a question keeps its number until it is answered; a page that comes late or again does no harm") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  for (int i = 0; i < 5; ++i) owner.Answer();
  std::vector<map_page_t> pages;
  while (const auto request = replica.replica.NextRequest()) {
    REQUIRE(request->question == std::ssize(pages) + 1);
    CHECK(replica.replica.NextRequest()->question == request->question);
    pages.push_back(owner.Page(*request));
    replica.replica.Handle(pages.front());
    for (int time = 0; time < 2; ++time) replica.replica.Handle(pages.back());
  }
  CHECK(pages.size() > 1);
  replica.CheckSameAs(owner);
  for (const map_page_t& page : pages) replica.replica.Handle(page);
  replica.CheckSameAs(owner);
  CHECK(replica.replica.num_forged() == 0);
}

TEST_CASE(
    "an owner that lost its map is followed from the start of the new one, and a late page of the old does no harm") {
  const bool wants_matches = GENERATE(true, false);
  for (const int num_scans : {3, 4, 5, 8}) {  // behind, level, the very next version, far ahead
    MapOwner owner;
    TestReplica replica(wants_matches);
    const map_request_t first = *replica.replica.NextRequest();
    replica.Begin(owner, 4);
    MapOwner anew;
    for (int i = 0; i < num_scans; ++i) anew.Answer();
    replica.replica.RequestUpdate();
    replica.Ask(anew);
    CHECK(replica.num_begins == 2);
    CHECK(replica.replica.epoch() == anew.epoch);
    replica.replica.Handle(owner.Page(first));
    replica.CheckSameAs(anew);
  }
  MapOwner owner;
  TestReplica replica(wants_matches);
  for (int i = 0; i < 5; ++i) owner.Answer();
  for (int i = 0; i < 2; ++i) replica.replica.Handle(owner.Page(*replica.replica.NextRequest()));
  REQUIRE_FALSE(replica.replica.synced());  // pages are under way
  MapOwner anew;
  anew.Answer();
  replica.Ask(anew);
  replica.CheckSameAs(anew);
}

TEST_CASE("an owner whose map is an older state of the same is followed back") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  for (int i = 0; i < 2; ++i) owner.Answer();
  MapOwner ahead;
  ahead.epoch = owner.epoch;
  replica.Begin(ahead, 5);
  replica.replica.RequestUpdate();
  replica.Ask(owner);
  replica.CheckSameAs(owner);
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
      [](auto& request) { request.whole = 1 - request.whole; },
      [](auto& request) { request.settled = 1; },
      [](auto& request) { request.piece = 2; },
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

TEST_CASE("what was answered before the loops were looked for is not taken as settled") {
  MapOwner owner;
  TestReplica replica;
  replica.Begin(owner);
  replica.replica.RequestUpdate();
  const map_page_t unsettled = owner.Page(replica.replica.NextRequest().value());
  replica.replica.AwaitSettled();
  replica.replica.Handle(unsettled);
  CHECK_FALSE(replica.replica.synced());
  CHECK(replica.replica.NextRequest()->settled == 1);
  replica.Ask(owner);
  replica.CheckSameAs(owner);
  CHECK(replica.replica.num_forged() == 0);
}

TEST_CASE("who does not wait any longer until loops are looked for asks anew") {
  MapOwner owner;
  TestReplica replica;
  replica.Begin(owner);
  replica.replica.AwaitSettled();
  const map_request_t settled = replica.replica.NextRequest().value();
  CHECK(settled.settled == 1);
  replica.replica.AwaitNoLonger();
  CHECK(replica.replica.NextRequest()->settled == 0);
  CHECK(replica.replica.NextRequest()->question > settled.question);
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("what was answered before an update was requested is no answer to that request") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  replica.Begin(owner);
  replica.replica.RequestUpdate();
  const map_request_t before = replica.replica.NextRequest().value();
  const map_page_t old_page = owner.Page(before);
  replica.replica.Handle(old_page);
  REQUIRE(replica.replica.synced());
  owner.Answer();
  replica.replica.RequestUpdate();
  for (int time = 0; time < 2; ++time) {  // before it is asked, and after
    replica.replica.Handle(old_page);
    CHECK_FALSE(replica.replica.synced());
    CHECK(replica.replica.NextRequest()->question == before.question + 1);
  }
  replica.Ask(owner);
  replica.CheckSameAs(owner);
  CHECK(replica.replica.num_forged() == 0);
}

TEST_CASE("a page with cells of another size, or of another number of scans or matches, is not the owner's") {
  const bool wants_matches = GENERATE(true, false);
  using Spoil = void (*)(map_page_t&);
  std::vector<Spoil> spoils{[](map_page_t& page) { page.cell_size_m = 0.05; }};
  if (wants_matches) {
    spoils.push_back([](map_page_t& page) { page.num_matches = 2, page.matches.push_back(page.matches.front()); });
  } else {
    spoils.push_back([](map_page_t& page) { page.tracking.front().num_scans = 3; });
    spoils.push_back([](map_page_t& page) { page.tracking.clear(); });
  }
  MapOwner owner;
  TestReplica replica(wants_matches);
  replica.Begin(owner);
  owner.Answer(MatchState::kLost);  // changes nothing: its page is the only one
  replica.replica.RequestUpdate();
  for (const Spoil spoil : spoils) {
    map_page_t page = owner.Page(replica.replica.NextRequest().value());
    spoil(page);
    replica.replica.Handle(page);
    CHECK_FALSE(replica.replica.synced());
    CHECK(replica.num_begins == 1);
  }
  replica.Ask(owner);
  replica.CheckSameAs(owner);
}

TEST_CASE("a page that was not asked for, or that another asked for, changes nothing") {
  MapOwner owner;
  TestReplica replica(GENERATE(true, false));
  map_request_t request = *replica.replica.NextRequest();
  replica.Begin(owner);
  MapOwner other;
  for (int i = 0; i < 5; ++i) other.Answer();
  replica.replica.Handle(other.Page(request));
  ++request.requester;
  replica.replica.Handle(owner.Page(request));
  CHECK(replica.num_begins == 1);
  CHECK(replica.replica.num_forged() == 0);
  replica.CheckSameAs(owner);
}

}  // namespace crsm
