#include "services/sources/devices/cola.hpp"

#include "catch.hpp"
#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

/// A telegram of an LMS1xx, its words in the listing's order, with five beams of 0.5 deg from -45 deg on.
std::string Telegram(const std::string& status = "0", const std::string& number = "286B",
                     const std::string& data = "DIST1 3F800000 00000000 FFF92230 1388 5 112 F 0 10 FFFF") {
  return "sSN LMDscandata 1 1 D6FF21 0 " + status + " " + number + " 3C84 EE4D4845 EE4DA2ED 0 0 7 0 0 1388 168 0 1 " +
         data + " 0 0 0 0 0 0";
}

}  // namespace

TEST_CASE("a telegram is what its words say: mm, 1/10000 deg from the right, codes below 16 no return") {
  const auto scan = ParseColaScan(Telegram());
  REQUIRE(scan);
  CHECK(scan->scan.scan.angle_min_rad == Approx(-135.0 * kPi / 180.0));
  CHECK(scan->scan.scan.angle_step_rad == Approx(0.5 * kPi / 180.0));
  CHECK(scan->scan.scan.ranges_m == std::vector<float>{0.274f, 0.0f, 0.0f, 0.016f, 65.535f});
  CHECK(scan->scan.device_us == 0xEE4D4845);
  CHECK(scan->scan.turn_s == Approx(0.02));  // 50 Hz
  CHECK(scan->status == 0);
  CHECK(scan->telegram_number == 0x286B);
}

TEST_CASE("the scale of the ranges, other channels before them and encoders are taken into account") {
  const auto doubled = ParseColaScan(Telegram("0", "1", "DIST1 40000000 00000000 FFF92230 1388 2 3E8 7D0"));
  REQUIRE(doubled);
  CHECK(doubled->scan.scan.ranges_m == std::vector<float>{2.0f, 4.0f});
  const auto behind =
      ParseColaScan(Telegram("0", "1", "RSSI1 3F800000 0 0 1388 2 1 2 DIST1 3F800000 0 0 1388 2 3E8 7D0"));
  REQUIRE(behind);
  CHECK(behind->scan.scan.ranges_m == std::vector<float>{1.0f, 2.0f});
  std::string encoder = Telegram();
  encoder.replace(encoder.find("168 0 1"), 7, "168 1 77 5 1");
  CHECK(ParseColaScan(encoder));
}

TEST_CASE("telegrams that end early, or whose words are no numbers or cannot be, are none") {
  const std::string good = Telegram();
  const std::size_t end = good.find(" FFFF");
  for (std::size_t size = 0; size <= end; ++size) CHECK_FALSE(ParseColaScan(good.substr(0, size)));
  for (const char* data :
       {"DIST1 3F800000 00000000 FFF92230 1388 5 112 xyz 0 10 20", "DIST1 3F800000 0 FFF92230 0 2 112 113",
        "DIST1 3F800000 0 FFF92230 1388 1 112", "DIST1 3F800000 0 FFF92230 1388 FFFFFFFF 112",
        "DIST1 7FC00000 0 FFF92230 1388 2 112 113", "DIST1 3F800000 7FC00000 FFF92230 1388 2 112 113",
        "DIST1 3F800000 0 7FFFFFFF 1388 2 112 113", "DIST1 3F800000 0 0 1388 2 112 10000",
        "DIST1 3F800000 0 0 FFFFFFFF 2 112 113", "RSSI1 3F800000 0 0 1388 2 112 113"}) {
    CAPTURE(data);
    CHECK_FALSE(ParseColaScan(Telegram("0", "1", data)));
  }
}

TEST_CASE("telegrams come whole however their bytes are cut, and garbage between them is counted once a place") {
  DeviceReport report;
  ColaReader reader(report);
  std::vector<std::string> telegrams;
  const std::string bytes = "xyz" + ColaTelegram("one") + "\x02lost" + ColaTelegram("two") + "\x03" + ColaTelegram("");
  for (const char byte : bytes) {
    for (std::string& telegram : reader.Take({&byte, 1})) telegrams.push_back(std::move(telegram));
  }
  CHECK(telegrams == std::vector<std::string>{"one", "two", ""});
  CHECK(report.counts["garbage"] == 3);
}

TEST_CASE("a telegram without end is garbage, and takes no memory") {
  DeviceReport report;
  ColaReader reader(report);
  for (int i = 0; i < 100; ++i) CHECK(reader.Take("\x02" + std::string(100'000, '1')).empty());
  CHECK(reader.Take(ColaTelegram("good")) == std::vector<std::string>{"good"});
}

}  // namespace crsm
