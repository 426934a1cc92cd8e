#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "fake_connection.hpp"
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

std::vector<DeviceScan> Take(const std::string& bytes, DeviceReport& report) {
  RplidarSamples samples(report, 500);
  std::vector<DeviceScan> scans;
  samples.Take(bytes, scans);
  return scans;
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

std::vector<int> TurnsOf(const std::vector<DeviceScan>& scans) {
  std::vector<int> turns;
  for (const DeviceScan& scan : scans) turns.push_back(TurnOf(scan));
  return turns;
}

}  // namespace

TEST_CASE("the bytes of a sample are its angle and its range") {
  // By hand: 45 deg are 2880 = 0xb40, of which 7 bits are 0x40; 1 m is 4000 = 0xfa0.
  CHECK(Sample(true, 45.0, 1000) == std::string("\x3d\x81\x16\xa0\x0f", 5));
}

TEST_CASE("turns come when the next begins, clockwise, their time from their samples") {
  DeviceReport report;
  const auto scans = Take(Turn(0) + Turn(1, 3.0) + Turn(2), report);
  CHECK(TurnsOf(scans) == std::vector<int>{0, 1});
  CHECK(scans[0].scan.angle_min_rad == 0.0f);
  CHECK(scans[1].scan.angle_min_rad == Approx(-3.0 * kPi / 180.0));
  CHECK(scans[0].scan.angle_step_rad == Approx(-2.0 * kPi / 1440));
  CHECK(scans[0].turn_s == Approx(36 * 500e-6));
  CHECK(scans[1].device_us - scans[0].device_us == 36 * 500);
  CHECK(report.counts.empty());
}

TEST_CASE("what comes before a first start is no turn") {
  DeviceReport report;
  CHECK(TurnsOf(Take(Turn(0).substr(100) + Turn(1) + Turn(2), report)) == std::vector<int>{1});
  CHECK(report.counts.empty());
}

TEST_CASE("turns come whole however their bytes are cut") {
  DeviceReport report;
  RplidarSamples samples(report, 500);
  std::vector<DeviceScan> scans;
  for (const char byte : Turn(0) + Turn(1) + Turn(2)) samples.Take({&byte, 1}, scans);
  CHECK(TurnsOf(scans) == std::vector<int>{0, 1});
}

TEST_CASE("bytes that are lost, doubled or wrong cost their own turn, which is counted, and no other") {
  const std::string good = Turn(3);
  const std::vector<std::string> damaged{good.substr(0, 60) + good.substr(61),           // one byte lost
                                         good.substr(0, 62) + good.substr(64),           // two
                                         good.substr(0, 30) + good.substr(103),          // many
                                         good.substr(0, 62) + "\xff" + good.substr(62),  // one too many
                                         good.substr(0, 60) + '\0' + good.substr(61),    // wrong check bits
                                         good.substr(0, 61) + '\0' + good.substr(62),    // ... of the angle
                                         good.substr(0, 62) + "\x2d" + good.substr(63),  // 360 deg and more
                                         good.substr(0, 90) + std::string(50, '\x55') + good.substr(90)};
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    CAPTURE(i);
    DeviceReport report;
    CHECK(TurnsOf(Take(Turn(0) + Turn(1) + damaged[i] + Turn(4) + Turn(5), report)) == std::vector<int>{0, 1, 4});
    CHECK(report.counts["bad_turn"] >= 1);  // noise may look like the starts of more
  }
}

TEST_CASE("a turn is whole though the next begins with damage") {
  const std::string good = Turn(3);
  for (const std::string& damaged : {std::string(good.size(), '\0'), '\0' + good.substr(1), good.substr(1)}) {
    DeviceReport report;
    CHECK(TurnsOf(Take(Turn(0) + Turn(1) + damaged + Turn(4) + Turn(5), report)) == std::vector<int>{0, 1, 4});
    CHECK(report.counts["bad_turn"] == 1);
  }
  DeviceReport report;  // where its last sample is damaged as well, it is not
  CHECK(TurnsOf(Take(Turn(0) + Turn(1).substr(0, 175) + good.substr(1) + Turn(4) + Turn(5), report)) ==
        std::vector<int>{0, 4});
}

TEST_CASE("a start in the middle of a turn ends no turn") {
  DeviceReport report;
  std::string twice = Turn(1);
  twice[5 * 20] = '\x3d';  // the start bit
  CHECK(TurnsOf(Take(Turn(0) + twice + Turn(2) + Turn(3), report)) == std::vector<int>{0, 2});
  CHECK(report.counts["bad_turn"] == 2);
}

TEST_CASE("a motor that stands still makes no turns and takes no memory") {
  DeviceReport report;
  RplidarSamples samples(report, 500);
  std::vector<DeviceScan> scans;
  std::string still;
  for (int i = 0; i < 1000; ++i) still += Sample(false, 90.0, 500);
  for (int i = 0; i < 100; ++i) samples.Take(still, scans);
  CHECK(scans.empty());
}

TEST_CASE("an RPLidar is asked in order: its motor turns while it scans, and is checked for faults before") {
  unsigned char health = 0;
  const auto Answer = [&health](const std::string& request) {
    if (request == "\xA5\x50")
      return std::string("\xA5\x5A\x14\x00\x00\x00\x04\x18\x1d\x01", 10) + std::string(17, '\1');
    if (request == "\xA5\x52")
      return std::string("\xA5\x5A\x03\x00\x00\x00\x06", 7) + static_cast<char>(health) + "\5\1";
    if (request == "\xA5\x59") return std::string("\xA5\x5A\x04\x00\x00\x00\x15\xfc\x01\x00\x01", 11);
    if (request == "\xA5\x20") return std::string("\xA5\x5A\x05\x00\x00\x40\x81", 7) + Turn(0);
    return std::string();
  };
  FakeConnection connection(Answer);
  DeviceReport report;
  const auto laser = MakeRplidar(report);
  CHECK(laser->Start(connection) == "RPLIDAR of series 1, firmware 1.29: 360 deg, 1969 beams a second");
  CHECK(connection.requests().front() == "\xA5\x25");
  CHECK_FALSE(connection.ready());  // the motor of an A1 turns then
  std::vector<DeviceScan> scans;
  laser->Take(Turn(1), scans);  // behind what came with the answer
  CHECK(TurnsOf(scans) == std::vector<int>{0});
  laser->Stop(connection);
  CHECK(connection.ready());

  health = 1;
  MakeRplidar(report)->Start(connection);
  CHECK(report.complaints.back() == "warns of a coming fault, error code 261");
  health = 2;
  CHECK_THROWS_AS(MakeRplidar(report)->Start(connection), DeviceError);
}

}  // namespace crsm
