#include "services/sources/bags/transform_tree.hpp"

#include "catch.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {
namespace {

const auto kUpsideDown = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX());

Transform At(const std::string& parent, const std::string& child, const Pose2& pose = {},
             const Eigen::AngleAxisd& turn = Eigen::AngleAxisd::Identity()) {
  Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
  T_parent_child.translate(Eigen::Vector3d(pose.x_m, pose.y_m, 0.3));
  T_parent_child.rotate(Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ())).rotate(turn);
  return {0, parent, child, T_parent_child};
}

TransformTree MakeTree(const std::vector<Transform>& transforms, const std::string& odometry_frame = "") {
  TransformTree tree(odometry_frame);
  for (const Transform& transform : transforms) tree.Add(transform);
  return tree;
}

using Path = std::vector<std::string>;

void CheckPose(const Pose2& pose, const Pose2& expected) {
  constexpr double kRounding = 2e-6;  // poses are whole micrometres and microradians
  CHECK(std::abs(pose.x_m - expected.x_m) < kRounding);
  CHECK(std::abs(pose.y_m - expected.y_m) < kRounding);
  CHECK(std::abs(WrapAngle(pose.yaw_rad - expected.yaw_rad)) < kRounding);
}

}  // namespace

TEST_CASE("a path leads from the laser to the odometry frame or to a map, and no further") {
  const TransformTree tree =
      MakeTree({At("base", "laser"), At("footprint", "base"), At("odom", "footprint"), At("map", "odom")});
  CHECK(tree.FindPath("laser") == Path{"laser", "base", "footprint", "odom"});
  CHECK(tree.FindPath("unknown") == Path{"unknown"});
  const TransformTree through_map = MakeTree({At("base", "laser"), At("map", "base"), At("odom", "map")});
  CHECK(through_map.FindPath("laser") == Path{"laser", "base", "map"});
  CHECK(through_map.FindRobots().size() == 1);
  // A robot that odometry and a map both claim stays with the odometry, whichever came first.
  CHECK(MakeTree({At("odom", "base"), At("map", "base")}).FindPath("base") == Path{"base", "odom"});
  CHECK(MakeTree({At("map", "base"), At("odom", "base")}).FindPath("base") == Path{"base", "odom"});
}

TEST_CASE("odometry frames are known by their names, with any prefix, or by the name that is asked for") {
  const TransformTree usual;
  for (const char* name : {"odom", "robot1/odom", "odom_combined", "a/b/odom"}) CHECK(usual.IsOdometryFrame(name));
  for (const char* name : {"", "odometry", "map", "odom/base", "wheel_odom"}) CHECK_FALSE(usual.IsOdometryFrame(name));
  const TransformTree named("wheels");
  CHECK(named.IsOdometryFrame("wheels"));
  CHECK_FALSE(named.IsOdometryFrame("odom"));
}

TEST_CASE("a loop is gone through once, a path without end is cut") {
  CHECK(MakeTree({At("b", "a"), At("c", "b"), At("a", "c")}).FindPath("a") == Path{"a", "b", "c"});
  CHECK(MakeTree({At("a", "a")}).FindPath("a") == Path{"a"});
  std::vector<Transform> chain;
  for (int i = 0; i < 1000; ++i) chain.push_back(At(std::to_string(i + 1), std::to_string(i)));
  CHECK(MakeTree(chain).FindPath("0").size() == 64);
  CHECK_FALSE(MakeTree(chain).FindMounting("900", "0").mounting);
}

