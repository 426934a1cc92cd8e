#include "common/metrics/relations.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <string>

#include "catch.hpp"
#include "common/logs/carmen_log.hpp"
#include "real_logs.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

std::vector<Relation> Read(const std::string& text) { return ReadRelations(ScratchFile(text).path()); }

Eigen::Matrix3d ToMatrix(const Pose2& pose) {
  Eigen::Matrix3d matrix;
  matrix << std::cos(pose.yaw_rad), -std::sin(pose.yaw_rad), pose.x_m,  //
      std::sin(pose.yaw_rad), std::cos(pose.yaw_rad), pose.y_m, 0.0, 0.0, 1.0;
  return matrix;
}

}  // namespace

TEST_CASE("relations are read with their moments, motion and wrapped yaw") {
  const auto relations = Read("# comment\n1216.630413 1217.490267 0.5 -0.25 0 0 0 -0.1\n\n2 1 0 0 0.0 0 0 7\n");
  REQUIRE(relations.size() == 2);
  CHECK(relations[0].first_utime == 1216630413);
  CHECK(relations[0].second_utime == 1217490267);
  CHECK(relations[0].T_first_second == Pose2{0.5, -0.25, -0.1});
  CHECK(relations[1].T_first_second.yaw_rad == Approx(7.0 - 2.0 * kPi));
  CHECK(Read("").empty());
}

TEST_CASE("a bad relation is named with its file and number") {
  CHECK(ErrorOf([] {
          Read("1 2 0 0 0 0 0 0\n1 2 0 0 0 0\n");
        }).ends_with(":2: must be the eight numbers t1 t2 x y z roll pitch yaw, each within +-4.5e9"));
  for (const std::string motion : {"0 0 0.5 0 0 0", "0 0 0 0.1 0 0", "0 0 0 0 0.1 0"}) {
    CHECK(ErrorOf([&] { Read("1 2 " + motion + "\n"); }).find(":1: z, roll and pitch must be 0") != std::string::npos);
  }
  CHECK_THROWS_WITH(ReadRelations("/no/such.relations"), "cannot read /no/such.relations: No such file or directory");
}

TEST_CASE("a trajectory that fulfils its relation has no error, one that is 3 cm and 4 cm off has 5 cm") {
  // The robot drives 2 m ahead while it turns left by 90 degrees.
  const Trajectory trajectory{{1000000, {1.0, 1.0, kPi / 2}}, {2000000, {1.0, 3.0, kPi}}};
  const RelationErrors exact = EvaluateRelations({{1000000, 2000000, {2.0, 0.0, kPi / 2}}}, trajectory, {});
  CHECK(exact.num_used == 1);
  CHECK(exact.num_missing == 0);
  CHECK(exact.translation_m.max == Approx(0.0).margin(1e-12));
  CHECK(exact.rotation_rad.max == Approx(0.0).margin(1e-12));

  const RelationErrors off = EvaluateRelations({{1000000, 2000000, {2.03, 0.04, kPi / 2 + 0.1}}}, trajectory, {});
  CHECK(off.translation_m.mean == Approx(0.05));
  CHECK(off.translation_m.median == Approx(0.05));
  CHECK(off.translation_m.standard_deviation == 0.0);
  CHECK(off.rotation_rad.mean == Approx(0.1));
}

TEST_CASE("mean, deviation, median and maximum are those of the errors 1, 2, 3 and 6") {
  const Trajectory still{{1, {}}, {2, {}}};
  std::vector<Relation> relations;
  for (const double length_m : {6.0, 1.0, 3.0, 2.0}) relations.push_back({1, 1, {length_m, 0.0, 0.0}});
  const ErrorStatistics even = EvaluateRelations(relations, still, {}).translation_m;
  CHECK(even.mean == Approx(3.0));
  CHECK(even.standard_deviation == Approx(std::sqrt((4.0 + 1.0 + 0.0 + 9.0) / 4.0)));
  CHECK(even.median == Approx(2.5));
  CHECK(even.max == 6.0);
  relations.pop_back();
  CHECK(EvaluateRelations(relations, still, {}).translation_m.median == 3.0);
}

