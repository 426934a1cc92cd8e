#include "common/match/sweep.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "common/slam.hpp"
#include "common/worlds/simulator.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// How a drive was mapped whose laser sweeps while the robot turns by 3 rad/s, and how fast its matches say it turned.
struct Mapped {
  double worst_m = 0.0;
  double worst_rad = 0.0;
  double fastest_rad_s = 0.0;
  int num_lost = 0;
};

Mapped MapArena(double sweep_s) {
  Parameters parameters;
  parameters.scan.range_max_m = 12.0;
  parameters.scan.sweep_s = sweep_s;
  parameters.update.cell_size_m = 0.03;
  Simulator simulator(LoadWorld("arena"), 1);
  Slam slam(parameters);
  Mapped mapped;
  while (const auto scan = simulator.Next()) {
    const ScanMatch match = slam.Process(*scan).match;
    const Pose2 error = Inverse(*simulator.TruePose()) * match.T_map_laser;
    mapped.worst_m = std::max(mapped.worst_m, Length(error));
    mapped.worst_rad = std::max(mapped.worst_rad, std::abs(error.yaw_rad));
    mapped.fastest_rad_s = std::max(mapped.fastest_rad_s, std::abs(match.twist.yaw_rad_s));
    mapped.num_lost += match.state == MatchState::kLost;
  }
  return mapped;
}

/// Always says that the laser turned by 1 rad/s, and fits best what was deskewed by that.
class AskedMatcher : public Matcher {
 public:
  bool Apply(std::span<const TileChange>) override { return true; }
  ScanMatch Match(const CriticalRays& scan, const TrackingState&, const std::optional<Pose2>&) const override {
    ScanMatch match;
    match.utime = scan.utime;
    match.state = MatchState::kOk;
    match.T_map_laser = {0.0, 0.0, 0.1};  // 0.1 s after the last one
    match.fitness = 1.0 - std::abs(scan.rays.angle_rad.front() + 0.1);
    ++num_asked;
    return match;
  }
  const ByteMap& map() const override { return map_; }

  mutable int num_asked = 0;

 private:
  ByteMap map_{0.05};
};

TrackingState Standing() {
  TrackingState tracking;
  for (std::int64_t utime : {100'000, 200'000}) tracking.Add({utime, {}, 0.99, 1, 1, 1, MatchState::kOk});
  return tracking;
}

}  // namespace

TEST_CASE("a laser that sweeps while the robot turns by 3 rad/s maps its arena, if it is deskewed") {
  const Mapped skewed = MapArena(0.0);
  const Mapped mapped = MapArena(0.15);
  CHECK(mapped.num_lost == 0);
  CHECK(mapped.worst_m < 0.08);
  CHECK(mapped.worst_rad < 0.25);  // where it begins to turn within a sweep
  CHECK(mapped.fastest_rad_s == Approx(3.0).margin(0.6));
  CHECK(skewed.fastest_rad_s == 0.0);
  CHECK(skewed.worst_rad > 2.0 * mapped.worst_rad);
}

TEST_CASE("a sweep is deskewed by how the match says that the laser moved") {
  const CriticalRays scan{300'000, {{0.0f, 1.0f}, {2.0f, 2.0f}, {-0.1f, 0.0f}}, {0, 1}};
  const AskedMatcher matcher;
  const ScanMatch match = MatchSweep(matcher, scan, Standing(), std::nullopt);
  CHECK(match.twist.yaw_rad_s == Approx(1.0));
  CHECK(match.twist.x_m_s == Approx(0.0).margin(1e-9));
  CHECK(match.fitness == Approx(1.0).margin(1e-6));
  CHECK(matcher.num_asked == 2);
}

TEST_CASE("what was measured at once is matched once, and has no twist") {
  const CriticalRays scan{300'000, {{0.0f, 1.0f}, {2.0f, 2.0f}}, {0, 1}};
  const AskedMatcher matcher;
  CHECK(MatchSweep(matcher, scan, Standing(), std::nullopt).twist == Twist{});
  CHECK(matcher.num_asked == 1);
}

TEST_CASE("speeds that no robot has, by utimes that are wrong, are not believed") {
  const CriticalRays scan{200'001, {{0.0f, 1.0f}, {2.0f, 2.0f}, {-0.1f, 0.0f}}, {0, 1}};
  const ScanMatch match = MatchSweep(AskedMatcher(), scan, Standing(), std::nullopt);
  CHECK(std::abs(match.twist.yaw_rad_s) <= 5.0);
}

}  // namespace crsm
