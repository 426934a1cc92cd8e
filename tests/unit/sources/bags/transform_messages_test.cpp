#include "services/sources/bags/transform_messages.hpp"

#include <cmath>

#include "catch.hpp"
#include "transform_bytes.hpp"

namespace crsm {
namespace {

const BagTopic kRos1{"/tf", "tf2_msgs/TFMessage", "ros1"};
const BagTopic kCdr{"/tf", "tf2_msgs/msg/TFMessage", "cdr"};
const double kHalf = std::sqrt(0.5);

/// Of both encodings, which must agree.
std::vector<Transform> DecodeBoth(const std::vector<TransformFields>& fields) {
  const auto ros1 = DecodeTransforms(kRos1, Ros1Transforms(fields));
  const auto cdr = DecodeTransforms(kCdr, CdrTransforms(fields));
  REQUIRE(ros1);
  REQUIRE(cdr);
  REQUIRE(ros1->size() == cdr->size());
  for (std::size_t i = 0; i < cdr->size(); ++i) {
    CHECK(ros1->at(i).utime == cdr->at(i).utime);
    CHECK(ros1->at(i).parent == cdr->at(i).parent);
    CHECK(ros1->at(i).child == cdr->at(i).child);
    REQUIRE(ros1->at(i).T_parent_child.has_value() == cdr->at(i).T_parent_child.has_value());
    if (cdr->at(i).T_parent_child) CHECK(ros1->at(i).T_parent_child->matrix() == cdr->at(i).T_parent_child->matrix());
  }
  return *cdr;
}

}  // namespace

TEST_CASE("transforms are read with their frames, times and poses, from one message as many as it has") {
  const auto transforms = DecodeBoth({{.parent = "odom", .child = "base", .x_m = 1.5, .y_m = -2.0, .nanosec = 2000},
                                      {.parent = "a", .child = "bc", .x_m = 3.0, .rotation = {0.0, 0.0, kHalf, kHalf}},
                                      {.parent = "", .child = "/robot/laser_frame"}});
  REQUIRE(transforms.size() == 3);
  CHECK(transforms[0].utime == 100'000'002);
  CHECK(transforms[0].parent == "odom");
  CHECK(transforms[0].child == "base");
  CHECK(InPlane(*transforms[0].T_parent_child) == Pose2{1.5, -2.0, 0.0});
  CHECK(InPlane(*transforms[1].T_parent_child) == Pose2{3.0, 0.0, 1.570796});  // whole microradians
  CHECK(transforms[2].child == "robot/laser_frame");  // without the slash that old TF put before it
  CHECK(DecodeBoth({}).empty());
}

TEST_CASE("the heading of a pose that leans is that of its x axis") {
  // Yaw 90 degrees, then roll 10 degrees about the new x axis.
  const double half_roll = 5.0 * kPi / 180.0;
  const double c = std::cos(half_roll) * kHalf;
  const double s = std::sin(half_roll) * kHalf;
  CHECK(InPlane(*DecodeBoth({{.rotation = {s, s, c, c}}})[0].T_parent_child) == Pose2{0.0, 0.0, 1.570796});
}

TEST_CASE("a transform whose numbers are no pose, or whose time is none, has no pose") {
  for (const TransformFields& bad :
       {TransformFields{.x_m = NAN}, TransformFields{.x_m = INFINITY}, TransformFields{.y_m = -2e6},
        TransformFields{.rotation = {0.0, 0.0, 0.0, 0.0}}, TransformFields{.rotation = {0.0, 0.0, 0.0, 1.1}},
        TransformFields{.rotation = {NAN, 0.0, 0.0, 1.0}}, TransformFields{.nanosec = 1'000'000'000}}) {
    const auto transforms = DecodeBoth({bad, {}});
    CHECK_FALSE(transforms[0].T_parent_child);
    CHECK(transforms[1].T_parent_child);
  }
  const TransformFields before_1970{.sec = 0x80000000u};
  CHECK_FALSE(DecodeTransforms(kCdr, CdrTransforms({before_1970}))->at(0).T_parent_child);
}

TEST_CASE("a TF message that is cut anywhere is refused, and so is one with more behind it") {
  const std::vector<TransformFields> two(2);
  for (const auto& [topic, bytes] : {std::pair(kRos1, Ros1Transforms(two)), std::pair(kCdr, CdrTransforms(two))}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) CHECK_FALSE(DecodeTransforms(topic, bytes.substr(0, size)));
    CHECK_FALSE(DecodeTransforms(topic, bytes + std::string(8, '\0')));
  }
}

TEST_CASE("a count of transforms that is a lie is refused before anything is kept for them") {
  std::string bytes = Ros1Transforms({{}});
  for (const std::uint32_t lie : {0u, 2u, 0x7fffffffu, 0xffffffffu}) {
    bytes.replace(0, 4, Little(lie));
    CHECK_FALSE(DecodeTransforms(kRos1, bytes));
  }
}

TEST_CASE("TF is known by the types of its topics, new and old") {
  CHECK(IsTransformTopic(kRos1));
  CHECK(IsTransformTopic({"/tf", "tf/tfMessage", "ros1"}));
  CHECK(IsTransformTopic({"/any/name", "tf2_msgs/msg/TFMessage", "cdr"}));
  CHECK_FALSE(IsTransformTopic({"/tf", "tf2_msgs/msg/TFMessage", "json"}));
  CHECK_FALSE(IsTransformTopic({"/tf", "nav_msgs/Odometry", "ros1"}));
}

}  // namespace crsm
