#include <array>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "check_wire.hpp"
#include "services/wire/wire.hpp"

namespace crsm {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanFloat = std::numeric_limits<float>::quiet_NaN();

/// Whether each of its three numbers has to be one that there can be.
template <class Message, class PoseOf>
void CheckPoseIn(const Message& message, PoseOf pose_of) {
  for (const double x_m : {kNan, 1.1e6, -1.1e6}) {
    CHECK_FALSE(IsDecoded(message, [&](Message& m) { pose_of(m).x_m = x_m; }));
    CHECK_FALSE(IsDecoded(message, [&](Message& m) { pose_of(m).y_m = x_m; }));
  }
  for (const double yaw_rad : {kNan, 6.4, -6.4}) {
    CHECK_FALSE(IsDecoded(message, [&](Message& m) { pose_of(m).yaw_rad = yaw_rad; }));
  }
}

template <class LoopOf>
void CheckLoopIn(LoopOf loop_of) {
  using Message = pose_graph_t;
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { loop_of(m).older = {0, -1}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { loop_of(m).older = loop_of(m).newer; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { loop_of(m).older = {-1, -1}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { loop_of(m).older = {2, 0}; }));
  CHECK(IsDecoded(PoseGraphMessage(), [&](Message& m) { loop_of(m).older = {0, 1000}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { loop_of(m).newer = {1, -1}; }));
  CheckPoseIn(PoseGraphMessage(), [&](Message& m) -> pose2_t& { return loop_of(m).T_older_newer; });
}

template <class Message>
void CheckFindingIn(const Message& message) {
  const auto With = [&](auto change) { return IsDecoded(message, [&](Message& m) { change(m.findings[0]); }); };
  CHECK(With([](loop_finding_t& f) { f.older = {1, 7}; }));
  CHECK_FALSE(With([](loop_finding_t& f) { f.older = {1, 8}; }));  // the keyframe itself
  CHECK_FALSE(With([](loop_finding_t& f) { f.older = {-1, -1}; }));
  CHECK_FALSE(With([](loop_finding_t& f) { f.older = {0, -1}; }));
  for (const double score : {0.0, 1.0}) CHECK(With([=](loop_finding_t& f) { f.score = score; }));
  for (const double score : {kNan, -0.01, 1.01}) CHECK_FALSE(With([=](loop_finding_t& f) { f.score = score; }));
  for (const auto by : std::to_array<std::int8_t>({0, 1, 2, 3, 4})) CHECK(With([=](loop_finding_t& f) { f.by = by; }));
  for (const auto by : std::to_array<std::int8_t>({-1, 5})) CHECK_FALSE(With([=](loop_finding_t& f) { f.by = by; }));
  CheckPoseIn(message, [](Message& m) -> pose2_t& { return m.findings[0].T_older_this; });
  CHECK(IsDecoded(message, [](Message& m) { m.num_findings = 0, m.findings.clear(); }));
  CHECK_FALSE(IsDecoded(message, [](Message& m) { m.num_findings = 2, m.findings.push_back(m.findings[0]); }));
  CHECK_FALSE(IsDecoded(message, [](Message& m) { m.num_findings = -1, m.findings.clear(); }));
}

}  // namespace

TEST_CASE("a finding is of an older keyframe, and there is one at most") {
  CheckFindingIn(PoseGraphMessage());
  CheckFindingIn(KeyframeMessage());
}

TEST_CASE("a keyframe has a finding only if it was searched") {
  using Message = keyframe_t;
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.searched = 0; }));
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) {
    m.searched = 0;
    m.num_findings = 0;
    m.findings.clear();
  }));
  for (const auto no_flag : {std::int8_t{-1}, std::int8_t{2}}) {
    CHECK_FALSE(IsDecoded(KeyframeMessage(), [=](Message& m) { m.searched = no_flag; }));
  }
}