TEST_CASE("moments match to within 2 us, the nearest first, and of a repeated utime the first pose") {
  const Trajectory trajectory{{1000, {}}, {2000, {1.0, 0.0, 0.0}}, {2001, {5.0, 0.0, 0.0}}, {2000, {9.0, 0.0, 0.0}}};
  const auto ErrorAt = [&](std::int64_t first, std::int64_t second) {
    return EvaluateRelations({{first, second, {1.0, 0.0, 0.0}}}, trajectory, {}).translation_m.mean;
  };
  CHECK(ErrorAt(1000, 2000) == 0.0);
  CHECK(ErrorAt(998, 1998) == 0.0);
  CHECK(ErrorAt(1002, 2000) == 0.0);
  CHECK(ErrorAt(1000, 2001) == 4.0);
  CHECK(ErrorAt(1000, 2003) == 4.0);
  CHECK_THROWS(ErrorAt(1000, 2004));
  CHECK_THROWS(ErrorAt(997, 2000));
}

TEST_CASE("relations without their poses are counted, and none left is an error") {
  const Trajectory trajectory{{1000, {}}, {2000, {}}};
  const RelationErrors errors = EvaluateRelations({{1000, 2000, {}}, {1000, 5000, {}}, {9, 2000, {}}}, trajectory, {});
  CHECK(errors.num_used == 1);
  CHECK(errors.num_missing == 2);
  CHECK_THROWS_WITH(EvaluateRelations({{9, 10, {}}}, trajectory, {}),
                    "none of the 1 relations has both its times among the 2 poses of the trajectory: are both files of "
                    "the same log?");
  CHECK_THROWS(EvaluateRelations({}, trajectory, {}));
  CHECK_THROWS(EvaluateRelations({{1000, 2000, {}}}, {}, {}));
}

TEST_CASE("errors agree with homogeneous matrices, wherever the laser stands on the robot") {
  std::mt19937 generator(7);
  const auto Draw = [&generator](double bound) {  // uniform within +-bound
    return bound * (static_cast<double>(generator()) / 2147483648.0 - 1.0);
  };
  const Pose2 T_robot_laser{-0.04, 0.2, 0.3};
  Trajectory trajectory;
  for (int i = 0; i < 100; ++i) trajectory.push_back({i * 1000, {Draw(50.0), Draw(50.0), Draw(3.14)}});
  std::vector<Relation> relations;
  std::vector<double> translations_m;
  std::vector<double> rotations_rad;
  const Eigen::Matrix3d laser_to_robot = ToMatrix(T_robot_laser).inverse();
  for (int i = 0; i < 301; ++i) {
    const std::size_t first = generator() % 100;
    const std::size_t second = generator() % 100;
    const Pose2 reference{Draw(50.0), Draw(50.0), Draw(3.14)};
    relations.push_back({trajectory[first].utime, trajectory[second].utime, reference});
    const Eigen::Matrix3d start = ToMatrix(trajectory[first].T_map_laser) * laser_to_robot;
    const Eigen::Matrix3d end = ToMatrix(trajectory[second].T_map_laser) * laser_to_robot;
    const Eigen::Matrix3d error = ToMatrix(reference).inverse() * start.inverse() * end;
    translations_m.push_back(error.block<2, 1>(0, 2).norm());
    rotations_rad.push_back(std::abs(std::atan2(error(1, 0), error(0, 0))));
  }
  const RelationErrors errors = EvaluateRelations(relations, trajectory, T_robot_laser);
  const auto Check = [](const ErrorStatistics& statistics, const std::vector<double>& expected) {
    const auto values = Eigen::Map<const Eigen::ArrayXd>(expected.data(), static_cast<Eigen::Index>(expected.size()));
    CHECK(statistics.mean == Approx(values.mean()));
    CHECK(statistics.max == Approx(values.maxCoeff()));
  };
  CHECK(errors.num_used == 301);
  Check(errors.translation_m, translations_m);
  Check(errors.rotation_rad, rotations_rad);
}

TEST_CASE("every moment of the real relations is a scan of the real log", "[logs]") {
  const auto log_path = FindRealLog("radish/fr079.clf.gz");
  const auto relations_path = FindRealLog("radish/fr079.relations");
  if (!log_path || !relations_path) return;
  CarmenLog log(*log_path);
  Trajectory trajectory;
  for (const std::int64_t utime : UtimesOf(ReadAll(log))) trajectory.push_back({utime, {}});
  const auto relations = ReadRelations(*relations_path);
  const RelationErrors errors = EvaluateRelations(relations, trajectory, {});
  CHECK(errors.num_used == 1685);
  CHECK(errors.num_missing == 0);
}
