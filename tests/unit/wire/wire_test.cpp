#include "services/wire/wire.hpp"

#include <cmath>
#include <limits>
#include <wire_fields/botlab/lidar_nranges_t.hpp>
#include <wire_fields/botlab/lidar_t.hpp>
#include <wire_fields/sensor_msgs/LaserScan.hpp>

#include "catch.hpp"
#include "check_wire.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr std::int32_t kMost32 = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kMost64 = std::numeric_limits<std::int64_t>::max();

}  // namespace

TEST_CASE(
    "every type comes through whole, and cut, lengthened, of another type or with any byte changed does no harm") {
  const auto CheckTypes = [](const auto&... messages) { (CheckType(messages), ...); };
  CheckTypes(LidarMessage(), SweepMessage(), PoseMessage(), CriticalRaysMessage(), ScanMatchMessage());
  CheckTypes(MapDeltaMessage(), MapPageMessage(), MapRequestMessage(), ScanRequestMessage(), ScanAnswerMessage());
  CheckTypes(KeyframeMessage(), KeyframeRequestMessage(), PoseGraphMessage());
  CheckTypes(ServiceStatusMessage(), JournalHeadMessage(), JournalCheckMessage());
  CheckTypes(FleetPoseMessage(), FleetKeyframeMessage(), ChangesMessage());
  CheckTypes(MarkMessage(), KeptMarkMessage(), RobotMarksMessage(), FleetMarksMessage());
  CheckTypes(BotlabLidarMessage(), BotlabLidarNrangesMessage(), RosScanMessage());
}

TEST_CASE("a sweep's beams have times within two seconds of its utime, and angles within a turn") {
  Fields fields(SweepMessage());
  sweep_t& m = fields.message;
  fields.Accept(m.time_s[0], {-2.0f});
  fields.Refuse(m.time_s[0], {-2.01f, NAN});
  fields.Refuse(m.time_s[2], {NAN});
  fields.Refuse(m.utime, {-1});
  fields.Refuse(m.angle_min_rad, {90.0f});
  fields.Refuse(m.angle_step_rad, {0.0f, 4.0f});
  fields.Refuse(m, {{5, 1, {1.0f}, {0.0f}, 0.0f, 0.1f}});
}

TEST_CASE("a million beams are refused although the bytes for them are there") {
  for (const std::int32_t num_beams : {4096, 4097, 1'000'000}) {
    bot_core::planar_lidar_t message = LidarMessage();
    message.radstep = 1e-6f;
    message.nranges = num_beams;
    message.ranges.assign(static_cast<std::size_t>(num_beams), 1.0f);
    message.nintensities = 0;
    message.intensities.clear();
    CHECK(IsDecoded<bot_core::planar_lidar_t>(Encode(message)) == (num_beams == 4096));
  }
}

TEST_CASE("a lidar message is known by the fingerprint that the LCM world knows") {
  const std::vector<std::uint8_t> bytes = Encode(LidarMessage());
  CHECK(Fingerprint(bytes) == 0xe3d17423180b5e8dULL);
  CHECK(Fingerprint({bytes.data(), 7}) == 0);
}

TEST_CASE("a lidar message may hold ranges that are none, but no angle or time that is none") {
  Fields fields(LidarMessage());
  bot_core::planar_lidar_t& m = fields.message;
  fields.Accept(m.ranges, {{NAN, -1.0f, 1e30f}});
  fields.Accept(m.radstep, {-0.25f});
  fields.Refuse(m.radstep, {NAN, 0.0f, 4.0f});  // 8 rad between the first and the last
  fields.Refuse(m.rad0, {NAN});
  fields.Refuse(m.utime, {-1});
  CHECK(fields.After([](auto& message) { message.nintensities = 0, message.intensities.clear(); }));
  CHECK_FALSE(fields.After([](auto& message) { message.nintensities = 2, message.intensities.pop_back(); }));
  CHECK_FALSE(fields.After([](auto& message) { message.nranges = 1, message.ranges.resize(1); }));
  CHECK_FALSE(fields.After([](auto& message) { message.nranges = 0, message.ranges.clear(); }));
}

