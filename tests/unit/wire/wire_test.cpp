#include "services/wire/wire.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"
#include "check_wire.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanFloat = std::numeric_limits<float>::quiet_NaN();

}  // namespace

TEST_CASE(
    "every type comes through whole, and cut, lengthened, of another type or with any byte changed does no harm") {
  CheckType(LidarMessage());
  CheckType(SweepMessage());
  CheckType(PoseMessage());
  CheckType(CriticalRaysMessage());
  CheckType(ScanMatchMessage());
  CheckType(MapDeltaMessage());
  CheckType(MapPageMessage());
  CheckType(MapRequestMessage());
  CheckType(ScanRequestMessage());
  CheckType(ScanAnswerMessage());
  CheckType(KeyframeMessage());
  CheckType(KeyframeRequestMessage());
  CheckType(PoseGraphMessage());
  CheckType(ServiceStatusMessage());
  CheckType(JournalHeadMessage());
  CheckType(JournalCheckMessage());
}

TEST_CASE("a sweep's beams have times within two seconds of its utime, and angles within a turn") {
  CHECK(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.time_s[0] = -2.0f; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.time_s[0] = -2.01f; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.time_s[2] = kNanFloat; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.utime = -1; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.angle_min_rad = 90.0f; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.angle_step_rad = 0.0f; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep.angle_step_rad = 4.0f; }));
  CHECK_FALSE(IsDecoded(SweepMessage(), [](sweep_t& sweep) { sweep = {5, 1, {1.0f}, {0.0f}, 0.0f, 0.1f}; }));
}

TEST_CASE("a million beams are refused although the bytes for them are there") {
  bot_core::planar_lidar_t message = LidarMessage();
  message.nranges = 1000000;
  message.ranges.assign(1000000, 1.0f);
  message.nintensities = 0;
  message.intensities.clear();
  CHECK_FALSE(IsDecoded<bot_core::planar_lidar_t>(Encode(message)));
  message.nranges = 4096;
  message.ranges.resize(4096);
  message.radstep = 0.001f;
  CHECK(IsDecoded<bot_core::planar_lidar_t>(Encode(message)));
}

TEST_CASE("a lidar message is the one that the LCM world knows") {
  const Bytes bytes = Encode(LidarMessage());
  CHECK(Bytes(bytes.begin(), bytes.begin() + 8) == Bytes{0xe3, 0xd1, 0x74, 0x23, 0x18, 0x0b, 0x5e, 0x8d});
  CHECK(Fingerprint(bytes) == 0xe3d17423180b5e8dULL);
  CHECK(Fingerprint({bytes.data(), 7}) == 0);
  // utime, then nranges, high bytes first, then 1.0f.
  CHECK(Bytes(bytes.begin() + 8, bytes.begin() + 24) == Bytes{0, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 3, 0x3f, 0x80, 0, 0});
  CHECK(bytes.size() == 8 + 8 + 4 + 12 + 4 + 12 + 8);
}

TEST_CASE("a pose message holds 16 doubles behind its time") {
  const Bytes bytes = Encode(PoseMessage());
  CHECK(bytes.size() == 8 + 8 + 16 * 8);
  const auto pose = Decode<bot_core::pose_t>(bytes);
  REQUIRE(pose);
  CHECK(pose->utime == 5);
  CHECK(pose->pos[2] == 3.0);
  CHECK(pose->vel[0] == 4.0);
  CHECK(pose->orientation[3] == 0.5);
  CHECK(pose->rotation_rate[1] == 8.0);
  CHECK(pose->accel[2] == 12.0);
}

