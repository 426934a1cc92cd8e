#include "services/replica/delta_reader.hpp"

#include <algorithm>

#include "test_replica.hpp"

namespace crsm {
namespace {

using Parts = std::vector<map_delta_t>;

/// A matcher's replica, and what it knows of its matches.
class MatchedReplica : public TestReplica {
 public:
  MatchedReplica() : TestReplica(false) {}

  /// The owner answers a match of this matcher.
  Parts Match(MapOwner& owner, MatchState state = MatchState::kOk, const AfterMatch& after = {}) {
    Parts parts = owner.Answer(state, after);
    deltas.Await(owner.history.back());
    return parts;
  }

  void Take(const Parts& parts) {
    for (const map_delta_t& part : parts) {
      REQUIRE(Decode<map_delta_t>(Encode(part)));
      deltas.Handle(part);
    }
  }

  /// What came was not enough, or not the owner's, and the owner's pages mend it.
  void CheckAsks(const MapOwner& owner) {
    CHECK_FALSE(replica.synced());
    Ask(owner);
    CheckSameAs(owner);
  }

  DeltaReader deltas{replica};
};

}  // namespace

TEST_CASE("a replica from the start follows the owner delta by delta, also where several matches wait or it doubts") {
  MapOwner owner;
  MatchedReplica replica;
  CHECK(replica.Ask(owner) == 1);
  for (int i = 0; i < 10; ++i) {
    if (i % 3 == 1) replica.replica.RequestUpdate();
    std::vector<Parts> answers;
    for (int k = 0; k <= i % 3; ++k)
      answers.push_back(replica.Match(owner, k == 1 ? MatchState::kLost : MatchState::kOk));
    for (const Parts& parts : answers) replica.Take(parts);
    replica.CheckSameAs(owner);
    CHECK_FALSE(replica.replica.NextRequest());
  }
}

TEST_CASE("a version that was lost, overtaken or of another's match, as before a restart, is noticed and asked for") {
  MapOwner owner;
  MatchedReplica replica;
  replica.Begin(owner);
  std::int64_t version = 3;
  SECTION("lost") {
    replica.Match(owner);
    replica.Take(replica.Match(owner));
  }
  SECTION("overtaken") {
    const Parts one = replica.Match(owner);
    replica.Take(replica.Match(owner));
    replica.Take(one);
    version = 4;
  }
  SECTION("of another's match") { replica.Take(owner.Answer()); }
  CHECK(replica.replica.version() == version);
  replica.CheckAsks(owner);
  replica.Take(replica.Match(owner));
  replica.CheckSameAs(owner);
}

TEST_CASE("a replica whose map is corrected moves what is remembered of the scans, that of this answer too") {
  const Pose2 T_new_old{0.5, -0.25, 0.1};
  MapOwner owner;
  MatchedReplica replica;
  if (GENERATE(true, false)) replica.Begin(owner);  // or the first scan, whose answer has several parts
  if (owner.version() == 0) replica.Ask(owner);
  Parts parts = replica.Match(owner, MatchState::kOk, {T_new_old, 2, true});
  if (owner.version() == 1) REQUIRE(parts.size() > 1);
  std::reverse(parts.begin(), parts.end());
  replica.Take(parts);
  replica.CheckSameAs(owner);
  const TrackingState& tracking = replica.replica.tracking();
  CHECK(tracking.recent().back().T_map_laser == T_new_old * owner.history.back().T_map_laser);
  CHECK(tracking.T_local_map() == Inverse(T_new_old));
  CHECK(tracking.trajectory() == 2);
  CHECK(tracking.floating());

  replica.Take(replica.Match(owner));  // which is not moved
  replica.CheckSameAs(owner);
  replica.Take(replica.Match(owner, MatchState::kLost, {T_new_old}));
  replica.CheckSameAs(owner);
}

TEST_CASE("deltas that overtake the pages under way leave a whole map in the end") {
  MapOwner owner;
  for (int i = 0; i < 5; ++i) owner.Answer();
  MatchedReplica replica;
  int num_pages = 0;
  for (; const auto request = replica.replica.NextRequest(); ++num_pages) {
    REQUIRE(num_pages < 1000);
    const map_page_t page = owner.Page(*request);
    if (num_pages < 20) replica.Take(replica.Match(owner));  // overtakes the page
    replica.replica.Handle(page);
  }
  replica.CheckSameAs(owner);
}

TEST_CASE("any lost part keeps the version out; the parts sent again, or pages, complete it") {
  MapOwner reference;
  const std::size_t num_parts = reference.Answer().size();
  REQUIRE(num_parts > 1);
  for (std::size_t lost = 0; lost < num_parts; ++lost) {
    MapOwner owner;
    MatchedReplica replica;
    replica.Ask(owner);
    Parts parts = replica.Match(owner);
    Parts others = parts;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(lost));
    replica.Take(others);
    CHECK(replica.replica.version() == 0);
    CHECK(replica.map.tiles().entries().empty());
    if (lost % 3 == 0) {
      replica.Take(parts);
      CHECK(replica.replica.synced());
    } else {
      lost % 3 == 1 ? replica.replica.RequestUpdate() : replica.Take(replica.Match(owner));
      CHECK_FALSE(replica.replica.synced());
      replica.Ask(owner);
    }
    replica.CheckSameAs(owner);
  }
}

