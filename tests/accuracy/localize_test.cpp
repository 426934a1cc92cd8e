#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "accuracy/run.hpp"
#include "catch.hpp"
#include "common/math/random.hpp"
#include "common/slam.hpp"
#include "real_logs.hpp"

namespace crsm {
namespace {

struct Building {
  std::string name;
  std::string source;
};

/// Scans, and where they were taken on the map of their own building.
using Visit = Recording;

/// Where the scans of one building were found on the finished map of another, or of the same.
struct Found {
  int scans = 0;
  int found = 0;
  int elsewhere = 0;  ///< of those found: more than 0.5 m or 0.3 rad from where they were taken
  int followed = 0;   ///< scans that came after one that was found
  int kept = 0;       ///< of those: found too
};

int FromEnvironment(const char* name, int usual) {
  const char* text = std::getenv(name);
  return text ? std::max(1, std::atoi(text)) : usual;
}

/// Maps a building; returns its scans too, with the poses that they got.
Visit MapBuilding(const Building& building, const Parameters& parameters, Slam& slam) {
  Visit visit = Record(building.source, parameters);
  visit.truth.clear();
  for (const LaserScan& scan : visit.scans) {
    visit.truth.push_back({scan.utime, slam.Process(scan).match.T_map_laser});
  }
  return visit;
}

bool IsSamePlace(const Pose2& a, const Pose2& b, double most_m = 0.5, double most_rad = 0.3) {
  return Distance(a, b) <= most_m && std::abs(WrapAngle(a.yaw_rad - b.yaw_rad)) <= most_rad;
}

/// Switches the robot on at some places of its way, and follows it from each for some scans.
Found Localize(Slam& slam, const Visit& visit) {
  const int num_starts = FromEnvironment("CRSM_LOCALIZE_STARTS", 2);
  const auto num_scans = static_cast<std::size_t>(FromEnvironment("CRSM_LOCALIZE_SCANS", 20));
  Found found;
  for (int start = 0; start < num_starts; ++start) {
    slam.FinishMap();
    bool was_found = false;
    const std::size_t first =
        visit.scans.size() * static_cast<std::size_t>(start) / static_cast<std::size_t>(num_starts);
    for (std::size_t i = first; i < std::min(first + num_scans, visit.scans.size()); ++i) {
      const ScanMatch match = slam.Process(visit.scans[i]).match;
      ++found.scans;
      if (was_found) ++found.followed;
      if (match.state == MatchState::kLost) continue;
      ++found.found;
      if (was_found) ++found.kept;
      was_found = true;
      if (!IsSamePlace(match.T_map_laser, visit.truth[i].T_map_laser)) ++found.elsewhere;
    }
  }
  return found;
}

/// All pairs of buildings, both ways: prints what was found, and checks that the right robot is found and others not.
void CheckAllPairs(const std::vector<Building>& buildings, const std::string& preset, double least_own,
                   double most_foreign) {
  const Parameters parameters = ShippedParameters(preset, 1);
  std::vector<std::unique_ptr<Slam>> maps;
  std::vector<Visit> visits;
  for (const Building& building : buildings) {
    maps.push_back(std::make_unique<Slam>(parameters));
    visits.push_back(MapBuilding(building, parameters, *maps.back()));
    if (building.source.rfind("sim:", 0) == 0) visits.back() = Record(building.source, ShippedParameters(preset, 2));
  }
  Found foreign;
  for (std::size_t map = 0; map < buildings.size(); ++map) {
    for (std::size_t robot = 0; robot < buildings.size(); ++robot) {
      const Found found = Localize(*maps[map], visits[robot]);
      const std::string pair = fmt::format("robot in {} on the map of {}", buildings[robot].name, buildings[map].name);
      const int elsewhere = map == robot ? found.elsewhere : found.found;
      fmt::print("{:<42} scans {:>4}  found {:>4}  wrongly {:>4}\n", pair, found.scans, found.found, elsewhere);
      std::fflush(stdout);
      INFO(pair);
      if (map == robot) {
        CHECK(found.found >= least_own * found.scans);  // where rooms are alike, the first scans are lost
        CHECK(found.kept >= 0.85 * found.followed);     // once it is found, it is not refused
        CHECK(found.elsewhere == 0);
      } else {
        foreign.scans += found.scans;
        foreign.found += found.found;
      }
    }
  }
  fmt::print("in other buildings: {} of {} scans found\n", foreign.found, foreign.scans);
  CHECK(foreign.found <= most_foreign * foreign.scans);
}

}  // namespace

TEST_CASE("a robot is found on the map of its own building and of no other: simulated ones in pairs") {
  CheckAllPairs({{"demo", "sim:demo"}, {"env1", "sim:env1"}, {"hall", "sim:hall"}}, "", 0.7, 0.0);
}

TEST_CASE("a robot is found on the map of its own building and of no other: real ones in pairs", "[logs]") {
  std::vector<Building> buildings;
  for (const char* name : {"fr079", "intel", "aces"}) {
    if (const auto log = FindRealLog(fmt::format("radish/{}.clf.gz", name))) buildings.push_back({name, *log});
  }
  // Half of the places in aces are like others. A corridor of aces is like one of fr079 for some metres, as far as a
  // laser sees.
  if (buildings.size() > 1) CheckAllPairs(buildings, "sick", 0.0, 0.05);
}

TEST_CASE("a robot is followed on the map that its own scans have made", "[logs]") {
  const auto log = FindRealLog("radish/intel.clf.gz");
  if (!log) return;
  constexpr std::size_t kMapped = 7000;
  constexpr std::size_t kFirst = 4000;
  constexpr std::size_t kFollowed = 1000;  // people stand in the way of some
  const std::vector<LaserScan> scans = Record(*log, ShippedParameters("sick", 1)).scans;
  Slam slam(ShippedParameters("sick", 1));
  for (std::size_t i = 0; i < kMapped; ++i) slam.Process(scans[i]);
  slam.AwaitLoops();
  slam.FinishMap();
  std::size_t num_found = 0;
  for (std::size_t i = 0; i < kFollowed; ++i) {
    num_found += slam.Process(scans[kFirst + i]).match.state != MatchState::kLost;
  }
  CHECK(num_found >= kFollowed - 10);
}

namespace {

/// What became of scans that were localised on a finished map.
struct Localized {
  std::vector<ScanMatch> matches;
  double longest_ms = 0.0;  ///< of a scan
};

Localized LocalizeAll(Slam& slam, std::span<const LaserScan> scans, Localized localized = {}) {
  for (const LaserScan& scan : scans) {
    const auto begin = std::chrono::steady_clock::now();
    localized.matches.push_back(slam.Process(scan).match);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    localized.longest_ms = std::max(localized.longest_ms, took.count());
  }
  return localized;
}

/// A robot is switched on at places of a visit: the first scan that is not lost is the answer, and has to be right.
/// Places are drawn, of those that are given.
void CheckSwitchedOn(const std::string& name, Slam& slam, const Visit& visit, const std::vector<std::size_t>& places,
                     int num_starts) {
  Random random(1);
  int num_right = 0;
  std::vector<double> waits, times_ms;
  for (int i = 0; i < num_starts; ++i) {
    const std::size_t start = places[random.Next() % places.size()];
    slam.FinishMap();
    const auto [matches, longest_ms] = LocalizeAll(slam, std::span(visit.scans).subspan(start, 200));
    times_ms.push_back(longest_ms);
    const auto found = std::find_if(matches.begin(), matches.end(),
                                    [](const ScanMatch& match) { return match.state != MatchState::kLost; });
    if (found == matches.end()) continue;
    const auto after = static_cast<std::size_t>(found - matches.begin());
    waits.push_back(static_cast<double>(after) + 1.0);
    num_right += IsSamePlace(found->T_map_laser, visit.truth[start + after].T_map_laser, 0.3, 0.175);
  }
  const auto num_found = static_cast<int>(waits.size());
  fmt::print(
      "{}: {} of {} right, {} wrong, {} not found within 200 scans; found after {} scans (median), {} at most; the "
      "search takes {:.0f} ms (median), {:.0f} ms at most\n",
      name, num_right, num_starts, num_found - num_right, num_starts - num_found, Median(waits),
      *std::max_element(waits.begin(), waits.end()), Median(times_ms),
      *std::max_element(times_ms.begin(), times_ms.end()));
  CHECK(30 * num_right >= 28 * num_starts);
}

/// A robot that knows where it is, and the next moment is elsewhere: at the end of 200 scans it knows that.
void CheckCarried(const std::string& name, Slam& slam, const Visit& visit, int num_times) {
  Random random(1);
  int num_right = 0;
  std::vector<double> lost;
  for (int i = 0; i < num_times; ++i) {
    const auto Place = [&] { return static_cast<std::size_t>(random.Next() % (visit.scans.size() - 200)); };
    const std::size_t before = Place();
    const std::size_t after = Place();
    slam.FinishMap();
    const auto scans = std::span(visit.scans);
    const Localized localized =
        LocalizeAll(slam, scans.subspan(after, 200), LocalizeAll(slam, scans.subspan(before, 50)));
    num_right += IsSamePlace(localized.matches.back().T_map_laser, visit.truth[after + 199].T_map_laser, 0.3, 0.175);
    lost.push_back(
        static_cast<double>(std::count_if(localized.matches.begin() + 50, localized.matches.end(),
                                          [](const ScanMatch& match) { return match.state == MatchState::kLost; })));
  }
  fmt::print("{}: carried away {} times, found again {} times, after {} lost scans (median), {} at most\n", name,
             num_times, num_right, Median(lost), *std::max_element(lost.begin(), lost.end()));
  CHECK(10 * num_right >= 8 * num_times);
}

std::vector<std::size_t> PlacesUpTo(std::size_t first, std::size_t end) {
  std::vector<std::size_t> places;
  for (std::size_t i = first; i < end; ++i) places.push_back(i);
  return places;
}

}  // namespace

TEST_CASE("localize", "[.][fault][localize]") {
  const char* effort = std::getenv("CRSM_FAULT_EFFORT");
  const bool quick = effort && effort == std::string("quick");
  {
    // A simulated building on another day: other noise.
    const Parameters parameters = ShippedParameters("", 1);
    Slam slam(parameters);
    MapBuilding({"demo", "sim:demo"}, parameters, slam);
    slam.AwaitLoops();
    const Visit visit = Record("sim:demo", ShippedParameters("", 2));
    CheckSwitchedOn("sim:demo", slam, visit, PlacesUpTo(0, visit.scans.size() - 200), quick ? 10 : 30);
    const std::vector<std::uint8_t> cells = slam.map().ToDenseGrid().cells;
    CheckCarried("sim:demo", slam, visit, quick ? 3 : 10);
    CHECK((slam.map().ToDenseGrid().cells == cells));
  }
  // A real one: the map is made of the first 60 % of the log, and the robot is switched on in the rest, where it has
  // been before. The poses of the whole log, mapped in one run, tell where that is.
  const auto log = FindRealLog("radish/intel.clf.gz");
  if (!log) return;
  const Parameters parameters = ShippedParameters("sick", 1);
  Visit visit = Record(*log, parameters);
  for (const ScanMatch& match : Map(visit, parameters).matches) visit.truth.push_back({match.utime, match.T_map_laser});
  const std::size_t end = visit.scans.size() * 6 / 10;
  Slam slam(parameters);
  for (std::size_t i = 0; i < end; ++i) slam.Process(visit.scans[i]);
  slam.AwaitLoops();
  std::vector<std::size_t> places = PlacesUpTo(end, visit.scans.size() - 200);
  std::erase_if(places, [&](std::size_t place) {
    for (std::size_t i = 0; i < end; i += 10) {
      if (IsSamePlace(visit.truth[i].T_map_laser, visit.truth[place].T_map_laser, 0.5, 0.5)) return false;
    }
    return true;
  });
  CheckSwitchedOn("intel", slam, visit, places, quick ? 10 : 30);
}

}  // namespace crsm