TEST_CASE("a lidar message may hold ranges that are none, but no angle or time that is none") {
  using Message = bot_core::planar_lidar_t;
  CHECK(IsDecoded(LidarMessage(), [](Message& m) { m.ranges = {kNanFloat, -1.0f, 1e30f}; }));
  CHECK(IsDecoded(LidarMessage(), [](Message& m) { m.nintensities = 0, m.intensities.clear(); }));
  CHECK(IsDecoded(LidarMessage(), [](Message& m) { m.radstep = -0.25f; }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.rad0 = kNanFloat; }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.radstep = kNanFloat; }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.radstep = 0.0f; }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.radstep = 4.0f; }));  // 8 rad between the first and the last
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.utime = -1; }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.nintensities = 2, m.intensities.pop_back(); }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.nranges = 1, m.ranges.resize(1); }));
  CHECK_FALSE(IsDecoded(LidarMessage(), [](Message& m) { m.nranges = 0, m.ranges.clear(); }));
}

TEST_CASE("a pose that is not finite is refused") {
  CHECK_FALSE(IsDecoded(PoseMessage(), [](bot_core::pose_t& m) { m.pos[1] = kNan; }));
  CHECK_FALSE(IsDecoded(PoseMessage(), [](bot_core::pose_t& m) { m.orientation[2] = HUGE_VAL; }));
  CHECK_FALSE(IsDecoded(PoseMessage(), [](bot_core::pose_t& m) { m.orientation[2] = 0.9; }));  // no rotation
  CHECK_FALSE(IsDecoded(PoseMessage(), [](bot_core::pose_t& m) { m.pos[0] = 1e7; }));
}

TEST_CASE("critical rays are rising indices into rays that are measurements") {
  using Message = critical_rays_t;
  CHECK(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.num_critical = 0, m.critical.clear(); }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.critical = {0, 3}; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.critical = {-1, 2}; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.critical = {2, 0}; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.critical = {1, 1}; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.range_m[1] = kNanFloat; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.range_m[1] = 0.0f; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.angle_rad[1] = kNanFloat; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.angle_rad[1] = 1.0f; }));
  CHECK(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.num_times = 0, m.time_s.clear(); }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.num_times = 2, m.time_s.pop_back(); }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.time_s[1] = kNanFloat; }));
  CHECK_FALSE(IsDecoded(CriticalRaysMessage(), [](Message& m) { m.time_s[1] = 2.1f; }));
}

TEST_CASE("a match is a finite pose with a fitness from 0 to 1 and a state that there is") {
  using Message = scan_match_t;
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.x_m = kNan; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.y_m = 1e300; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.yaw_rad = HUGE_VAL; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.fitness = 1.01; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.fitness = kNan; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.evaluations = -1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.map_version = -1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.state = 4; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.state = -1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.has_odometry = 2; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.odometry_x_m = kNan; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.odometry_yaw_rad = 1e3; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.twist_x_m_s = kNan; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.twist_y_m_s = -20.1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.twist_yaw_rad_s = 20.1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.trajectory = -1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.trajectory = 2'147'483'647; }));  // one more may begin
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.floating = 2; }));
}

TEST_CASE("a motion of the wheels is a pose with deviations that are neither nothing nor endless, and one at most") {
  using Message = scan_match_t;
  CHECK(IsDecoded(ScanMatchMessage(), [](Message& m) { m.num_by_wheels = 0, m.by_wheels.clear(); }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) {
    m.num_by_wheels = 2;
    m.by_wheels.push_back(m.by_wheels[0]);
  }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.by_wheels[0].T_from_to.x_m = kNan; }));
  for (const double sigma : {0.0, -0.1, kNan, HUGE_VAL}) {
    CHECK_FALSE(IsDecoded(ScanMatchMessage(), [sigma](Message& m) { m.by_wheels[0].sigma_m = sigma; }));
    CHECK_FALSE(IsDecoded(ScanMatchMessage(), [sigma](Message& m) { m.by_wheels[0].sigma_rad = sigma; }));
  }
}

