// Drives with a break, where nobody knows how the robot came from one scan to the next: what is mapped is right, and
// the rest is not on the map.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "accuracy/gate.hpp"
#include "accuracy/run.hpp"
#include "catch.hpp"
#include "common/math/random.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "common/scan/scan_counts.hpp"

namespace crsm {
namespace {

constexpr double kRight_m = 0.3;  ///< what is further off is wrong

/// What came of a broken drive.
struct Pieces {
  double placed = 0.0;   ///< share of the scans that are on the map
  double error_m = 0.0;  ///< of those: root mean square, the path aligned with the true one
  double wrong = 0.0;    ///< share of the scans that are on it more than kRight_m from where they were taken
  int num_trajectories = 0;
  int num_joins = 0;        ///< loops between two trajectories
  int num_wrong_joins = 0;  ///< of them
};

/// A drive that ends at a share of its way, and goes on at another, recorded on another day: the robot was carried, or
/// moved while nothing was recorded. The clock goes on by `gap_us`.
Recording Carry(const std::string& world, std::uint64_t seed, double end, double from, double to, std::int64_t gap_us) {
  Recording broken = Record(world, ShippedParameters("", seed));
  const Recording later = Record(world, ShippedParameters("", seed + 1000));
  const auto size = static_cast<double>(broken.scans.size());
  broken.scans.resize(static_cast<std::size_t>(end * size));
  broken.truth.resize(broken.scans.size());
  const auto first = static_cast<std::size_t>(from * size);
  const std::int64_t shift_us = broken.scans.back().utime + gap_us - later.scans[first].utime;
  for (std::size_t i = first; i < static_cast<std::size_t>(to * size); ++i) {
    broken.scans.push_back(later.scans[i]);
    broken.truth.push_back(later.truth[i]);
    broken.scans.back().utime += shift_us;
    broken.truth.back().utime += shift_us;
  }
  return broken;
}

Pieces MapBroken(const Recording& recording, const Parameters& parameters) {
  const Outcome outcome = Map(recording, parameters);
  Trajectory placed;
  for (const ScanMatch& match : outcome.matches) {
    if (OutcomeOf(match) == ScanOutcome::kOnMap) placed.push_back({match.utime, match.T_map_laser});
  }
  const Trajectory aligned = Align(placed, recording.truth);
  Pieces pieces;
  pieces.placed = static_cast<double>(placed.size()) / static_cast<double>(outcome.matches.size());
  pieces.error_m = EvaluateTrajectory(aligned, recording.truth).rmse_m;
  pieces.num_trajectories = outcome.graph.num_trajectories();
  std::map<std::int64_t, Pose2> true_poses;
  for (const auto& [utime, pose] : recording.truth) true_poses[utime] = pose;
  const auto num_wrong = std::count_if(aligned.begin(), aligned.end(), [&](const auto& at) {
    return Distance(at.T_map_laser, true_poses[at.utime]) > kRight_m;
  });
  pieces.wrong = static_cast<double>(num_wrong) / static_cast<double>(outcome.matches.size());
  for (const Loop& loop : outcome.graph.loops()) {
    if (loop.older.trajectory == loop.newer.trajectory) continue;
    ++pieces.num_joins;
    if (ErrorOf(loop, outcome.graph, recording.truth) > kRightLoop_m) ++pieces.num_wrong_joins;
  }
  return pieces;
}

enum class To { kKnown, kUnknown };

/// Carries the robot once in each of some drives: to where it was before, or to where it was not.
std::vector<Pieces> CarryIn(const std::string& world, To to, int num_seeds, std::int64_t gap_us) {
  std::vector<Pieces> all;
  for (int seed = 1; seed <= num_seeds; ++seed) {
    const auto seed_number = static_cast<std::uint64_t>(seed);
    Random random(seed_number, 7);
    const double end = random.Uniform(0.4, 0.5);
    const double from = to == To::kKnown ? random.Uniform(0.0, 0.2) : end + random.Uniform(0.05, 0.25);
    const Recording broken = Carry(world, seed_number, end, from, from + 0.25, gap_us);
    all.push_back(MapBroken(broken, ShippedParameters("", seed_number)));
    const Pieces& one = all.back();
    fmt::print(
        "{:<10} seed {:>3}  on the map {:>5.1f} %, of which wrong {:.1f} %  error {:.3f} m  trajectories {}, joins {}, "
        "of which wrong {}\n",
        world, seed, 100.0 * one.placed, 100.0 * one.wrong, one.error_m, one.num_trajectories, one.num_joins,
        one.num_wrong_joins);
    std::fflush(stdout);
  }
  return all;
}

/// Joined as a rule, and never at a wrong place.
void CheckPieces(const std::vector<Pieces>& all) {
  double placed = 0.0;
  for (const Pieces& one : all) {
    CHECK(one.num_wrong_joins == 0);
    CHECK(one.wrong < 0.01);  // some scans, before it is noticed
    placed += one.placed;
  }
  CHECK(placed / static_cast<double>(all.size()) > 0.9);
}

}  // namespace

TEST_CASE("a robot that is carried to where it was before, while it maps, is found again") {
  CheckPieces(CarryIn("sim:demo", To::kKnown, NumSeeds(4), 100'000));
}

TEST_CASE("a robot that moves while nothing is recorded is found again") {
  CheckPieces(CarryIn("sim:demo", To::kKnown, NumSeeds(4), 20'000'000));
}

TEST_CASE("a robot that is carried to where it was not is on a map of its own") {
  for (const Pieces& one : CarryIn("sim:demo", To::kUnknown, NumSeeds(4), 100'000)) {
    CHECK(one.num_wrong_joins == 0);
    CHECK(one.wrong < 0.01);
  }
}

TEST_CASE("a hand before the laser at the start costs the scans that show nothing else") {
  Recording recording = Record("sim:demo", ShippedParameters("", 1));
  for (std::size_t i = 0; i < 2; ++i) {
    for (float& range_m : recording.scans[i].ranges_m) range_m = 0.2f;
  }
  const Pieces pieces = MapBroken(recording, ShippedParameters("", 1));
  CHECK(pieces.placed > 0.99);
  CHECK(pieces.error_m < 0.05);
}

}  // namespace crsm
