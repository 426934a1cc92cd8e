#include "common/match/sweep.hpp"

#include <cmath>

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

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

/// Fits nothing near the guess, and by a longer search what was deskewed as far as that.
class FarMatcher : public AskedMatcher {
 public:
  explicit FarMatcher(double least_turn_rad_s) : least_turn_rad_s_(least_turn_rad_s) {}
  ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking,
                  const std::optional<Pose2>& T_odom_robot) const override {
    ScanMatch match = AskedMatcher::Match(scan, tracking, T_odom_robot);
    const double turn_rad_s = -static_cast<double>(scan.rays.angle_rad.front()) / 0.1;
    if (turn_rad_s < least_turn_rad_s_) match.state = MatchState::kLost;
    return match;
  }
  ScanMatch MatchNear(const CriticalRays& scan, const TrackingState&, const std::optional<Pose2>&) const override {
    ScanMatch match;
    match.utime = scan.utime;
    match.state = MatchState::kLost;
    ++num_asked_near;
    return match;
  }

  mutable int num_asked_near = 0;

 private:
  double least_turn_rad_s_;
};

/// Says each time that the laser turned by 0.05 rad more.
class TurningMatcher : public AskedMatcher {
 public:
  ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking,
                  const std::optional<Pose2>& T_odom_robot) const override {
    ScanMatch match = AskedMatcher::Match(scan, tracking, T_odom_robot);
    match.T_map_laser.yaw_rad = 0.05 * num_asked;
    match.fitness = 1.0;
    return match;
  }
};

TrackingState Standing() {
  TrackingState tracking;
  for (std::int64_t utime : {100'000, 200'000}) tracking.Add({utime, {}, 0.99, 1, 1, 1, MatchState::kOk});
  return tracking;
}

}  // namespace

TEST_CASE("a sweep is deskewed by how the match says that the laser moved; what was measured at once is matched once") {
  CriticalRays scan{300'000, {{0.0f, 1.0f}, {2.0f, 2.0f}, {-0.1f, 0.0f}}, {0, 1}};
  const AskedMatcher matcher;
  const ScanMatch match = MatchSweep(matcher, scan, Standing(), std::nullopt);
  CHECK(match.twist.yaw_rad_s == Approx(1.0));
  CHECK(match.twist.x_m_s == Approx(0.0).margin(1e-9));
  CHECK(match.fitness == Approx(1.0).margin(1e-6));
  CHECK(matcher.num_asked == 2);
  scan.rays.time_s.clear();
  CHECK(MatchSweep(matcher, scan, Standing(), std::nullopt).twist == Twist{});
  CHECK(matcher.num_asked == 3);
}

TEST_CASE("a sweep is searched far away only where nothing fits nearby, and until something fits") {
  const CriticalRays scan{300'000, {{0.0f, 1.0f}, {2.0f, 2.0f}, {-0.1f, 0.0f}}, {0, 1}};
  const FarMatcher found(2.0);
  const ScanMatch match = MatchSweep(found, scan, Standing(), std::nullopt);
  CHECK(match.state == MatchState::kOk);
  CHECK(match.twist.yaw_rad_s == Approx(2.5));
  CHECK(found.num_asked_near == 5);
  CHECK(found.num_asked == 2);  // as predicted, and turned by 2.5 rad/s
  const FarMatcher lost(9.0);
  CHECK(MatchSweep(lost, scan, Standing(), std::nullopt).state == MatchState::kLost);
  CHECK(MatchSweep(lost, scan, Standing(), std::nullopt).twist == Twist{});
}

TEST_CASE("a sweep whose matches do not come to agree is matched four times") {
  const CriticalRays scan{300'000, {{0.0f, 1.0f}, {2.0f, 2.0f}, {-0.1f, 0.0f}}, {0, 1}};
  const TurningMatcher matcher;
  MatchSweep(matcher, scan, Standing(), std::nullopt);
  CHECK(matcher.num_asked == 4);
}

TEST_CASE("speeds that no robot has, by utimes that are wrong, are not believed") {
  const CriticalRays scan{200'001, {{0.0f, 1.0f}, {2.0f, 2.0f}, {-0.1f, 0.0f}}, {0, 1}};
  const ScanMatch match = MatchSweep(AskedMatcher(), scan, Standing(), std::nullopt);
  CHECK(std::abs(match.twist.yaw_rad_s) <= 5.0);
}

}  // namespace crsm