TEST_CASE("a keyframe has a name, rays that are measurements, and hangs on keyframes before it") {
  using Message = keyframe_t;
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) { m.epoch = -1; }));
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) { m.num_rays = 0, m.angle_rad.clear(), m.range_m.clear(); }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.utime = -1; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.epoch = 0; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.id = {1, -1}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.id = {-1, 8}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.id = m.previous = {-1, -1}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.range_m[1] = kNanFloat; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.range_m[1] = 0.0f; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.range_m[1] = 1e6f; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.angle_rad[1] = kNanFloat; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.angle_rad[1] = 1.0f; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.angle_rad[2] = 13.0f; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) {
    m.num_rays = 4097;
    m.angle_rad.assign(4097, 0.5f);
    m.range_m.assign(4097, 1.0f);
  }));
  for (const auto no_flag : {std::int8_t{-1}, std::int8_t{2}}) {
    CHECK_FALSE(IsDecoded(KeyframeMessage(), [=](Message& m) { m.after_lost = no_flag; }));
    CHECK_FALSE(IsDecoded(KeyframeMessage(), [=](Message& m) { m.begins_anywhere = no_flag; }));
  }
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) { m.as_of = {-1, -1}; }));
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) { m.as_of = {1, 7}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.as_of = {1, -1}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.as_of = {1, 8}; }));
  CheckPoseIn(KeyframeMessage(), [](Message& m) -> pose2_t& { return m.T_previous_this; });
}

TEST_CASE("a keyframe that is sent once more says that its sender has updates of newer ones") {
  using Message = keyframe_t;
  for (const keyframe_id_t last_update : {keyframe_id_t{-1, -1}, {0, 1000}, {1, 7}, {1, 8}, {1, 9}, {1000, 0}}) {
    CHECK(IsDecoded(KeyframeMessage(), [=](Message& m) { m.last_update = last_update; }));
  }
  for (const keyframe_id_t no_id : {keyframe_id_t{-1, 0}, {0, -1}, {-2, -2}}) {
    CHECK_FALSE(IsDecoded(KeyframeMessage(), [=](Message& m) { m.last_update = no_id; }));
  }
}

TEST_CASE("the keyframe before another one has one number less, or is of the trajectory before") {
  const auto Fits = [](const keyframe_id_t& previous, const keyframe_id_t& id) {
    return IsDecoded(KeyframeMessage(), [&](keyframe_t& m) {
      m.previous = previous;
      m.id = id;
      m.as_of = {-1, -1};
      m.num_constraints = m.num_findings = 0;
      m.constraints.clear();
      m.findings.clear();
    });
  };
  CHECK(Fits({-1, -1}, {0, 0}));
  CHECK(Fits({0, 0}, {0, 1}));
  CHECK(Fits({0, 30}, {1, 0}));
  CHECK_FALSE(Fits({-1, -1}, {0, 1}));
  CHECK_FALSE(Fits({0, 0}, {0, 0}));
  CHECK_FALSE(Fits({0, 0}, {0, 2}));
  CHECK_FALSE(Fits({-1, -1}, {1, 0}));
  CHECK_FALSE(Fits({0, -1}, {1, 0}));
  CHECK_FALSE(Fits({0, 30}, {2, 0}));
  CHECK_FALSE(Fits({0, 30}, {1, 1}));
}

TEST_CASE("a keyframe's degenerate axis is a unit vector, or 0") {
  const auto Fits = [](double x, double y) {
    return IsDecoded(KeyframeMessage(), [=](keyframe_t& m) { m.degenerate_axis[0] = x, m.degenerate_axis[1] = y; });
  };
  CHECK(Fits(0.0, -1.0));
  CHECK(Fits(0.0, 0.0));
  CHECK_FALSE(Fits(0.6, 0.9));
  CHECK_FALSE(Fits(0.1, 0.0));
  CHECK_FALSE(Fits(kNan, 0.0));
  CHECK_FALSE(Fits(0.0, kNan));
}

TEST_CASE("a keyframe has a constraint to one that is older, once at most") {
  using Message = keyframe_t;
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) { m.num_constraints = 0, m.constraints.clear(); }));
  CHECK(IsDecoded(KeyframeMessage(), [](Message& m) { m.constraints[0].older = {1, 7}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.num_constraints = 2, m.constraints.resize(2); }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.constraints[0].older = {1, 8}; }));
  CHECK_FALSE(IsDecoded(KeyframeMessage(), [](Message& m) { m.constraints[0].older = {-1, -1}; }));
  CheckPoseIn(KeyframeMessage(), [](Message& m) -> pose2_t& { return m.constraints[0].T_older_this; });
}

TEST_CASE("keyframes are asked for after one that there can be, or none, up to 64 at once") {
  using Message = keyframe_request_t;
  for (const int num : {1, 64}) CHECK(IsDecoded(KeyframeRequestMessage(), [=](Message& m) { m.num_keyframes = num; }));
  for (const int num : {-1, 0, 65}) {
    CHECK_FALSE(IsDecoded(KeyframeRequestMessage(), [=](Message& m) { m.num_keyframes = num; }));
  }
  CHECK(IsDecoded(KeyframeRequestMessage(), [](Message& m) { m.after = {-1, -1}; }));
  CHECK_FALSE(IsDecoded(KeyframeRequestMessage(), [](Message& m) { m.after = {1, -1}; }));
  CHECK_FALSE(IsDecoded(KeyframeRequestMessage(), [](Message& m) { m.epoch = 0; }));
}