TEST_CASE("of a hundred thousand names some thousands are kept, and of one that is endless none") {
  TransformTree tree;
  int num_kept = 0;
  for (int i = 0; i < 100'000; ++i) num_kept += tree.Add(At("odom", std::to_string(i))) ? 1 : 0;
  CHECK(num_kept == 4096);
  CHECK(tree.FindRobots().size() == 4096);
  CHECK_FALSE(TransformTree().Add(At("odom", std::string(257, 'x'))));
  CHECK_FALSE(TransformTree().Add({0, "odom", "base", std::nullopt}));
}

TEST_CASE("a mounting is the way from the robot to the laser, over as many joints as there are") {
  const TransformTree tree =
      MakeTree({At("plate", "laser", {0.1, 0.0, kPi / 2}), At("base", "plate", {0.2, 0.3, kPi})});
  const auto found = tree.FindMounting("base", "laser");
  REQUIRE(found.mounting);
  CheckPose(found.mounting->T_robot_laser, {0.1, 0.3, -kPi / 2});
  CHECK_FALSE(found.mounting->is_upside_down);
  CHECK(found.mounting->joints.size() == 2);
}

TEST_CASE("the robot may be another frame than the one that the laser stands on") {
  const TransformTree tree = MakeTree({At("base", "laser", {0.5, 0.0, 0.0}), At("base", "footprint", {0.2, 0.1, kPi})});
  CheckPose(tree.FindMounting("footprint", "laser").mounting->T_robot_laser, {-0.3, 0.1, kPi});
  CheckPose(tree.FindMounting("laser", "laser").mounting->T_robot_laser, {});
}

TEST_CASE("the scans of a laser that hangs upside down show, turned round, the room as it is from the laser's pose") {
  const auto found = MakeTree({At("base", "laser", {0.2, 0.1, 0.4}, kUpsideDown)}).FindMounting("base", "laser");
  REQUIRE(found.mounting);
  CHECK(found.mounting->is_upside_down);
  // A hit in the laser's own axes, worked out in space and in the plane.
  constexpr float kAngle_rad = 0.7f;
  constexpr double kRange_m = 3.0;
  Eigen::Isometry3d T_base_laser = Eigen::Isometry3d::Identity();
  T_base_laser.translate(Eigen::Vector3d(0.2, 0.1, 0.3)).rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  T_base_laser.rotate(kUpsideDown);
  const Eigen::Vector3d hit =
      T_base_laser * Eigen::Vector3d(kRange_m * std::cos(kAngle_rad), kRange_m * std::sin(kAngle_rad), 0.0);
  const LaserScan scan = Mirror({0, kAngle_rad, 0.1f, {3.0f, 3.0f}});
  const Pose2& pose = found.mounting->T_robot_laser;
  const double direction_rad = pose.yaw_rad + static_cast<double>(scan.angle_min_rad);
  CHECK(pose.x_m + kRange_m * std::cos(direction_rad) == Approx(hit.x()).margin(1e-5));
  CHECK(pose.y_m + kRange_m * std::sin(direction_rad) == Approx(hit.y()).margin(1e-5));
}

TEST_CASE("a laser hangs upside down by all joints that carry it, whether or not the robot's frame is known") {
  const TransformTree tree = MakeTree({At("plate", "laser", {}, kUpsideDown), At("base", "plate"), At("odom", "base")});
  for (const char* robot : {"base", "plate", "", "unknown"}) CHECK(tree.IsUpsideDown(robot, "laser"));
  CHECK_FALSE(tree.IsUpsideDown("base", "plate"));
  CHECK_FALSE(tree.IsUpsideDown("", ""));
  CHECK_FALSE(TransformTree().IsUpsideDown("base", "laser"));
  // Twice is upright.
  const TransformTree twice = MakeTree({At("plate", "laser", {}, kUpsideDown), At("base", "plate", {}, kUpsideDown)});
  CHECK_FALSE(twice.IsUpsideDown("base", "laser"));
  CHECK_FALSE(twice.IsUpsideDown("", "laser"));
  // A tree may lead from the laser to the robot.
  CHECK(MakeTree({At("laser", "base", {}, kUpsideDown)}).IsUpsideDown("base", "laser"));
}

TEST_CASE("a laser that leans by more than 45 degrees has no place in the plane") {
  const auto Lean = [](double angle_deg) {
    const Eigen::AngleAxisd lean(angle_deg * kPi / 180.0, Eigen::Vector3d::UnitY());
    return MakeTree({At("base", "laser", {}, lean)}).FindMounting("base", "laser");
  };
  CHECK(Lean(20.0).mounting);
  CHECK(Lean(170.0).mounting->is_upside_down);
  CHECK(Lean(90.0).refusal == "TF tilts it by 90 deg");
  CHECK_FALSE(Lean(120.0).mounting);
}

TEST_CASE("no mounting leads through the odometry frame or a map, nor to a laser that is absurdly far away") {
  const TransformTree tied = MakeTree({At("odom", "base"), At("odom", "laser"), At("map", "other")});
  CHECK(tied.FindMounting("base", "laser").refusal == "TF does not lead from laser to base");
  CHECK_FALSE(tied.FindMounting("base", "other").mounting);
  CHECK_FALSE(tied.FindMounting("base", "unknown").mounting);
  const TransformTree far = MakeTree({At("base", "arm", {9e5, 0.0, 0.0}), At("arm", "laser", {9e5, 0.0, 0.0})});
  CHECK(far.FindMounting("base", "laser").refusal == "TF puts it too far away");
}

}  // namespace crsm
