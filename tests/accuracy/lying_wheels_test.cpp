// Wheels that lie: with their odometry the map is as good as without any.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <map>

#include "accuracy/gate.hpp"
#include "accuracy/run.hpp"
#include "catch.hpp"
#include "common/math/random.hpp"
#include "common/math/trigonometry.hpp"
#include "common/worlds/simulator.hpp"
#include "real_logs.hpp"

namespace crsm {
namespace {

/// From one scan to the next, by the wheels.
using Motions = std::vector<Pose2>;

constexpr std::size_t kPeriod = 300;  ///< scans between two jumps

void ShortenWays(Motions& motions, double share) {
  for (Pose2& motion : motions) motion.x_m *= share, motion.y_m *= share;
}

/// Where the robot drives backwards the sign of the way is wrong; if it hardly does, on a tenth of the path.
void ReverseWays(Motions& motions) {
  constexpr double kLeastBackwards_m = 1.0;  // less is the noise of the wheels
  constexpr double kStretch_m = 2.0;
  double backwards_m = 0.0;
  for (const Pose2& motion : motions) backwards_m += std::max(0.0, -motion.x_m);
  double driven_m = 0.0;
  for (Pose2& motion : motions) {
    const bool is_wrong =
        backwards_m >= kLeastBackwards_m ? motion.x_m < 0.0 : static_cast<int>(driven_m / kStretch_m) % 10 == 5;
    driven_m += Length(motion);
    if (is_wrong) motion = {-motion.x_m, -motion.y_m, motion.yaw_rad};
  }
}

void StandStillFromHalf(Motions& motions) {
  std::fill(motions.begin() + std::ssize(motions) / 2, motions.end(), Pose2{});
}

void Jump(Motions& motions, const Pose2& by) {
  for (std::size_t i = kPeriod - 1; i < motions.size(); i += kPeriod) {
    motions[i] = {motions[i].x_m + by.x_m, motions[i].y_m, motions[i].yaw_rad + by.yaw_rad};
  }
}

/// 0.3 m per root metre and 0.5 rad per root radian: ten times the noise of good wheels.
void Shake(Motions& motions) {
  Random random(1);
  for (Pose2& motion : motions) {
    const double way_m = Length(motion);
    const double share = way_m > 0.0 ? 1.0 + 0.3 * random.Gaussian() / std::sqrt(way_m) : 0.0;
    motion = {share * motion.x_m, share * motion.y_m,
              motion.yaw_rad + 0.5 * random.Gaussian() * std::sqrt(std::abs(motion.yaw_rad))};
  }
}

const std::map<std::string, std::function<void(Motions&)>> kLies{
    {"honest", [](Motions&) {}},
    {"ways 5 % too short", [](Motions& motions) { ShortenWays(motions, 0.95); }},
    {"ways 20 % too short", [](Motions& motions) { ShortenWays(motions, 0.8); }},
    {"backwards is forwards", ReverseWays},
    {"they stand still from the middle on", StandStillFromHalf},
    {"5 m at once, now and then",
     [](Motions& motions) {
       Jump(motions, {5.0, 0.0, 0.0});
     }},
    {"90 degrees at once, now and then",
     [](Motions& motions) {
       Jump(motions, {0.0, 0.0, 0.5 * kPi});
     }},
    {"noise", Shake},
};

Recording Lie(Recording recording, const std::function<void(Motions&)>& lie) {
  Motions motions;
  for (std::size_t i = 1; i < recording.odometry.size(); ++i) {
    motions.push_back(Inverse(recording.odometry[i - 1].value()) * recording.odometry[i].value());
  }
  lie(motions);
  recording.uses_odometry = true;
  Pose2 told = recording.odometry.front().value();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    told = told * motions[i];
    recording.odometry[i + 1] = RoundOdometry(told);
  }
  return recording;
}

/// Maps a drive with every kind of wheels, and with none. Of some seeds the median counts: one drive of aces in sixteen
/// breaks without any wheels, which is no lie's doing.
void CheckNoLieMatters(const Drive& drive, int num_seeds, const std::function<Recording(std::uint64_t)>& record) {
  constexpr double kWorseShare = 1.1, kWorse_m = 0.002;
  std::map<std::string, std::vector<double>> errors_m;
  for (int i = 1; i <= num_seeds; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    const Recording recording = record(seed);
    const auto Add = [&](const std::string& name, const Recording& told) {
      const Outcome outcome = Map(drive, told, ShippedParameters(drive.preset, seed));
      errors_m[name].push_back(drive.relations.empty() ? outcome.aligned_m : outcome.error_m);
    };
    Add("none", recording);
    for (const auto& [name, lie] : kLies) Add(name, Lie(recording, lie));
  }
  const double without_m = Median(errors_m["none"]);
  for (const auto& [name, of_kind_m] : errors_m) {
    const double with_m = Median(of_kind_m);
    fmt::print("{:<12} wheels: {:<36} error {:.4f} m\n", drive.source, name, with_m);
    INFO(name);
    CHECK((with_m <= kWorseShare * without_m || with_m <= without_m + kWorse_m));
  }
  std::fflush(stdout);
}

}  // namespace

TEST_CASE("wheels that lie make the map of a flat no worse than none") {
  const World flat = ParseWorld(LoadWorldText("demo") + "\nwheels 1 1 0.02 0.03\n", "flat");
  CheckNoLieMatters({"flat"}, NumSeeds(1), [&](std::uint64_t seed) {
    Simulator simulator(flat, seed);
    return Record(simulator);
  });
}

TEST_CASE("wheels that lie make the map of a real drive no worse than none", "[logs]") {
  const auto log = FindRealLog("radish/aces.clf.gz");
  const auto relations = FindRealLog("radish/aces.relations");
  if (!log || !relations) return;
  CheckNoLieMatters({*log, "sick", *relations}, NumSeeds(3),
                    [&](std::uint64_t seed) { return Record(*log, ShippedParameters("sick", seed)); });
}

}  // namespace crsm