TEST_CASE("a pose graph follows an older one, in parts that there are, of keyframes that there are") {
  using Message = pose_graph_t;
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.utime = -1; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.epoch = 0; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) {
    m = {};
    m.epoch = m.num_parts = 1;
    m.keyframe = m.previous = m.constraints_wrong_from = {-1, -1};
  }));
  CHECK(IsDecoded(PoseGraphMessage(), [](Message& m) { m.previous = {-1, -1}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.previous = {-1, 2}; }));
  // One that changes something follows another; one in which nothing has changed may be of the same keyframe.
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.previous = {1, 8}; }));
  CHECK(IsDecoded(PoseGraphMessage(), [](Message& m) { m.previous = {1, 8}, m.changed = 0; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.previous = {1, 9}, m.changed = 0; }));
  for (const auto no_flag : {std::int8_t{-1}, std::int8_t{2}}) {
    CHECK_FALSE(IsDecoded(PoseGraphMessage(), [=](Message& m) { m.changed = no_flag; }));
  }
  CHECK(IsDecoded(PoseGraphMessage(), [](Message& m) { m.part = 4095, m.num_parts = 4096; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.part = -1; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.part = 1; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.num_parts = 4097; }));
  CHECK(IsDecoded(PoseGraphMessage(), [](Message& m) { m.constraints_wrong_from = {-1, -1}; }));
  CHECK(IsDecoded(PoseGraphMessage(), [](Message& m) { m.constraints_wrong_from = {1, 8}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.constraints_wrong_from = {1, -1}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.constraints_wrong_from = {1, 9}; }));
}

TEST_CASE("the loops of a pose graph lead from an older keyframe to a newer one") {
  CheckLoopIn([](pose_graph_t& m) -> loop_t& { return m.closed[1]; });
  CheckLoopIn([](pose_graph_t& m) -> loop_t& { return m.rejected[0]; });
}

TEST_CASE("the poses of a pose graph are of keyframes that there can be") {
  using Message = pose_graph_t;
  CHECK(IsDecoded(PoseGraphMessage(), [](Message& m) { m.moved[1].first = {1, 0}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.moved[1].first = {1, -1}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.moved[1].first = {-1, -1}; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [](Message& m) { m.moved[1].num_poses = 0, m.moved[1].poses.clear(); }));
  const std::int32_t far = std::numeric_limits<std::int32_t>::max();  // and one more is less than nothing
  CHECK(IsDecoded(PoseGraphMessage(), [=](Message& m) { m.moved[1].first.number = far - 2; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [=](Message& m) { m.moved[1].first.number = far - 1; }));
  CheckPoseIn(PoseGraphMessage(), [](Message& m) -> pose2_t& { return m.moved[1].poses[1]; });
}

TEST_CASE("a pose graph's arrays are limited although the bytes are there") {
  using Message = pose_graph_t;
  const auto WithPoses = [](int num) {
    return IsDecoded(PoseGraphMessage(), [=](Message& m) {
      m.moved[0].num_poses = num;
      m.moved[0].poses.resize(static_cast<std::size_t>(num));
    });
  };
  CHECK(WithPoses(2000));
  CHECK_FALSE(WithPoses(2001));
  const auto WithStretches = [](int num) {
    return IsDecoded(PoseGraphMessage(), [=](Message& m) {
      m.num_moved = num;
      m.moved.assign(static_cast<std::size_t>(num), {{0, 0}, 1, {{}}});
    });
  };
  CHECK(WithStretches(0));
  CHECK(WithStretches(2000));
  CHECK_FALSE(WithStretches(2001));
  const std::vector<loop_t> loops(1025, {{0, 0}, {0, 1}, {}});
  CHECK(IsDecoded(PoseGraphMessage(), [&](Message& m) { m.num_closed = 1024, m.closed = loops; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { m.num_closed = 1025, m.closed = loops; }));
  CHECK(IsDecoded(PoseGraphMessage(), [&](Message& m) { m.num_rejected = 1024, m.rejected = loops; }));
  CHECK_FALSE(IsDecoded(PoseGraphMessage(), [&](Message& m) { m.num_rejected = 1025, m.rejected = loops; }));
}

}  // namespace crsm