TEST_CASE("parts in any order make the same version, and change nothing when they come again") {
  MapOwner owner;
  MatchedReplica replica;
  replica.Ask(owner);
  Parts parts = replica.Match(owner);
  std::reverse(parts.begin(), parts.end());
  replica.Take(parts);
  replica.CheckSameAs(owner);
  replica.Take(parts);  // the last answer, sent again
  replica.CheckSameAs(owner);
}

TEST_CASE("an owner that began anew is asked, whatever version it has, and nothing is thrown away before") {
  for (const int num_scans : {1, 3, 4, 5, 8}) {  // behind, level, the very next version, far ahead
    MapOwner owner;
    MatchedReplica replica;
    replica.Begin(owner, 4);
    MapOwner anew;
    for (int i = 1; i < num_scans; ++i) anew.Answer(MatchState::kLost);
    replica.Take(replica.Match(anew));
    CHECK(replica.num_begins == 1);
    replica.CheckAsks(anew);
    CHECK(replica.num_begins == 2);
    replica.Take(replica.Match(anew));
    replica.CheckSameAs(anew);
  }
}

TEST_CASE("a delta of an older state of the same map is followed back") {
  MapOwner owner;
  MatchedReplica replica;
  for (int i = 0; i < 2; ++i) owner.Answer();
  MapOwner ahead;
  ahead.epoch = owner.epoch;
  replica.Begin(ahead, 5);
  replica.Take(replica.Match(owner));
  replica.CheckAsks(owner);
}

TEST_CASE(
    "a delta of a map that nobody owns makes the replica ask, one with other cells does not; neither changes it") {
  MapOwner owner;
  MatchedReplica replica;
  replica.Begin(owner);
  for (const std::int64_t version : {1, 3, 4, 1000}) {
    replica.Take({map_delta_t{
        .utime = 5, .epoch = owner.epoch + 1000, .version = version, .cell_size_m = 0.05, .num_parts = 1}});
    replica.CheckAsks(owner);
    CHECK(replica.num_begins == 1);
  }
  const Parts parts = replica.Match(owner);
  Parts forged = parts;
  for (map_delta_t& part : forged) part.cell_size_m = 0.5;
  replica.Take(forged);
  CHECK(replica.replica.version() == 3);
  replica.Take(parts);
  replica.CheckSameAs(owner);
}

TEST_CASE("parts that together have more tiles than a map are dropped, and the owner is asked") {
  MapOwner owner;
  MatchedReplica replica;
  replica.Ask(owner);
  const Parts parts = replica.Match(owner);
  REQUIRE(parts.size() > 5);
  map_delta_t forged = parts.back();
  forged.num_tiles = 4096;
  forged.tiles.assign(4096, {0, 0, 5, {0, 0, 0, 1, 9}});
  for (forged.part = 1; forged.part <= 4; ++forged.part) replica.Take({forged});
  CHECK_FALSE(replica.replica.NextRequest());  // as many as a map may have
  replica.Take({parts[0]});
  CHECK(replica.replica.NextRequest());
  replica.Take(parts);  // the owner's own, sent again: the version without a page, and no part of the others
  replica.CheckSameAs(owner);
}

TEST_CASE("a next version that was not the owner's is found out by the owner's, and the map is fetched anew") {
  MapOwner owner;
  MatchedReplica replica;
  replica.Begin(owner);
  replica.deltas.Await(MatchedAt(999, {}));  // which the owner did not hear
  replica.Take({map_delta_t{.utime = 999,
                            .epoch = owner.epoch,
                            .version = 4,
                            .cell_size_m = MapOwner::kCellSize_m,
                            .num_parts = 1,
                            .num_tiles = 1,
                            .tiles = {{50, 50, 5, {0, 0, 0, 1, 0}}}}});
  REQUIRE(replica.replica.version() == 4);
  replica.Take(replica.Match(owner));
  replica.CheckAsks(owner);
}

}  // namespace crsm
