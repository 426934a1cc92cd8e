#include "common/metrics/trajectory_error.hpp"

#include <cmath>

#include "catch.hpp"
#include "source_helpers.hpp"

namespace crsm {

TEST_CASE("a trajectory that is turned and moved as a whole has no error once it is aligned") {
  const Trajectory truth = {{1, {0, 0, 0}}, {2, {3, 0, 0.5}}, {3, {3, 4, 3.1}}, {5, {7, 7, 0}}};
  const Pose2 T_moved{2.0, -1.0, 2.9};
  Trajectory moved = {{4, {1, 1, 1}}};  // a moment that the truth does not have
  for (const auto& [utime, pose] : truth) moved.push_back({utime, T_moved * pose});
  CHECK(EvaluateTrajectory(moved, truth).mean_m > 1.0);
  CHECK(EvaluateTrajectory(Align(moved, truth), truth).max_m < 1e-12);
  CHECK(EvaluateTrajectory(Align(moved, truth), truth).max_rad < 1e-12);

  moved[2].T_map_laser.x_m += 0.3;  // one pose of four is wrong: least squares spread that
  CHECK(EvaluateTrajectory(Align(moved, truth), truth).max_m < 0.3);
  CHECK(EvaluateTrajectory(Align(moved, truth), truth).max_m > 0.1);
}

TEST_CASE("the trajectory's error is measured without aligning anything") {
  const Trajectory truth = {{1, {0, 0, 0}}, {2, {1, 0, 0.5}}, {3, {2, 2, 3.1}}, {5, {7, 7, 0}}};
  const Trajectory estimate = {{1, {0, 0, 0}}, {2, {1.03, -0.04, 0.5}}, {3, {2, 2.5, -3.1}}, {4, {9, 9, 9}}};
  const TrajectoryError error = EvaluateTrajectory(estimate, truth);
  CHECK(error.num_poses == 3);
  CHECK(error.mean_m == Approx((0.0 + 0.05 + 0.5) / 3.0));
  CHECK(error.median_m == Approx(0.05));
  CHECK(error.max_m == Approx(0.5));
  CHECK(error.rmse_m == Approx(std::sqrt((0.05 * 0.05 + 0.5 * 0.5) / 3.0)));
  CHECK(error.max_rad == Approx(2.0 * kPi - 6.2));  // across the seam
  CHECK(EvaluateTrajectory({{2, {1, 0.1, 0.5}}, {3, {2, 2.3, 0}}}, truth).median_m == Approx(0.2));
}

TEST_CASE("a trajectory without a moment in common with the truth is refused") {
  CHECK(ErrorOf([] {
          EvaluateTrajectory({{1, {}}}, {{2, {}}});
        }) == "the trajectory and the truth have no moment in common");
  CHECK_THROWS(EvaluateTrajectory({}, {}));
  CHECK_THROWS(Align({{1, {}}}, {{2, {}}}));
}

}  // namespace crsm