TEST_CASE("a pose that is not finite is refused") {
  Fields fields(PoseMessage());
  fields.Refuse(fields.message.pos[1], {NAN});
  fields.Refuse(fields.message.pos[0], {1e7});
  fields.Refuse(fields.message.orientation[2], {HUGE_VAL, 0.9});  // which is no rotation
}

TEST_CASE("critical rays are rising indices into rays that are measurements") {
  Fields fields(CriticalRaysMessage());
  critical_rays_t& m = fields.message;
  fields.Refuse(m.critical, {{0, 3}, {-1, 2}, {2, 0}, {1, 1}});
  fields.Refuse(m.range_m[1], {NAN, 0.0f});
  fields.Refuse(m.angle_rad[1], {NAN, 1.0f});
  fields.Refuse(m.time_s[1], {NAN, 2.1f});
  CHECK(fields.After([](auto& message) { message.num_critical = 0, message.critical.clear(); }));
  CHECK(fields.After([](auto& message) { message.num_times = 0, message.time_s.clear(); }));
  CHECK_FALSE(fields.After([](auto& message) { message.num_times = 2, message.time_s.pop_back(); }));
}

TEST_CASE("a match is a finite pose with a fitness from 0 to 1, a covariance, an axis and a state that there is") {
  Fields fields(ScanMatchMessage());
  scan_match_t& m = fields.message;
  fields.Refuse(m.x_m, {NAN});
  fields.Refuse(m.y_m, {1e300});
  fields.Refuse(m.yaw_rad, {HUGE_VAL});
  fields.Refuse(m.fitness, {1.01, NAN});
  fields.Refuse(m.evaluations, {-1});
  fields.Refuse(m.map_version, {-1});
  fields.Refuse(m.state, {4, -1});
  fields.Refuse(m.odometry_x_m, {NAN});
  fields.Refuse(m.odometry_yaw_rad, {1e3});
  fields.Refuse(m.twist_x_m_s, {NAN});
  fields.Refuse(m.twist_y_m_s, {-20.1});
  fields.Refuse(m.twist_yaw_rad_s, {20.1});
  fields.Refuse(m.trajectory, {-1, kMost32});  // one more may begin
  fields.Refuse(m.has_odometry, {2});
  fields.Refuse(m.floating, {2});
  for (double& covariance : m.covariance) fields.Refuse(covariance, {NAN, HUGE_VAL});
  for (const std::size_t variance : {0U, 3U, 5U}) fields.Refuse(m.covariance[variance], {-1e-9});
  fields.Refuse(m.degenerate_axis[0], {1.1});
  fields.Refuse(m.degenerate_axis[1], {NAN});
}

TEST_CASE("a motion of the wheels is a pose with deviations that are neither nothing nor endless, and one at most") {
  Fields fields(ScanMatchMessage());
  wheel_motion_t& m = fields.message.by_wheels[0];
  fields.IsPose(m.T_from_to);
  for (double* sigma : {&m.sigma_m, &m.sigma_rad}) fields.Refuse(*sigma, {0.0, -0.1, NAN, HUGE_VAL});
  CHECK(fields.After([](auto& message) { message.num_by_wheels = 0, message.by_wheels.clear(); }));
  CHECK_FALSE(fields.After([&](auto& message) { message.num_by_wheels = 2, message.by_wheels = {m, m}; }));
}

TEST_CASE("a map delta has parts that there are, tiles that there can be, and a correction that is a pose") {
  Fields fields(MapDeltaMessage());
  map_delta_t& m = fields.message;
  fields.Refuse(m.utime, {-1});
  fields.Accept(m.epoch, {-1});
  fields.Refuse(m.epoch, {0});
  fields.Refuse(m.version, {0});
  fields.Refuse(m.part, {1, -1});
  fields.Refuse(m.num_parts, {1 << 30});
  fields.Refuse(m.cell_size_m, {NAN, 0.0});
  fields.Refuse(m.tiles[0].tile_x, {1024});
  fields.IsPose(m.T_new_old[0]);
  fields.Refuse(m.trajectory, {-1, kMost32});
  fields.Refuse(m.floating, {2});
  CHECK(fields.After([](auto& message) { message.num_corrections = 0, message.T_new_old.clear(); }));
  CHECK_FALSE(fields.After([](auto& message) { message.num_corrections = 2, message.T_new_old.resize(2); }));
}