TEST_CASE("what was learned of the wheels are finite sums") {
  using Message = tracking_state_t;
  for (const double sum : {kNan, HUGE_VAL, 1e16}) {
    CHECK_FALSE(IsDecoded(TrackingStateMessage(), [sum](Message& m) { m.wheels.way_information[9] = sum; }));
    CHECK_FALSE(IsDecoded(TrackingStateMessage(), [sum](Message& m) { m.wheels.way_vector[0] = sum; }));
    CHECK_FALSE(IsDecoded(TrackingStateMessage(), [sum](Message& m) { m.wheels.turn[1] = sum; }));
    CHECK_FALSE(IsDecoded(TrackingStateMessage(), [sum](Message& m) { m.wheels.delay[0] = sum; }));
    CHECK_FALSE(IsDecoded(TrackingStateMessage(), [sum](Message& m) { m.wheels.way_noise[4] = sum; }));
    CHECK_FALSE(IsDecoded(TrackingStateMessage(), [sum](Message& m) { m.wheels.turn_noise[0] = sum; }));
  }
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.wheels.wheels_error_m = -1.0; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.wheels.velocity_error_m = kNan; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.motion_error_m = kNan; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.motion_error_m = -0.1; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.wheels.steps = -1; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.wheels.slips = 41; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.wheels.has_start = 2; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.wheels.T_map_start.x_m = kNan; }));
}

TEST_CASE("a match has a finite covariance with variances that are not negative, and a unit vector's axis") {
  using Message = scan_match_t;
  for (int i = 0; i < 6; ++i) {
    CHECK_FALSE(IsDecoded(ScanMatchMessage(), [i](Message& m) { m.covariance[i] = kNan; }));
    CHECK_FALSE(IsDecoded(ScanMatchMessage(), [i](Message& m) { m.covariance[i] = HUGE_VAL; }));
  }
  for (const int variance : {0, 3, 5}) {
    CHECK_FALSE(IsDecoded(ScanMatchMessage(), [variance](Message& m) { m.covariance[variance] = -1e-9; }));
  }
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.degenerate_axis[0] = 1.1; }));
  CHECK_FALSE(IsDecoded(ScanMatchMessage(), [](Message& m) { m.degenerate_axis[1] = kNan; }));
}

TEST_CASE("a map delta has parts that there are, tiles that there can be, and a correction that is a pose") {
  using Message = map_delta_t;
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.utime = -1; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.epoch = 0; }));
  CHECK(IsDecoded(MapDeltaMessage(), [](Message& m) { m.epoch = -1; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.version = 0; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.part = 1; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.part = -1; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.num_parts = 1 << 30; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.cell_size_m = kNan; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.cell_size_m = 0.0; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.tiles[0].tile_x = 1024; }));
  CHECK(IsDecoded(MapDeltaMessage(), [](Message& m) { m.num_corrections = 0, m.T_new_old.clear(); }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.num_corrections = 2, m.T_new_old.resize(2); }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.T_new_old[0].x_m = kNan; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.T_new_old[0].y_m = 1e7; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.T_new_old[0].yaw_rad = 7.0; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.trajectory = -1; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.trajectory = 2'147'483'647; }));
  CHECK_FALSE(IsDecoded(MapDeltaMessage(), [](Message& m) { m.floating = 2; }));
}

TEST_CASE("a page repeats a request that there can be, and holds tiles, matches and loops that there can be") {
  using Message = map_page_t;
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.request.requester = 0; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.request.first_tile = -1; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.epoch = 0; }));
  CHECK(IsDecoded(MapPageMessage(), [](Message& m) { m.version = 0; }));  // of an owner that lost its map
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.version = -1; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.cell_size_m = 11.0; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.next_tile = -2; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.next_match = -2; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.tiles[0].tile_x = 1024; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.matches[0].x_m = kNan; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.tracking[0].num_scans = -1; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.loops[1].T_map_older.x_m = kNan; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.loops[0].T_map_newer.y_m = -1e7; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.loops[0].rejected = 2; }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.loops[0].joins = 2; }));
  CHECK(IsDecoded(MapPageMessage(), [](Message& m) { m.num_loops = 200, m.loops.resize(200); }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.num_loops = 201, m.loops.resize(201); }));
  CHECK_FALSE(IsDecoded(MapPageMessage(), [](Message& m) { m.num_layouts = 2, m.layout.resize(2); }));
}

