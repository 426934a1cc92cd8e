// How well a place with a name is known that was seen again and again on the way.

#include <fmt/core.h>

#include <algorithm>

#include "accuracy/run.hpp"
#include "catch.hpp"
#include "common/marks/mark_book.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

/// How far the place of a victim is off that was seen twenty times, from five places of a drive.
struct Off {
  double on_map_m;  ///< from where the map has the walls around it, by the scan in the middle
  double truth_m;   ///< from the truth, as seen from the first scan: with the drift of the map up to there
};

Off SeeVictim(std::uint64_t seed) {
  const Parameters parameters = ShippedParameters("urg-04lx", seed);
  const Recording recording = Record("sim:corridor", parameters);
  Slam slam(parameters);
  std::vector<ScanMatch> matches;
  for (const LaserScan& scan : recording.scans) matches.push_back(slam.Process(scan).match);
  slam.AwaitLoops();
  // Half of the way on, two metres ahead and half a metre aside: seen as the robot comes nearer.
  const std::size_t num = recording.scans.size();
  const Pose2 T_map_victim = recording.truth[num / 2].T_map_laser * Pose2{2.0, 0.5, 0.0};
  Random random(seed);
  MarkBook book;
  for (int place = 0; place < 5; ++place) {
    for (int sighting = 0; sighting < 4; ++sighting) {
      const std::size_t scan = num / 2 + static_cast<std::size_t>(8 * place + sighting);
      const Pose2 T_laser_victim = Inverse(recording.truth[scan].T_map_laser) * T_map_victim;
      const Mark mark{recording.scans[scan].utime,
                      "v",
                      "victim",
                      "",
                      MarkAction::kSeen,
                      false,
                      0.15,
                      {{T_laser_victim.x_m + 0.15 * random.Gaussian(), T_laser_victim.y_m + 0.15 * random.Gaussian()}}};
      const auto fixed = FixByLaser(mark, ScanAt{static_cast<std::int64_t>(scan), matches[scan]}, {}, slam.mapper());
      REQUIRE(fixed);
      REQUIRE(book.Add(*fixed, slam.mapper()));
    }
  }
  const std::vector<PlacedMark> marks = book.Place(slam.mapper());
  REQUIRE(marks.size() == 1);
  CHECK(marks[0].num_sightings == 20);
  const Point& at = marks[0].points[0];
  const std::size_t middle = num / 2 + 18;
  const Pose2 T_map_middle = slam.BestPose(static_cast<std::int64_t>(middle), matches[middle].T_map_laser);
  const Pose2 on_map = T_map_middle * (Inverse(recording.truth[middle].T_map_laser) * T_map_victim);
  return {Distance(on_map, {at.x_m, at.y_m, 0.0}), Distance(T_map_victim, {at.x_m, at.y_m, 0.0})};
}

}  // namespace

TEST_CASE("a victim that is seen twenty times from five places of a corridor is one place, and near the truth") {
  constexpr int kSeeds = 20;
  constexpr double kOnMap_m = 0.1;  // three standard deviations of a mean of 20, each of 0.15 m along both axes
  constexpr double kDrift_m = 0.1;  // of the map, in half of the corridor
  std::vector<double> on_map_m;
  std::vector<double> truth_m;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Off off = SeeVictim(seed);
    on_map_m.push_back(off.on_map_m);
    truth_m.push_back(off.truth_m);
  }
  const double worst_on_map_m = *std::ranges::max_element(on_map_m);
  const double worst_truth_m = *std::ranges::max_element(truth_m);
  fmt::print(
      "a victim seen 20 times, {} seeds: on the map median {:.3f} m, worst {:.3f} m; from the truth {:.3f}, {:.3f}\n",
      kSeeds, Median(on_map_m), worst_on_map_m, Median(truth_m), worst_truth_m);
  CHECK(worst_on_map_m < kOnMap_m);
  CHECK(worst_truth_m < kOnMap_m + kDrift_m);
}

}  // namespace crsm