TEST_CASE("a page repeats a request that there can be, and holds tiles, matches and loops that there can be") {
  Fields fields(MapPageMessage());
  map_page_t& m = fields.message;
  fields.Refuse(m.request.requester, {0});
  fields.Refuse(m.request.first_tile, {-1});
  fields.Refuse(m.epoch, {0});
  fields.Accept(m.version, {0});  // of an owner that lost its map
  fields.Refuse(m.version, {-1});
  fields.Refuse(m.cell_size_m, {11.0});
  fields.Refuse(m.next_tile, {-2});
  fields.Refuse(m.next_match, {-2});
  fields.Refuse(m.tiles[0].tile_x, {1024});
  fields.Refuse(m.matches[0].x_m, {NAN});
  fields.Refuse(m.tracking[0].num_scans, {-1});
  fields.IsPose(m.loops[1].T_map_older);
  fields.IsPose(m.loops[0].T_map_newer);
  fields.Refuse(m.loops[0].rejected, {2});
  fields.Refuse(m.loops[0].joins, {2});
  CHECK(fields.After([](auto& message) { message.num_loops = 200, message.loops.resize(200); }));
  CHECK_FALSE(fields.After([](auto& message) { message.num_loops = 201, message.loops.resize(201); }));
  CHECK_FALSE(fields.After([](auto& message) { message.num_layouts = 2, message.layout.resize(2); }));
}

TEST_CASE("a scan is asked about by somebody, and the answer has the match of that scan") {
  Fields request(ScanRequestMessage());
  request.Refuse(request.message.utime, {-1});
  request.Refuse(request.message.requester, {0});
  Fields answer(ScanAnswerMessage());
  answer.Refuse(answer.message.utime, {6});
  answer.Refuse(answer.message.epoch, {0});
  answer.Refuse(answer.message.next_utime, {5});
  answer.Refuse(answer.message.matches[0].fitness, {2.0});
  CHECK(answer.After([](auto& message) { message.num_matches = 0, message.matches.clear(); }));
  CHECK_FALSE(answer.After([](auto& message) { message.num_matches = 2, message.matches.resize(2); }));
}

TEST_CASE("a map has no more pieces and breaks than it says, and no more than are told") {
  Fields fields(MapPageMessage());
  map_pieces_t& m = fields.message.layout[0];
  fields.Refuse(m.num_all_pieces, {1});
  fields.Refuse(m.num_all_breaks, {0});
  fields.Refuse(m.num_matched, {-1});
  fields.Refuse(m.num_bridged, {-1, 5});
  for (auto* count : {&m.num_keyframes, &m.num_closed, &m.num_rejected}) fields.Refuse(*count, {-1, kMost64});
  for (double* amount : {&m.off_m, &m.way_back_m, &m.slip_m}) {
    fields.Refuse(*amount, {-2.0, NAN});
    fields.Accept(*amount, {-1.0});
  }
  for (auto* place : {&m.off_at_m, &m.way_back_from, &m.way_back_to, &m.slip_at_m}) {
    for (double& at_m : *place) fields.Refuse(at_m, {NAN});
  }
  fields.Refuse(m.doubts[0].x_m, {NAN});
  fields.Refuse(m.doubts[0].y_m, {NAN});
  fields.Refuse(m.doubts[0].off_m, {-0.5, NAN});
  fields.Refuse(m.pieces[1].keyframes, {-1});
  fields.Refuse(m.pieces[1].scans, {-1});
  fields.Refuse(m.pieces[0].way_m, {NAN});
  map_break_t& at = m.breaks[0];
  fields.Refuse(at.utime, {-1});
  fields.Refuse(at.scan, {-1});
  fields.Refuse(at.seconds, {NAN, -0.1});
  fields.IsPose(at.T_map_before);
  fields.Refuse(at.piece, {0});
  fields.Refuse(at.piece_before, {0});
  fields.Refuse(at.reason, {4});
  CHECK_FALSE(fields.After([](auto& message) {
    map_pieces_t& changed = message.layout[0];
    changed.num_pieces = 51, changed.num_all_pieces = 60, changed.pieces.resize(51);
  }));
  CHECK_FALSE(fields.After([&](auto& message) {
    map_pieces_t& changed = message.layout[0];
    changed.num_breaks = 201, changed.num_all_breaks = 300, changed.breaks.assign(201, at);
  }));
}