TEST_CASE("a scan is asked about by somebody, and the answer has the match of that scan") {
  CHECK_FALSE(IsDecoded(ScanRequestMessage(), [](scan_request_t& m) { m.utime = -1; }));
  CHECK_FALSE(IsDecoded(ScanRequestMessage(), [](scan_request_t& m) { m.requester = 0; }));
  CHECK(IsDecoded(ScanAnswerMessage(), [](scan_answer_t& m) { m.num_matches = 0, m.matches.clear(); }));
  CHECK_FALSE(IsDecoded(ScanAnswerMessage(), [](scan_answer_t& m) { m.num_matches = 2, m.matches.resize(2); }));
  CHECK_FALSE(IsDecoded(ScanAnswerMessage(), [](scan_answer_t& m) { m.utime = 6; }));
  CHECK_FALSE(IsDecoded(ScanAnswerMessage(), [](scan_answer_t& m) { m.epoch = 0; }));
  CHECK_FALSE(IsDecoded(ScanAnswerMessage(), [](scan_answer_t& m) { m.matches[0].fitness = 2.0; }));
}

TEST_CASE("a map has no more pieces and breaks than it says, and no more than are told") {
  const auto Fits = [](auto&& change) {
    return IsDecoded(MapPageMessage(), [&](map_page_t& m) { change(m.layout[0]); });
  };
  CHECK(Fits([](map_pieces_t&) {}));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.num_all_pieces = 1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.num_all_breaks = 0; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.num_matched = -1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.num_bridged = -1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.num_bridged = 5; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.pieces[1].keyframes = -1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.pieces[1].scans = -1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.pieces[0].way_m = kNan; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].utime = -1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].scan = -1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].seconds = kNan; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].seconds = -0.1; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].T_map_before.x_m = kNan; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].piece = 0; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].piece_before = 0; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.breaks[0].reason = 4; }));
  CHECK_FALSE(Fits([](map_pieces_t& m) { m.num_pieces = 51, m.num_all_pieces = 60, m.pieces.resize(51); }));
  CHECK_FALSE(Fits([](map_pieces_t& m) {
    m.num_breaks = 201, m.num_all_breaks = 300, m.breaks.assign(201, MapPiecesMessage().breaks[0]);
  }));
}

TEST_CASE("a tracking state counts what there can be, and remembers the last matches where there were any") {
  using Message = tracking_state_t;
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.trajectory = -1; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.trajectory = 2'147'483'647; }));
  CHECK_FALSE(IsDecoded(TrackingStateMessage(), [](Message& m) { m.floating = -1; }));
  const auto Fits = [](auto&& change) {
    return IsDecoded(MapPageMessage(), [&](map_page_t& m) { change(m.tracking[0]); });
  };
  CHECK(Fits([](Message&) {}));
  CHECK(Fits([](Message& m) { m = {0, 0, -1, 1, 0, {}, 0, {}, {}, 0, {}, 0, 0, {}, 0.0}; }));
  CHECK_FALSE(Fits([](Message& m) { m.num_lost = -1; }));
  CHECK_FALSE(Fits([](Message& m) { m.num_lost = m.num_scans + 1; }));
  CHECK_FALSE(Fits([](Message& m) { m.newest_utime = -2; }));
  CHECK_FALSE(Fits([](Message& m) { m.on_finished_map = 2; }));
  CHECK_FALSE(Fits([](Message& m) { m.fitness[1] = kNan; }));
  CHECK_FALSE(Fits([](Message& m) { m.fitness[0] = 1.1; }));
  CHECK_FALSE(Fits([](Message& m) { m.recent[0].x_m = kNan; }));
  CHECK_FALSE(Fits([](Message& m) { m.T_local_map.x_m = kNan; }));
  CHECK_FALSE(Fits([](Message& m) { m.T_local_map.y_m = -1e7; }));
  CHECK_FALSE(Fits([](Message& m) { m.T_local_map.yaw_rad = HUGE_VAL; }));
  CHECK(Fits([](Message& m) { m.onset = Message::ANYWHERE; }));
  CHECK_FALSE(Fits([](Message& m) { m.onset = 4; }));
  CHECK_FALSE(Fits([](Message& m) { m.onset = -1; }));
  CHECK_FALSE(Fits([](Message& m) { m.T_map_guess.x_m = kNan; }));
  CHECK_FALSE(Fits([](Message& m) { m.recent.clear(), m.num_recent = 0; }));  // eight scans, and none of them known
  CHECK_FALSE(Fits([](Message& m) { m.num_scans = m.num_lost = 0; }));
  CHECK_FALSE(Fits([](Message& m) { m.fitness.assign(11, 0.5), m.num_fitnesses = 11; }));
  CHECK_FALSE(Fits([](Message& m) { m.recent.assign(11, ScanMatchMessage()), m.num_scans = 11, m.num_recent = 11; }));
}

