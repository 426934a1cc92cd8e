#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/diagnosis/self_contradiction.hpp"
#include "common/map/byte_map.hpp"
#include "common/scan/scan_counts.hpp"
#include "common/scan/scan_match.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// What tells whether a map is right, gathered while it is made, in memory that does not grow.
///
/// Rays and matches may come in any order to each other, and rays may be missing; what comes out depends only on which
/// came and on the order of the matches. All but the counts is of the scans on the map that is shown.
class RunStatistics {
 public:
  RunStatistics() = default;
  explicit RunStatistics(const DiagnosisConstants::Statistics& constants) : constants_(constants) {}

  /// The rays of a scan. A sample is kept, picked by a hash of the utime: 2,000 scans, 720 rays each.
  void Add(std::int64_t utime, const ValidRays& rays);

  /// The next match.
  void Add(const ScanMatch& match);

  /// What comes are the keyframes of a fleet alone: how far it is from one to the next tells nothing.
  void BeOfKeyframes() { of_keyframes_ = true; }

  /// Those that came with this utime were of another scan.
  void ForgetRays(std::int64_t utime);

  /// All matches are to come again, where it is known better by now: the map was corrected. Rays stay.
  void ForgetMatches();

  struct Values {
    ScanCounts counts = {};
    std::int64_t first_utime = 0;  ///< of the first scan
    std::int64_t degenerate = 0;
    std::int64_t longest_unmatched = 0;  ///< most scans in a row that were lost or without rays
    std::int64_t steps = 0;              ///< pairs of scans in a row that were matched
    std::int64_t far_steps = 0;          ///< those between which the laser moved by more than 0.4 m or 0.25 rad
    double longest_jump_m = 0.0;   ///< longest step that no robot can make, lost between or not; 0 if there is none
    Point longest_jump_ends = {};  ///< where that ends, map frame
    /// Length of the path, by steps that are longer than a robot that stands seems to make. How the robot came from one
    /// trajectory to the next is not known, and is no path.
    double path_m = 0.0;
    double furthest_m = 0.0;    ///< of the matched poses from the first of their trajectory
    double furthest_rad = 0.0;  ///< the same of their yaw
    double mean_fitness = 0.0;  ///< of the matched scans (the paper's MFV), [0, 1]; 0 if there are none
    bool finished_map = false;  ///< scans were localised, and changed nothing
    /// How the turns, and the ways, by odometry go with those by the laser, [-1, 1]; -1 where they are opposite.
    /// Nothing without odometry, or where the robot hardly moved.
    std::optional<double> turns_by_odometry;
    std::optional<double> ways_by_odometry;
  };
  Values values() const;

  /// Share of the rays that go through the map as they went through the building, [0, 1]: not through walls, and to
  /// one. Of 200 scans of the sample, 60 rays each. Nothing where fewer than 20 of them were matched.
  std::optional<double> ComputeMeanAgreement(const ByteMap& map) const;

  /// Whether the scans of the sample contradict each other where the robot was twice.
  SelfContradiction FindContradiction() const;

 private:
  struct Sampled {
    std::optional<ValidRays> rays;
    std::optional<Pose2> T_map_laser;  ///< where the scan was matched
    Twist twist;                       ///< by which it was deskewed then
    double path_m = 0.0;               ///< up to there
    bool degenerate = false;
  };

  /// Sums over steps of products of motions by odometry and by the laser.
  struct Correlation {
    double product = 0.0;
    double odometry = 0.0;
    double laser = 0.0;
    std::optional<double> Compute(double least) const;
  };

  /// Of a trajectory: matches of several robots come in turn.
  struct Track {
    std::optional<Pose2> T_map_on_path;  ///< up to which path_m is counted
    ScanMatch first;
    std::optional<ScanMatch> previous;  ///< if it was matched
  };

  Sampled* FindSampled(std::int64_t utime);
  void CountUnmatched(ScanOutcome outcome);
  void LengthenPath(const ScanMatch& match, Track& track);
  void LookHowFar(const ScanMatch& match, const ScanMatch& first);
  void AddStep(const ScanMatch& from, const ScanMatch& to);
  void LookForJump(const ScanMatch& from, const ScanMatch& to);

  DiagnosisConstants::Statistics constants_ = {};
  Values values_;
  double fitness_sum_ = 0.0;
  std::int64_t num_fitnesses_ = 0;
  std::int64_t num_unmatched_in_a_row_ = 0;
  Correlation turns_;
  Correlation ways_;
  std::map<int, Track> tracks_;
  std::optional<ScanMatch> last_on_map_;
  bool of_keyframes_ = false;
  std::map<std::uint64_t, Sampled> sampled_;  ///< by the hash of the utime: the scans of the smallest ones
};

}  // namespace crsm