TEST_CASE("a tracking state counts what there can be, and remembers the last matches where there were any") {
  using State = tracking_state_t;
  Fields fields(MapPageMessage());
  State& m = fields.message.tracking[0];
  fields.Accept(m, {{0, 0, -1, 1, 0, {}, 0, {}, {}, 0, {}, 0, 0, {}, 0.0}});
  fields.Refuse(m.trajectory, {-1, kMost32});
  fields.Refuse(m.floating, {-1});
  fields.Refuse(m.num_lost, {-1, m.num_scans + 1});
  fields.Refuse(m.newest_utime, {-2});
  fields.Refuse(m.on_finished_map, {2});
  fields.Refuse(m.fitness[1], {NAN});
  fields.Refuse(m.fitness[0], {1.1});
  fields.Refuse(m.recent[0].x_m, {NAN});
  fields.IsPose(m.T_local_map);
  fields.Accept(m.onset, {State::ANYWHERE});
  fields.Refuse(m.onset, {4, -1});
  fields.Refuse(m.T_map_guess.x_m, {NAN});
  fields.Refuse(m.motion_error_m, {NAN, -0.1});
  const auto After = [&](auto change) { return fields.After([&](auto& message) { change(message.tracking[0]); }); };
  CHECK_FALSE(After([](State& s) { s.recent.clear(), s.num_recent = 0; }));  // eight scans, and none of them known
  CHECK_FALSE(After([](State& s) { s.num_scans = s.num_lost = 0; }));
  CHECK_FALSE(After([](State& s) { s.fitness.assign(11, 0.5), s.num_fitnesses = 11; }));
  CHECK_FALSE(After([](State& s) { s.recent.assign(11, s.recent[0]), s.num_scans = 11, s.num_recent = 11; }));

  wheel_model_t& wheels = m.wheels;
  for (double* sum : {&wheels.way_information[9], &wheels.way_vector[0], &wheels.turn[1], &wheels.way_noise[4],
                      &wheels.turn_noise[0]}) {
    fields.Refuse(*sum, {NAN, HUGE_VAL, 1e16});
  }
  fields.Refuse(wheels.wheels_error_m, {-1.0});
  fields.Refuse(wheels.velocity_error_m, {NAN});
  fields.Refuse(wheels.steps, {-1});
  fields.Refuse(wheels.slips, {41});
  fields.Refuse(wheels.have_moved, {2});
  fields.Refuse(wheels.has_start, {2});
  fields.Refuse(wheels.T_map_start.x_m, {NAN});
}

TEST_CASE("a map request comes from somebody and asks from a place that there can be") {
  Fields fields(MapRequestMessage());
  map_request_t& m = fields.message;
  fields.Accept(m.epoch, {0});
  fields.Refuse(m.requester, {0});
  fields.Refuse(m.base_version, {-1});
  fields.Refuse(m.first_tile, {-1});
  fields.Accept(m.first_match, {-1});
  fields.Refuse(m.first_match, {-2});
  fields.Refuse(m.whole, {-1, 2, 0});  // without the whole map there are no pieces
  fields.AreFlags({&m.settled});
  fields.Accept(m.piece, {0, 2, 50});
  fields.Refuse(m.piece, {-1, 1, 51});
  CHECK(fields.After([](auto& message) { message.whole = message.settled = 0, message.piece = 0; }));
}

