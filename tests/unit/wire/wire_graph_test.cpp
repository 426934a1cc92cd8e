#include <cmath>
#include <limits>

#include "catch.hpp"
#include "check_wire.hpp"
#include "services/wire/wire.hpp"

namespace crsm {
namespace {

template <class Message>
void CheckFindingIn(const Message& message) {
  Fields fields(message);
  loop_finding_t& m = fields.message.findings[0];
  fields.Accept(m.older, {{1, 7}});
  fields.Refuse(m.older, {{1, 8}, {-1, -1}, {0, -1}});  // the first is the keyframe itself
  fields.Accept(m.score, {0.0, 1.0});
  fields.Refuse(m.score, {NAN, -0.01, 1.01});
  fields.Accept(m.by, {0, 1, 2, 3, 4});
  fields.Refuse(m.by, {-1, 5});
  fields.IsPose(m.T_older_this);
  CHECK(fields.After([](Message& changed) { changed.num_findings = 0, changed.findings.clear(); }));
  CHECK_FALSE(fields.After([&](Message& changed) { changed.num_findings = 2, changed.findings = {m, m}; }));
  CHECK_FALSE(fields.After([](Message& changed) { changed.num_findings = -1, changed.findings.clear(); }));
}

}  // namespace

TEST_CASE("a finding is of an older keyframe, and there is one at most") {
  CheckFindingIn(PoseGraphMessage());
  CheckFindingIn(KeyframeMessage());
}

TEST_CASE("a keyframe has a finding only if it was searched") {
  Fields fields(KeyframeMessage());
  fields.Refuse(fields.message.searched, {-1, 0, 2});
  CHECK(fields.After([](keyframe_t& m) { m.searched = 0, m.num_findings = 0, m.findings.clear(); }));
}

TEST_CASE(
    "a keyframe has a name, rays that are measurements, an axis of length 1 or 0, and hangs on keyframes before") {
  Fields fields(KeyframeMessage());
  keyframe_t& m = fields.message;
  fields.Refuse(m.utime, {-1});
  fields.Accept(m.epoch, {-1});
  fields.Refuse(m.epoch, {0});
  fields.Refuse(m.id, {{1, -1}, {-1, 8}});
  fields.Refuse(m.range_m[1], {NAN, 0.0f, 1e6f});
  fields.Refuse(m.angle_rad[1], {NAN, 1.0f});
  fields.Refuse(m.angle_rad[2], {13.0f});
  fields.AreFlags({&m.after_lost});
  fields.Refuse(m.begins_anywhere, {-1, 2});
  fields.Accept(m.as_of, {{-1, -1}, {1, 7}});
  fields.Refuse(m.as_of, {{1, -1}, {1, 8}});
  fields.IsPose(m.T_previous_this);
  // One that is sent once more says that its sender has updates of newer ones.
  fields.Accept(m.last_update, {{-1, -1}, {0, 1000}, {1, 7}, {1, 8}, {1, 9}, {1000, 0}});
  fields.Refuse(m.last_update, {{-1, 0}, {0, -1}, {-2, -2}});
  CHECK_FALSE(fields.After([](keyframe_t& changed) { changed.id = changed.previous = {-1, -1}; }));
  const auto WithRays = [&](std::size_t num) {
    return fields.After([=](keyframe_t& changed) {
      changed.num_rays = static_cast<std::int32_t>(num);
      changed.angle_rad.assign(num, 0.5f);
      changed.range_m.assign(num, 1.0f);
    });
  };
  CHECK(WithRays(0));
  CHECK(WithRays(1));
  CHECK_FALSE(WithRays(4097));
  fields.Refuse(m.walls_axis[0], {0.5, NAN});
  fields.Refuse(m.walls_sigma[2], {-0.1, NAN});
  const auto WithAxis = [&](double x, double y) {
    return fields.After([=](keyframe_t& changed) { changed.degenerate_axis[0] = x, changed.degenerate_axis[1] = y; });
  };
  for (const double y : {-1.0, 0.0}) CHECK(WithAxis(0.0, y));
  for (const double x : {0.6, 0.1, double{NAN}}) CHECK_FALSE(WithAxis(x, 0.0));
  for (const double y : {0.9, double{NAN}}) CHECK_FALSE(WithAxis(0.6, y));
}

TEST_CASE("the keyframe before another one has one number less, or is of the trajectory before") {
  const Fields fields(KeyframeMessage());
  struct Case {
    keyframe_id_t previous, id;
    bool fits;
  };
  for (const auto& [previous, id, fits] : {Case{{-1, -1}, {0, 0}, true},
                                           {{0, 0}, {0, 1}, true},
                                           {{0, 30}, {1, 0}, true},
                                           {{-1, -1}, {0, 1}, false},
                                           {{0, 0}, {0, 0}, false},
                                           {{0, 0}, {0, 2}, false},
                                           {{-1, -1}, {1, 0}, false},
                                           {{0, -1}, {1, 0}, false},
                                           {{0, 30}, {2, 0}, false},
                                           {{0, 30}, {1, 1}, false}}) {
    CAPTURE(previous.trajectory, previous.number, id.trajectory, id.number);
    CHECK(fields.After([&previous = previous, &id = id](keyframe_t& m) {
      m.previous = previous;
      m.id = id;
      m.as_of = {-1, -1};
      m.num_constraints = m.num_findings = 0;
      m.constraints.clear();
      m.findings.clear();
    }) == fits);
  }
}

TEST_CASE("a keyframe has a constraint to one that is older, once at most") {
  Fields fields(KeyframeMessage());
  proximity_constraint_t& m = fields.message.constraints[0];
  fields.Accept(m.older, {{1, 7}});
  fields.Refuse(m.older, {{1, 8}, {-1, -1}});
  fields.IsPose(m.T_older_this);
  CHECK(fields.After([](keyframe_t& changed) { changed.num_constraints = 0, changed.constraints.clear(); }));
  CHECK_FALSE(fields.After([](keyframe_t& changed) { changed.num_constraints = 2, changed.constraints.resize(2); }));
}

TEST_CASE("keyframes are asked for after one that there can be, or none, up to 64 at once") {
  Fields fields(KeyframeRequestMessage());
  keyframe_request_t& m = fields.message;
  fields.Accept(m.num_keyframes, {1, 64});
  fields.Refuse(m.num_keyframes, {-1, 0, 65});
  fields.Accept(m.after, {{-1, -1}});
  fields.Refuse(m.after, {{1, -1}});
  fields.Refuse(m.epoch, {0});
  fields.Accept(m.marks_held, {-1, 0});
  fields.Refuse(m.marks_held, {-2});
}

TEST_CASE("a pose graph follows an older one, in parts that there are, of keyframes that there are") {
  Fields fields(PoseGraphMessage());
  pose_graph_t& m = fields.message;
  fields.Refuse(m.utime, {-1});
  fields.Refuse(m.epoch, {0});
  pose_graph_t empty{};
  empty.epoch = empty.num_parts = 1;
  empty.keyframe = empty.previous = empty.constraints_wrong_from = {-1, -1};
  fields.Refuse(m, {empty});
  fields.Accept(m.previous, {{-1, -1}});
  fields.Refuse(m.previous, {{-1, 2}, {1, 8}});  // one that changes something follows another;
  CHECK(fields.After([](pose_graph_t& changed) {
    changed.previous = {1, 8}, changed.changed = 0;
  }));  // else it may not
  CHECK_FALSE(fields.After([](pose_graph_t& changed) { changed.previous = {1, 9}, changed.changed = 0; }));
  fields.Refuse(m.changed, {-1, 2});
  fields.Refuse(m.part, {-1, 1});
  fields.Refuse(m.num_parts, {4097});
  CHECK(fields.After([](pose_graph_t& changed) { changed.part = 4095, changed.num_parts = 4096; }));
  fields.Accept(m.constraints_wrong_from, {{-1, -1}, {1, 8}});
  fields.Refuse(m.constraints_wrong_from, {{1, -1}, {1, 9}});
}

TEST_CASE("the loops of a pose graph lead from an older keyframe to a newer one") {
  Fields fields(PoseGraphMessage());
  for (loop_t* m : {&fields.message.closed[1], &fields.message.rejected[0]}) {
    fields.Accept(m->older, {{0, 1000}});
    fields.Refuse(m->older, {{0, -1}, m->newer, {-1, -1}, {2, 0}});
    fields.Refuse(m->newer, {{1, -1}});
    fields.IsPose(m->T_older_newer);
  }
}

TEST_CASE("the poses of a pose graph are of keyframes that there can be") {
  Fields fields(PoseGraphMessage());
  pose_stretch_t& m = fields.message.moved[1];
  fields.Accept(m.first, {{1, 0}});
  fields.Refuse(m.first, {{1, -1}, {-1, -1}});
  const std::int32_t far = std::numeric_limits<std::int32_t>::max();  // and one more is less than nothing
  fields.Accept(m.first.number, {far - 2});
  fields.Refuse(m.first.number, {far - 1});
  fields.Refuse(m, {{m.first, 0, {}}});
  fields.IsPose(m.poses[1]);
}

TEST_CASE("a pose graph's arrays are limited although the bytes are there") {
  const Fields fields(PoseGraphMessage());
  for (const int num : {0, 2000, 2001}) {
    const auto size = static_cast<std::size_t>(num);
    CHECK(fields.After([=](pose_graph_t& m) {
      m.num_moved = num, m.moved.assign(size, {{0, 0}, 1, {{}}});
    }) == (num <= 2000));
    if (num == 0) continue;
    CHECK(fields.After([=](pose_graph_t& m) { m.moved[0].num_poses = num, m.moved[0].poses.resize(size); }) ==
          (num <= 2000));
  }
  for (const int num : {1024, 1025}) {
    const std::vector<loop_t> loops(static_cast<std::size_t>(num), {{0, 0}, {0, 1}, {}});
    CHECK(fields.After([&](pose_graph_t& m) { m.num_closed = num, m.closed = loops; }) == (num == 1024));
    CHECK(fields.After([&](pose_graph_t& m) { m.num_rejected = num, m.rejected = loops; }) == (num == 1024));
  }
}

}  // namespace crsm
