#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/valid_rays.hpp"
#include "services/wire/laser_types.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Beams at clockwise angles, each with a range.
botlab::lidar_t BotlabLidar(const std::vector<std::pair<double, float>>& beams) {
  botlab::lidar_t lidar;
  lidar.utime = 5;
  lidar.num_ranges = static_cast<int>(beams.size());
  for (const auto& [theta_rad, range_m] : beams) {
    lidar.thetas.push_back(static_cast<float>(theta_rad));
    lidar.ranges.push_back(range_m);
    lidar.times.push_back(5);
    lidar.intensities.push_back(1.0f);
  }
  return lidar;
}

/// The same in the other spelling.
botlab::lidar_nranges_t OtherSpelling(const botlab::lidar_t& lidar) {
  botlab::lidar_nranges_t other;
  other.utime = lidar.utime;
  other.nranges = lidar.num_ranges;
  other.ranges = lidar.ranges;
  other.thetas = lidar.thetas;
  other.times = lidar.times;
  other.intensities = lidar.intensities;
  return other;
}

std::optional<LaserScan> Read(const Bytes& message, bool clockwise = true) {
  const auto reading = DecodeLaser(message, {.botlab_clockwise = clockwise});
  return reading ? std::optional(reading->scan) : std::nullopt;
}

/// Four beams, at times of their own.
botlab::lidar_t TimedLidar(const std::vector<std::int64_t>& times) {
  botlab::lidar_t lidar = BotlabLidar({{0.0, 1.0f}, {kPi / 2.0, 2.0f}, {kPi, 3.0f}, {1.5 * kPi, 4.0f}});
  lidar.times = times;
  return lidar;
}

/// Of those four beams.
std::vector<float> TimesOf(const std::optional<LaserScan>& scan) {
  REQUIRE(scan);
  REQUIRE(scan->times_s.size() == 1440);
  return {scan->times_s[0], scan->times_s[360], scan->times_s[720], scan->times_s[1080]};
}

}  // namespace

TEST_CASE("botlab's beams go to the nearest beam of a clockwise grid that begins with the first one") {
  const double step_rad = kPi / 720.0;
  for (const double first_rad : {0.0, 1.0, 6.27}) {
    CAPTURE(first_rad);
    const auto Theta = [&](double past_rad) { return std::fmod(first_rad + past_rad, 2.0 * kPi); };
    const auto scan = Read(Encode(BotlabLidar({{Theta(0.0), 1.0f},
                                               {Theta(10.4 * step_rad), 5.0f},
                                               {Theta(kPi / 2.0), 2.0f},
                                               {Theta(2.0), 0.0f},
                                               {Theta(kPi), 4.0f},
                                               {Theta(1.5 * kPi), 3.0f},
                                               {Theta(2.0 * kPi - 7.6 * step_rad), 6.0f}})));
    REQUIRE(scan);
    CHECK(scan->utime == 5);
    CHECK(scan->angle_min_rad == Approx(WrapAngle(-first_rad)).margin(1e-6));
    CHECK(scan->angle_step_rad == static_cast<float>(-step_rad));
    std::vector<float> expected(1440, 0.0f);
    expected[0] = 1.0f;
    expected[10] = 5.0f;  // rounded to the nearest
    expected[360] = 2.0f;
    expected[720] = 4.0f;
    expected[1080] = 3.0f;
    expected[1440 - 8] = 6.0f;
    CHECK(scan->ranges_m == expected);
  }
}

TEST_CASE("of two botlab beams on one grid beam the nearer counts") {
  const auto scan = Read(Encode(BotlabLidar({{0.0, 3.0f}, {0.001, 2.0f}, {0.0011, 2.5f}, {0.0012, 0.0f}})));
  REQUIRE(scan);
  CHECK(scan->ranges_m[0] == 2.0f);
}

TEST_CASE("botlab's times go with their beams, and the scan's utime is that of the last") {
  const auto scan = Read(Encode(TimedLidar({1'000'000, 1'050'000, 1'050'000, 1'100'000})));
  CHECK(TimesOf(scan) == std::vector<float>{-0.1f, -0.05f, -0.05f, 0.0f});
  CHECK(scan->utime == 1'100'000);
}