TEST_CASE("a status is of a time that there can be") {
  Fields fields(ServiceStatusMessage());
  service_status_t& m = fields.message;
  fields.Accept(m.utime, {0});
  fields.Refuse(m.utime, {-1});
  fields.Refuse(m.num_latencies, {-1});
  fields.Refuse(m.num_left_out, {-1, kMost64});
  for (double* amount : {&m.latency_p50_ms, &m.latency_p95_ms, &m.latency_p99_ms, &m.latency_max_ms, &m.resident_mb}) {
    fields.Refuse(*amount, {NAN, HUGE_VAL, -1.0, 1e300});
  }
}

TEST_CASE("a change is a new thing or one that has gone, of some size at some place, seen from somewhere") {
  Fields fields(ChangesMessage());
  changes_t& m = fields.message;
  change_t& change = m.changes[0];
  fields.Refuse(m.utime, {-1});
  fields.Refuse(m.epoch, {0});
  fields.Accept(change.kind, {change_t::NEW, change_t::GONE});
  fields.Refuse(change.kind, {-1, 2});
  fields.Refuse(change.middle_m[0], {NAN, 1e7});
  fields.Refuse(change.yaw_rad, {NAN, 100.0});
  for (double* side_m : {&change.length_m, &change.width_m}) fields.Refuse(*side_m, {NAN, 0.0, -1.0, HUGE_VAL});
  fields.Refuse(change.num_places, {0, -1});
}

TEST_CASE("a robot of a fleet has a piece, a covariance and trajectories, and its keyframes are whole") {
  Fields pose(FleetPoseMessage());
  fleet_pose_t& m = pose.message;
  for (std::int64_t* value : {&m.utime, &m.scan_utime}) pose.Refuse(*value, {-1});
  pose.Refuse(m.epoch, {0});
  pose.Refuse(m.num_keyframes, {-1});
  pose.Refuse(m.piece, {0, -1});
  pose.AreFlags({&m.floating, &m.heard});
  pose.Refuse(m.covariance[0], {NAN, -1.0, 1e13});
  pose.Refuse(m.T_common_map.x_m, {NAN, 1e7});
  pose.Refuse(m.trajectories[0], {-1, kMost32});
  Fields keyframe(FleetKeyframeMessage());
  fleet_keyframe_t& k = keyframe.message;
  keyframe.Refuse(k.heard_utime, {-1});
  keyframe.AreFlags({&k.solved});
  keyframe.Refuse(k.keyframes[0].epoch, {0});
  keyframe.Refuse(k.findings[0].map, {-1});
  keyframe.Refuse(k.findings[0].keyframe.number, {-1});
  keyframe.Refuse(k.findings[0].score, {NAN, -0.1, 1.1});
  keyframe.Accept(k.findings[0].by, {loop_finding_t::DRIFT, loop_finding_t::ANYWHERE});
  keyframe.Refuse(k.findings[0].by, {-1, loop_finding_t::CHECK, 5});
  keyframe.Refuse(k.findings[0].T_keyframe_this.yaw_rad, {NAN, 100.0});
  CHECK_FALSE(keyframe.After([](auto& message) { message.num_keyframes = 0, message.keyframes.clear(); }));
}