TEST_CASE("a map request comes from somebody and asks from a place that there can be") {
  CHECK(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.epoch = 0; }));
  CHECK_FALSE(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.requester = 0; }));
  CHECK_FALSE(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.base_version = -1; }));
  CHECK_FALSE(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.first_tile = -1; }));
  CHECK_FALSE(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.first_match = -2; }));
  CHECK(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.first_match = -1; }));
  CHECK(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.whole = m.settled = 0, m.piece = 0; }));
  for (const auto no_flag : {std::int8_t{-1}, std::int8_t{2}}) {
    CHECK_FALSE(IsDecoded(MapRequestMessage(), [=](map_request_t& m) { m.whole = no_flag; }));
    CHECK_FALSE(IsDecoded(MapRequestMessage(), [=](map_request_t& m) { m.settled = no_flag; }));
  }
  for (const int piece : {0, 2, 50}) {
    CHECK(IsDecoded(MapRequestMessage(), [=](map_request_t& m) { m.piece = piece; }));
  }
  for (const int piece : {-1, 1, 51}) {
    CHECK_FALSE(IsDecoded(MapRequestMessage(), [=](map_request_t& m) { m.piece = piece; }));
  }
  CHECK_FALSE(IsDecoded(MapRequestMessage(), [](map_request_t& m) { m.whole = 0; }));  // which has no pieces
}

TEST_CASE("a status is of a time that there can be") {
  CHECK(IsDecoded(ServiceStatusMessage(), [](service_status_t& m) { m.utime = 0; }));
  CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [](service_status_t& m) { m.utime = -1; }));
  CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [](service_status_t& m) { m.num_latencies = -1; }));
  for (const double value : {kNan, std::numeric_limits<double>::infinity(), -1.0, 1e300}) {
    INFO(value);
    CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [&](service_status_t& m) { m.latency_p50_ms = value; }));
    CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [&](service_status_t& m) { m.latency_p95_ms = value; }));
    CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [&](service_status_t& m) { m.latency_p99_ms = value; }));
    CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [&](service_status_t& m) { m.latency_max_ms = value; }));
    CHECK_FALSE(IsDecoded(ServiceStatusMessage(), [&](service_status_t& m) { m.resident_mb = value; }));
  }
}

TEST_CASE("a journal's head has an epoch, and its check no place before the file's beginning") {
  const journal_head_t head = JournalHeadMessage();
  CHECK(IsDecoded(head, [](journal_head_t&) {}));
  CHECK_FALSE(IsDecoded(head, [](journal_head_t& message) { message.epoch = 0; }));
  CHECK_FALSE(IsDecoded(head, [](journal_head_t& message) { message.finished_map = 2; }));
  CHECK_FALSE(IsDecoded(head, [](journal_head_t& message) { message.utime = -1; }));
  const journal_check_t check = JournalCheckMessage();
  CHECK(IsDecoded(check, [](journal_check_t&) {}));
  CHECK_FALSE(IsDecoded(check, [](journal_check_t& message) { message.utime = -1; }));
  CHECK_FALSE(IsDecoded(check, [](journal_check_t& message) { message.first_byte = -1; }));
  CHECK_FALSE(IsDecoded(check, [](journal_check_t& message) { message.num_bytes = -1; }));
  CHECK_FALSE(IsDecoded(check, [](journal_check_t& message) { message.synced_bytes = -1; }));
}

}  // namespace crsm
