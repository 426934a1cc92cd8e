#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "services/sources/devices/rplidar_samples.hpp"

namespace crsm {
namespace {

/// A sample as the document draws it: quality, the start bit and its inverse; a check bit and 15 bits of angle
/// [deg/64]; 16 bits of range [mm/4].
std::string Sample(bool starts, double angle_deg, unsigned range_mm) {
  const auto angle = static_cast<unsigned>(angle_deg * 64.0);
  const unsigned range = range_mm * 4;
  const unsigned bytes[]{15u << 2 | (starts ? 1u : 2u), (angle & 0x7f) << 1 | 1u, angle >> 7, range & 0xff, range >> 8};
  return std::string(std::begin(bytes), std::end(bytes));
}

/// A turn of 36 samples from `first_deg` on, the k-th of which is 1000 + 100 turn + k mm away.
std::string Turn(unsigned turn, double first_deg = 0.0) {
  std::string bytes;
  for (unsigned k = 0; k < 36; ++k) bytes += Sample(k == 0, first_deg + 10.0 * k, 1000 + 100 * turn + k);
  return bytes;
}

/// The turn that a scan shows, if its 36 ranges are where they belong, 40 of the grid's beams apart; else -1.
int TurnOf(const DeviceScan& scan) {
  if (scan.scan.ranges_m.size() != 1440) return -1;
  const auto first_mm = std::lround(1000.0f * scan.scan.ranges_m[0]);
  for (std::size_t beam = 0; beam < 1440; ++beam) {
    const auto range_mm = std::lround(1000.0f * scan.scan.ranges_m[beam]);
    if (range_mm != (beam % 40 == 0 ? first_mm + static_cast<long>(beam / 40) : 0)) return -1;
  }
  return static_cast<int>(first_mm - 1000) / 100;
}

/// What comes of bytes, and how many turns were damaged.
struct Result {
  std::vector<DeviceScan> scans;
  std::vector<int> turns;
  std::int64_t num_bad = 0;
};

Result Take(const std::vector<std::string>& pieces) {
  DeviceReport report;
  RplidarSamples samples(report, 500);
  Result result;
  for (const std::string& piece : pieces) samples.Take(piece, result.scans);
  for (const DeviceScan& scan : result.scans) result.turns.push_back(TurnOf(scan));
  result.num_bad = report.counts["bad_turn"];
  CHECK(report.counts.size() == 1);
  return result;
}

using Turns = std::vector<int>;

}  // namespace

TEST_CASE("the bytes of a sample are its angle and its range") {
  // By hand: 45 deg are 2880 = 0xb40, of which 7 bits are 0x40; 1 m is 4000 = 0xfa0.
  CHECK(Sample(true, 45.0, 1000) == std::string("\x3d\x81\x16\xa0\x0f", 5));
}

TEST_CASE("turns come when the next begins, clockwise, their time from their samples") {
  const Result result = Take({Turn(0) + Turn(1, 3.0) + Turn(2)});
  CHECK(result.turns == Turns{0, 1});
  CHECK(result.num_bad == 0);
  CHECK(result.scans[0].scan.angle_min_rad == 0.0f);
  CHECK(result.scans[1].scan.angle_min_rad == Approx(-3.0 * kPi / 180.0));
  CHECK(result.scans[0].scan.angle_step_rad == Approx(-2.0 * kPi / 1440));
  CHECK(result.scans[0].turn_s == Approx(36 * 500e-6));
  CHECK(result.scans[1].device_us - result.scans[0].device_us == 36 * 500);
}

TEST_CASE("turns come whole however their bytes are cut, and what comes before a first start is none") {
  std::vector<std::string> bytes;
  for (const char byte : Turn(9).substr(100) + Turn(0) + Turn(1) + Turn(2)) bytes.emplace_back(1, byte);
  CHECK(Take(bytes).turns == Turns{0, 1});
  CHECK(Take(bytes).num_bad == 0);
}

TEST_CASE("bytes that are lost, doubled or wrong cost their own turn, which is counted, and no other") {
  const std::string good = Turn(3);
  std::string started_twice = good;
  started_twice[5 * 20] = '\x3d';                                                        // the start bit
  const std::vector<std::string> damaged{good.substr(0, 60) + good.substr(61),           // one byte lost
                                         good.substr(0, 62) + good.substr(64),           // two
                                         good.substr(0, 30) + good.substr(103),          // many
                                         good.substr(0, 62) + "\xff" + good.substr(62),  // one too many
                                         good.substr(0, 60) + '\0' + good.substr(61),    // wrong check bits
                                         good.substr(0, 61) + '\0' + good.substr(62),    // ... of the angle
                                         good.substr(0, 62) + "\x2d" + good.substr(63),  // 360 deg and more
                                         good.substr(0, 90) + std::string(50, '\x55') + good.substr(90),
                                         std::string(good.size(), '\0'),  // at its beginning: the turn before is whole
                                         '\0' + good.substr(1),
                                         good.substr(1),
                                         started_twice};
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    CAPTURE(i);
    const Result result = Take({Turn(0) + Turn(1) + damaged[i] + Turn(4) + Turn(5)});
    CHECK(result.turns == Turns{0, 1, 4});
    CHECK(result.num_bad >= 1);  // noise may look like the starts of more
  }
  // Where the last sample of the turn before is damaged as well, that is lost too.
  CHECK(Take({Turn(0) + Turn(1).substr(0, 175) + good.substr(1) + Turn(4) + Turn(5)}).turns == Turns{0, 4});
}

TEST_CASE("a motor that stands still makes no turns and takes no memory") {
  std::string still;
  for (int i = 0; i < 1000; ++i) still += Sample(false, 90.0, 500);
  CHECK(Take(std::vector(100, still)).turns.empty());
}

}  // namespace crsm