TEST_CASE("a mark has text that can be shown, a radius, and the points of a place or of an outline") {
  Fields fields(MarkMessage());
  mark_t& m = fields.message;
  fields.Refuse(m.utime, {-1});
  fields.Refuse(m.action, {-1, 3, mark_t::REMOVED});  // who removes says no more than the id
  fields.AreFlags({&m.in_map_frame});
  fields.Refuse(m.radius_m, {NAN, 0.0, -1.0, 1001.0, HUGE_VAL});
  fields.Refuse(m.x_m[0], {NAN, HUGE_VAL, 1.1e6});
  const std::string long_text(64, 'x');
  for (std::string* text : {&m.id, &m.name}) {
    fields.Refuse(*text, {long_text, std::string("a\nb"), std::string("a\x7f"), std::string("a\0b", 3)});
  }
  fields.Accept(m.name, {std::string(),
                         std::string("K\xc3\xbc"
                                     "che"),
                         std::string(63, 'x')});
  fields.Refuse(m.id, {std::string()});
  fields.Refuse(m.kind, {std::string(), std::string("Victim"), std::string("a b"), std::string(32, 'x')});
  CHECK(fields.After([](auto& mark) { mark = {5, "v1", "", "", mark_t::REMOVED, 0, 0.0, 0, {}, {}}; }));
  for (const std::int32_t num : {0, 2, 65}) {
    const auto n = static_cast<std::size_t>(num);
    CHECK_FALSE(fields.After([&](auto& mark) { mark.num_points = num, mark.x_m.resize(n), mark.y_m.resize(n); }));
  }
  CHECK(fields.After([](auto& mark) { mark.num_points = 64, mark.x_m.resize(64), mark.y_m.resize(64); }));
}

TEST_CASE("a kept mark has a fixed point for each of its points; a placed one a covariance and sightings") {
  Fields kept(KeptMarkMessage());
  kept_mark_t& k = kept.message;
  kept.Refuse(k.fixed[0].keyframe.number, {-1, -2});
  kept.Accept(k.fixed[0].keyframe, {keyframe_id_t{-1, -1}});
  kept.Refuse(k.fixed[0].x_m, {NAN, 5e6});
  kept.Refuse(k.mark.radius_m, {0.0});
  CHECK_FALSE(kept.After([](auto& message) { message.num_fixed = 0, message.fixed.clear(); }));
  Fields page(MapPageMessage());
  placed_mark_t& m = page.message.marks[0];
  page.Refuse(m.num_sightings, {0});
  page.Refuse(m.covariance[0], {NAN, 0.0, -1.0, 1e15});
  page.Refuse(m.covariance[1], {NAN, 1e15});
  page.AreFlags({&m.floating});
  page.Refuse(m.y_m[2], {NAN});
  page.Refuse(m.kind, {std::string()});
  CHECK_FALSE(
      page.After([](auto& message) { message.num_marks = 1001, message.marks.assign(1001, message.marks[0]); }));
  page.Accept(m.id, {std::string(127, 'x')});
  page.Refuse(m.id, {std::string(128, 'x'), std::string("a\nb"), std::string()});
}

TEST_CASE("the places of a robot have keyframes, a covariance and text that can be shown") {
  Fields fields(FleetMarksMessage());
  fleet_marks_t& m = fields.message;
  fields.Refuse(m.map, {-1});
  fields.Refuse(m.marks.epoch, {0});
  fields.Refuse(m.marks.checksum, {0, -1, std::int64_t{1} << 32});  // 0: of no places
  robot_mark_t& mark = m.marks.marks[0];
  fields.Refuse(mark.num_sightings, {0});
  fields.Refuse(mark.covariance[2], {NAN, 0.0, 1e15});
  fields.Refuse(mark.id, {std::string(), std::string(64, 'x'), std::string("a\nb")});
  fields.Refuse(mark.points[0].keyframe, {keyframe_id_t{-1, -1}, keyframe_id_t{0, -1}});
  fields.Refuse(mark.points[0].x_m, {NAN, 5e6});
  CHECK(fields.After([](auto& message) { message.marks.num_marks = 0, message.marks.marks.clear(); }));
}

TEST_CASE("a journal's head has an epoch, and its check no place before the file's beginning") {
  Fields head(JournalHeadMessage());
  head.Refuse(head.message.epoch, {0});
  head.Refuse(head.message.finished_map, {2});
  head.Refuse(head.message.utime, {-1});
  Fields check(JournalCheckMessage());
  journal_check_t& m = check.message;
  for (std::int64_t* value : {&m.utime, &m.first_byte, &m.synced_bytes}) check.Refuse(*value, {-1});
  check.Refuse(m.num_bytes, {-1});
}

}  // namespace crsm
