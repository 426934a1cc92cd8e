#include "services/wire/conversions.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "send.hpp"
#include "synthetic_scans.hpp"
#include "wire_messages.hpp"

namespace crsm {
TEST_CASE("a scan comes over the wire as it was") {
  for (const int num_beams : {2, 360, 4096}) {
    const LaserScan scan = ScanRoom({0.1, 0.2, 0.3}, 123456789012345, num_beams);
    CHECK(FromMessage(Send(ToMessage(scan))) == scan);
  }
}

TEST_CASE("a match comes over the wire as it was") {
  for (const MatchState state : {MatchState::kFirst, MatchState::kOk, MatchState::kLost, MatchState::kDegenerate}) {
    ScanMatch match{123, {1.1, -2.2, 3.1}, 0.87, 4001, 73, 122, state, 7, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, {0.6, -0.8}};
    const auto Check = [&] { CHECK(FromMessage(Send(ToMessage(match))) == match); };
    Check();
    match.T_odom_robot = Pose2{4.4, 5.5, -0.6};
    Check();
    match.twist = {0.1, -0.2, 3.0};
    match.trajectory = 3;
    match.floating = true;
    Check();
    match.by_wheels = WheelMotion{{0.5, -0.1, 0.2}, 0.03, 0.01};
    Check();
  }
  CHECK(static_cast<std::int8_t>(MatchState::kFirst) == scan_match_t::FIRST);
  CHECK(static_cast<std::int8_t>(MatchState::kOk) == scan_match_t::OK);
  CHECK(static_cast<std::int8_t>(MatchState::kLost) == scan_match_t::LOST);
  CHECK(static_cast<std::int8_t>(MatchState::kDegenerate) == scan_match_t::DEGENERATE);
}

TEST_CASE("a tile's change comes over the wire as it was, at all four ends of the map and when it is whole") {
  for (const TileIndex index : {TileIndex{-kMaxTile, kMaxTile - 1}, {kMaxTile - 1, -kMaxTile}, {0, 0}}) {
    TileBytes before;
    TileBytes after;
    before.fill(1);
    after.fill(2);
    const TileChange change{index, PackRuns(before, after)};
    map_delta_t message = MapDeltaMessage();
    message.tiles = {ToMessage(change)};
    message.num_tiles = 1;
    const TileChange received = FromMessage(Send(message).tiles.at(0));
    CHECK(received.index == change.index);
    CHECK(received.runs == change.runs);
  }
}

TEST_CASE("rays and which of them are critical come over the wire as they were") {
  for (const int num_beams : {2, 360, 4096}) {
    const CriticalRays rays = RaysOf(ScanRoom({}, 5, num_beams));
    CHECK(FromMessage(Send(ToMessage(rays))) == rays);
    CriticalRays sweep = rays;
    sweep.rays.time_s.assign(rays.rays.size(), -0.125f);
    CHECK(FromMessage(Send(ToMessage(sweep))) == sweep);
  }
  CHECK(FromMessage(Send(ToMessage(CriticalRays{6, {}, {}}))) == CriticalRays{6, {}, {}});
}

TEST_CASE("a tracking state comes over the wire as it was, before the first scan and after many") {
  CHECK(FromMessage(Send(ToMessage(TrackingState()))) == TrackingState());
  CHECK(FromMessage(Send(ToMessage(TrackingState::OnFinishedMap()))) == TrackingState::OnFinishedMap());
  std::vector<ScanMatch> matches;
  for (int k = 0; k < 30; ++k) {
    matches.push_back({100 - k, {0.1 * k, 0.0, 0.0}, 0.02 * k, 1, 1, k, k % 3 ? MatchState::kOk : MatchState::kLost});
    CHECK(FromMessage(Send(ToMessage(After(matches)))) == After(matches));
  }
  TrackingState tracking = After(matches);
  for (const Onset onset : {Onset::kResumed, Onset::kAnywhere}) {
    tracking.BeginSession(onset);
    CHECK(FromMessage(Send(ToMessage(tracking))) == tracking);
  }
  tracking.BeginSessionNear({1.0, -2.0, 0.5});
  CHECK(FromMessage(Send(ToMessage(tracking))) == tracking);
  tracking.Add(matches.back(), {std::nullopt, 3, true});
  CHECK(FromMessage(Send(ToMessage(tracking))) == tracking);
}

TEST_CASE("odometry comes over the wire as it was to the last bit, at every heading, and so does that there is none") {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    // Headings all around, and close to where they wrap.
    const double yaw_rad = i % 2 ? random.Uniform(-4.0, 4.0) : random.Uniform(kPi - 3e-6, kPi + 3e-6);
    const auto pose = RoundOdometry({random.Uniform(-1e3, 1e3), random.Uniform(-1e-5, 1e-5), yaw_rad});
    REQUIRE(pose);
    const Odometry received = FromMessage(Send(ToMessage(Odometry{5, pose})));
    REQUIRE(received.T_odom_robot == pose);
    REQUIRE(received.utime == 5);
  }
  CHECK(FromMessage(Send(ToMessage(Odometry{7, Pose2{}}))).T_odom_robot == Pose2{});
  CHECK(FromMessage(Send(ToMessage(Odometry{7, std::nullopt}))).utime == 7);
  CHECK_FALSE(FromMessage(Send(ToMessage(Odometry{7, std::nullopt}))).T_odom_robot);
}

TEST_CASE("a pose for other viewers is turned about the z axis") {
  const bot_core::pose_t pose = Send(ToPoseMessage({9, {1.0, 2.0, kPi / 2.0}, 0.9, 1, 1, 1, MatchState::kOk}));
  CHECK(pose.utime == 9);
  const double position[] = {1.0, 2.0, 0.0};
  const double orientation[] = {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)};  // w, x, y, z
  for (int i = 0; i < 3; ++i) {
    CHECK(pose.pos[i] == position[i]);
    CHECK((pose.vel[i] == 0.0 && pose.rotation_rate[i] == 0.0 && pose.accel[i] == 0.0));
  }
  for (int i = 0; i < 4; ++i) CHECK(pose.orientation[i] == Approx(orientation[i]));
}

}  // namespace crsm
