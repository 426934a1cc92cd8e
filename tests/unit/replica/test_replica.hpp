#pragma once

#include <vector>

#include "catch.hpp"
#include "map_owner.hpp"
#include "services/replica/map_replica.hpp"
#include "wire_messages.hpp"

namespace crsm {

/// A replica and the map that it keeps, with all matches or with the tracking state that follows from them.
class TestReplica {
 public:
  explicit TestReplica(bool wants_matches = true) : wants_matches_(wants_matches) {}

  /// Asks the owner until nothing is left to ask; how many pages that took.
  int Ask(const MapOwner& owner) {
    int num_pages = 0;
    for (; const auto request = replica.NextRequest(); ++num_pages) {
      REQUIRE(num_pages < 1000);
      const auto page = Decode<map_page_t>(Encode(owner.Page(*request)));
      REQUIRE(page);
      replica.Handle(*page);
    }
    return num_pages;
  }

  void CheckSameAs(const MapOwner& owner) const {
    CHECK(replica.synced());
    CHECK(replica.version() == owner.version());
    CHECK(replica.tracking() == owner.tracking);
    if (wants_matches_) CHECK(matches == owner.history);
    CHECK(map.geometry().cell_size_m() == MapOwner::kCellSize_m);
    CHECK(map.ToDenseGrid().cells == owner.map.ToDenseGrid().cells);
  }

  /// In step with an owner that has drawn a few scans.
  void Begin(MapOwner& owner, int num_scans = 3) {
    for (int i = 0; i < num_scans; ++i) owner.Answer();
    Ask(owner);
    CheckSameAs(owner);
  }

 private:
  bool wants_matches_;

 public:
  static constexpr std::int64_t kRequester = 77;
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
                                     : std::function<void(const ScanMatch&)>()},
                     wants_matches_ ? MapReplica::View::kWhole : MapReplica::View::kMatched};
};

}  // namespace crsm