TEST_CASE("botlab's times that are of no sweep are left aside") {
  constexpr auto kLast = std::numeric_limits<std::int64_t>::max();
  for (const auto& times : std::vector<std::vector<std::int64_t>>{{0, 0, 0, 0},
                                                                  {5, 5, 5, 5},
                                                                  {-4, -3, -2, -1},
                                                                  {100, 200, 150, 300},
                                                                  {0, 1, 2, 1'000'001},
                                                                  {0, 1, 2, kLast},
                                                                  {-kLast, 0, 1, kLast}}) {
    CAPTURE(times);
    const auto scan = Read(Encode(TimedLidar(times)));
    REQUIRE(scan);
    CHECK(scan->times_s.empty());
    CHECK(scan->utime == 5);
  }
  CHECK(Read(Encode(TimedLidar({0, 1, 2, 1'000'000})))->utime == 1'000'000);  // a second is one
}

TEST_CASE("where botlab's angles are counter-clockwise, the scan is the mirror image, each beam with its time") {
  const botlab::lidar_t lidar = TimedLidar({1'000'000, 1'040'000, 1'060'000, 1'100'000});
  const auto scan = Read(Encode(lidar));
  const auto mirrored = Read(Encode(lidar), false);
  REQUIRE(mirrored);
  CHECK(mirrored->angle_min_rad == -scan->angle_min_rad);
  CHECK(mirrored->angle_step_rad == -scan->angle_step_rad);
  CHECK(mirrored->ranges_m == scan->ranges_m);
  CHECK(mirrored->times_s == scan->times_s);
  CHECK(mirrored->utime == scan->utime);
}

// An RPLidar looks ahead, to the right, back, to the left. The driver of today's mbot says this by rising
// counter-clockwise angles, and numbers the times afterwards.
TEST_CASE("a sweep as today's mbot says it is the sweep that was measured") {
  const auto measured = Read(Encode(TimedLidar({1'000'000, 1'050'000, 1'100'000, 1'150'000})));
  botlab::lidar_t said = BotlabLidar({{kPi / 2.0, 4.0f}, {kPi, 3.0f}, {1.5 * kPi, 2.0f}, {2.0 * kPi, 1.0f}});
  said.times = {1'000'000, 1'050'000, 1'100'000, 1'150'000};
  const auto scan = Read(Encode(said), false);
  const ValidRays expected = FindValidRays(*measured, {});
  const ValidRays rays = FindValidRays(*scan, {});
  REQUIRE(rays.size() == 4);
  std::map<float, float> time_of;  // by range: each beam has its own
  for (std::size_t i = 0; i < 4; ++i) time_of[expected.range_m[i]] = expected.time_s[i];
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(rays.range_m[i]);
    CHECK(rays.time_s[i] == time_of.at(rays.range_m[i]));
    const double right_rad = kPi / 2.0 * (rays.range_m[i] - 1.0);  // 1 m ahead, 2 m to the right, ...
    CHECK(std::abs(WrapAngle(rays.angle_rad[i] + right_rad)) < 1e-6);
  }
}

TEST_CASE("both spellings of botlab's lidar type are read") {
  const botlab::lidar_t lidar = BotlabLidar({{0.5, 1.0f}, {1.0, 2.0f}});
  REQUIRE(Read(Encode(lidar)));
  CHECK(Read(Encode(OtherSpelling(lidar))) == Read(Encode(lidar)));
}

TEST_CASE("a botlab message needs a time, an angle for each beam, and from 2 to 4096 beams") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK_FALSE(Read(Encode(BotlabLidar({{0.5, 1.0f}, {kNan, 2.0f}}))));
  CHECK_FALSE(Read(Encode(BotlabLidar({{100.0, 1.0f}, {1.0, 2.0f}}))));
  botlab::lidar_t before_time = BotlabLidar({{0.5, 1.0f}, {1.0, 2.0f}});
  before_time.utime = -1;
  CHECK_FALSE(Read(Encode(before_time)));
  for (const std::size_t num_beams : {1u, 2u, 4096u, 4097u}) {
    CAPTURE(num_beams);
    const auto scan = Read(Encode(BotlabLidar(std::vector<std::pair<double, float>>(num_beams, {0.5, 1.0f}))));
    CHECK(scan.has_value() == (num_beams == 2 || num_beams == 4096));
  }
}

}  // namespace crsm
