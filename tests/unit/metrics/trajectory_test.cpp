#include "common/metrics/trajectory.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "catch.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

Trajectory Read(const std::string& text) { return ReadTrajectory(ScratchFile(text).path()); }

}  // namespace

TEST_CASE("a trajectory is written with the utime's own digits and the half angle's sine and cosine") {
  CHECK(FormatTrajectory({}).empty());
  CHECK(FormatTrajectory({{976052857337530, {1.25, -2.5, 0.0}}}) ==
        "976052857.337530 1.250000000 -2.500000000 0 0 0 0.000000000 1.000000000\n");
  // sin 45 deg = cos 45 deg = 0.7071067811865...
  CHECK(FormatTrajectory({{5, {0.0, 0.0, kPi / 2}}}) ==
        "0.000005 0.000000000 0.000000000 0 0 0 0.707106781 0.707106781\n");
  CHECK(FormatTrajectory({{-1500000, {-0.0, -0.0, -0.0}}}) ==
        "-1.500000 0.000000000 0.000000000 0 0 0 0.000000000 1.000000000\n");
  CHECK(FormatTrajectory({{std::numeric_limits<std::int64_t>::min(), {}}}).rfind("-9223372036854.775808 ", 0) == 0);
}

TEST_CASE("a trajectory with a pose that is not finite is not written") {
  CHECK_THROWS_AS(FormatTrajectory({{1, {0.0, std::nan(""), 0.0}}}), std::invalid_argument);
  CHECK_THROWS_AS(FormatTrajectory({{1, {0.0, 0.0, std::numeric_limits<double>::infinity()}}}), std::invalid_argument);
}

TEST_CASE("what is written is read back: utimes exactly, poses to their nine decimals") {
  Trajectory trajectory;
  for (int i = 0; i < 1000; ++i) {
    // Steps that end in any digits, some of them back in time; yaws from -pi to pi.
    const std::int64_t step = i * 7919993LL - (i % 3) * 15000001LL;
    trajectory.push_back({1700000000123456 + step, {0.013 * i, -0.007 * i, -kPi + 2.0 * kPi * (i + 0.5) / 1000}});
  }
  trajectory.push_back({4000000000000001, {}});
  trajectory.push_back({-3999999999999999, {}});

  const Trajectory read = Read(FormatTrajectory(trajectory));
  REQUIRE(read.size() == trajectory.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK(read[i].utime == trajectory[i].utime);
    CHECK(read[i].T_map_laser.x_m == Approx(trajectory[i].T_map_laser.x_m).margin(1e-9));
    CHECK(read[i].T_map_laser.y_m == Approx(trajectory[i].T_map_laser.y_m).margin(1e-9));
    // Sine and cosine of the half angle are rounded by 5e-10, so the angle by no more than 2 * sqrt(2) * 5e-10.
    CHECK(read[i].T_map_laser.yaw_rad == Approx(trajectory[i].T_map_laser.yaw_rad).margin(2e-9));
  }
}

TEST_CASE("comments, empty lines, tabs, exponents and Windows line ends are read") {
  const Trajectory read =
      Read("# t x y z qx qy qz qw\n\n  \t\r\n1.5\t2 3 0 0 0 0 1\r\n  # so far\n2.5e0 1e-1 0 9 0 0 -1 0");
  REQUIRE(read.size() == 2);
  CHECK(read[0] == StampedPose{1500000, {2.0, 3.0, 0.0}});
  CHECK(read[1].utime == 2500000);
  CHECK(read[1].T_map_laser.x_m == 0.1);
  CHECK(std::abs(read[1].T_map_laser.yaw_rad) == Approx(kPi));
}

TEST_CASE("the yaw of a tilted pose is the heading of its x axis on the floor") {
  // Turned by 0.6 about z, then by 0.3 about the new y: q = (cos .3, 0, 0, sin .3) * (cos .15, 0, sin .15, 0).
  const double qw = std::cos(0.3) * std::cos(0.15);
  const double qx = -std::sin(0.3) * std::sin(0.15);
  const double qy = std::cos(0.3) * std::sin(0.15);
  const double qz = std::sin(0.3) * std::cos(0.15);
  const std::string line =
      "0 0 0 0 " + std::to_string(qx) + " " + std::to_string(qy) + " " + std::to_string(qz) + " " + std::to_string(qw);
  CHECK(Read(line).at(0).T_map_laser.yaw_rad == Approx(0.6).margin(1e-5));  // six decimals
}

TEST_CASE("a bad line is named with its number, and what it must be") {
  const std::string numbers = "must be the eight numbers t x y z qx qy qz qw, each within +-4.5e9";
  const std::vector<std::pair<std::string, std::string>> errors{
      {"# ok\n1 2 3 0 0 0 0\n", ":2: " + numbers},
      {"1 2 3 0 0 0 0 1 9\n", ":1: " + numbers},
      {"1 2 3 0 0 0 0 1\n1 2 3 0 0 0 zero 1\n", ":2: " + numbers},
      {"1 2 nan 0 0 0 0 1\n", ":1: " + numbers},
      {"1 2 1e999 0 0 0 0 1\n", ":1: " + numbers},
      {"976052857337530 2 3 0 0 0 0 1\n", ":1: " + numbers},  // microseconds where seconds belong
      {"1,2,3,0,0,0,0,1\n", ":1: " + numbers},
      {std::string(2 << 20, '1'), ":1: " + numbers},
      {"#" + std::string(2 << 20, '1'), ":1: " + numbers},  // longer than any line that is looked at
      {"1 2 3 0 0 0 0 0\n", ":1: the quaternion's length is 0, must be 1"},
      {"1 2 3 0 0 0 0 1.01\n", ":1: the quaternion's length is 1.01, must be 1"}};
  for (const auto& [text, error] : errors) CHECK(ErrorOf([&, &lines = text] { Read(lines); }).ends_with(error));
}

TEST_CASE("an empty trajectory is no error, a missing or cut one is") {
  CHECK(Read("").empty());
  CHECK(ErrorOf([] { ReadTrajectory("/no/such.tum"); }) == "cannot read /no/such.tum: No such file or directory");
  std::string text;
  for (int i = 0; i < 1000; ++i) text += std::to_string(i) + ".0 " + std::to_string(i * i) + " 0 0 0 0 0 1\n";
  const std::string packed = Compress(text);
  CHECK(Read(packed).size() == 1000);
  CHECK(ErrorOf([&] {
          Read(packed.substr(0, packed.size() - 10));
        }).ends_with(": the compressed file is cut short or damaged"));
}
