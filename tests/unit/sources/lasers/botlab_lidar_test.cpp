#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "services/sources/laser_types.hpp"
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

std::optional<LaserScan> Read(const Bytes& message) {
  const LaserType* type = FindLaserType(message);
  return type ? type->decode(message) : std::nullopt;
}

Bytes WithCount(Bytes bytes, std::uint32_t count) {
  constexpr std::size_t kCountAt = 16;  // behind the fingerprint and the utime
  for (std::size_t i = 0; i < 4; ++i) bytes[kCountAt + i] = static_cast<std::uint8_t>(count >> (24 - 8 * i));
  return bytes;
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

TEST_CASE("both spellings of botlab's lidar type are read") {
  const botlab::lidar_t lidar = BotlabLidar({{0.5, 1.0f}, {1.0, 2.0f}});
  REQUIRE(Read(Encode(lidar)));
  CHECK(Read(Encode(OtherSpelling(lidar))) == Read(Encode(lidar)));
}

TEST_CASE("a botlab message that is cut, lengthened or counted wrongly is refused, in both spellings") {
  const botlab::lidar_t lidar = BotlabLidar({{0.5, 1.0f}, {1.0, 2.0f}, {1.5, 3.0f}});
  for (const Bytes& bytes : {Encode(lidar), Encode(OtherSpelling(lidar))}) {
    REQUIRE(Read(bytes));
    CHECK(Read(WithCount(bytes, 3)));
    for (const std::uint32_t count : {0u, 1u, 2u, 4u, 4097u, 0x40000000u, 0x7fffffffu, 0x80000000u, 0xffffffffu}) {
      CAPTURE(count);
      CHECK_FALSE(Read(WithCount(bytes, count)));
    }
    for (std::size_t size = 0; size < bytes.size(); ++size) {  // a copy, so that reading beyond it is an error
      CHECK_FALSE(Read(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))));
    }
    Bytes longer = bytes;
    longer.push_back(0);
    CHECK_FALSE(Read(longer));
  }
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
