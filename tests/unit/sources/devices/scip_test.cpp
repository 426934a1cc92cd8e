#include "services/sources/devices/scip.hpp"

#include "catch.hpp"
#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

/// A laser of five steps, 90 degrees apart, that looks along the middle one; 3 of its steps are those it measures at.
ScipParameters SmallLaser() {
  ScipParameters parameters;
  parameters.range_min_mm = 20;
  parameters.range_max_mm = 5600;
  parameters.steps_per_turn = 4;
  parameters.first_step = 1;
  parameters.last_step = 3;
  parameters.front_step = 2;
  parameters.turns_per_min = 600;
  return parameters;
}

/// Three ranges: "1Dh", 5432 mm of the document's example; "00?", the error code 15; "0CB", 1234 mm. The stamp is the
/// document's 16,000,000 ms. The checksums: 0x6d + 0x32 + 0x40 + 0x30 = 0x10f, of which 0xf and 0x30 are "?", and so
/// on.
const std::string kScan = "MD0001000301000\n99b\nm2@0?\n1Dh00?0CBa\n\n";

std::vector<ScipReply> Read(const std::string& bytes, DeviceReport& report) {
  ScipReader reader(report);
  reader.ExpectScans("MD0001000301000");
  return reader.Take(bytes);
}

}  // namespace

TEST_CASE("the document's examples of two, three and four letters are the numbers that it says") {
  CHECK(DecodeScipNumber("CB") == 1234);
  CHECK(DecodeScipNumber("1Dh") == 5432);
  CHECK(DecodeScipNumber("m2@0") == 16000000);
  CHECK(DecodeScipNumber("") == 0);
  CHECK_FALSE(DecodeScipNumber("1/h"));
  CHECK_FALSE(DecodeScipNumber("1ph"));
  CHECK_FALSE(
      DecodeScipNumber("1\xff"
                       "h"));
}

TEST_CASE("the parameters of the document's URG-04LX are read, with its checksums") {
  // As the document prints them, but for the model and ARES, whose checksums are misprinted there.
  const std::string answer =
      "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co., Ltd.);n\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\nAMIN:44;7\n"
      "AMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";
  DeviceReport report;
  const auto replies = Read(answer, report);
  REQUIRE(replies.size() == 1);
  const auto parameters = ParseScipParameters(replies[0]);
  REQUIRE(parameters);
  CHECK(parameters->model == "URG-04LX(Hokuyo Automatic Co., Ltd.)");
  CHECK(parameters->range_min_mm == 20);
  CHECK(parameters->range_max_mm == 5600);
  CHECK(parameters->steps_per_turn == 1024);
  CHECK(parameters->first_step == 44);
  CHECK(parameters->last_step == 725);
  CHECK(parameters->front_step == 384);
  CHECK(parameters->turns_per_min == 600);
  CHECK(report.counts.empty());
}

TEST_CASE("parameters that cannot be true, or are not there, are none") {
  const auto Parse = [](const std::string& key, const std::string& value) {
    ScipReply reply{
        "PP", "00", {"MODL:X", "DMIN:20", "DMAX:5600", "ARES:1024", "AMIN:44", "AMAX:725", "AFRT:384", "SCAN:600"}};
    for (std::string& line : reply.lines) {
      if (line.starts_with(key)) line = value.empty() ? "" : key + ":" + value;
    }
    return ParseScipParameters(reply).has_value();
  };
  CHECK(Parse("none", "of them"));
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"DMIN", ""},   {"DMIN", "-1"},   {"DMAX", "20"}, {"ARES", "0"},     {"ARES", "500"},
      {"AMAX", "44"}, {"AMAX", "9999"}, {"SCAN", "0"},  {"AFRT", "front"}, {"AMIN", "99999999999"}};
  for (const auto& [key, value] : wrong) {
    CAPTURE(key, value);
    CHECK_FALSE(Parse(key, value));
  }
}

TEST_CASE("a scan is what its letters say: ranges in metres, error codes no return, angles from the front step") {
  DeviceReport report;
  const auto replies = Read(kScan, report);
  REQUIRE(replies.size() == 1);
  const auto scan = ParseScipScan(replies[0], SmallLaser());
  REQUIRE(scan);
  CHECK(scan->scan.ranges_m == std::vector<float>{5.432f, 0.0f, 1.234f});
  CHECK(scan->scan.angle_min_rad == Approx(-kPi / 2));
  CHECK(scan->scan.angle_step_rad == Approx(kPi / 2));
  CHECK(scan->turn_s == Approx(0.1));
  CHECK(scan->device_us == 16'000'000'000 + 75'000);  // step 3 of 4 is three quarters of a turn behind step 0
}

TEST_CASE("a scan comes whole however its bytes are cut, and values may go over the end of a line") {
  DeviceReport report;
  ScipReader reader(report);
  std::vector<ScipReply> replies;
  const std::string two_lines = "MD0001000301000\n99b\nm2@0?\n1Dh00O\n?0CBV\n\n";
  for (const char byte : kScan + two_lines) {
    for (ScipReply& reply : reader.Take({&byte, 1})) replies.push_back(std::move(reply));
  }
  REQUIRE(replies.size() == 1);  // the checksums of the second were not added up: it is damaged
  CHECK(report.counts["bad_checksum"] == 1);
  ScipReply broken = replies[0];
  broken.lines = {"m2@0", "1Dh00", "?0CB"};
  CHECK(ParseScipScan(broken, SmallLaser())->scan == ParseScipScan(replies[0], SmallLaser())->scan);
}

TEST_CASE("every single byte that comes as another damages one scan, and the one behind it comes") {
  for (std::size_t at = 0; at < kScan.size(); ++at) {
    for (const char wrong : {'\n', '\x00', '~', '1'}) {
      if (kScan[at] == wrong) continue;
      std::string damaged = kScan;
      damaged[at] = wrong;
      DeviceReport report;
      const auto replies = Read(kScan + damaged + kScan, report);
      CAPTURE(at, wrong);
      std::size_t num_right = 0;
      for (const ScipReply& reply : replies) {
        if (reply.command != "MD0001000301000" || reply.status != "99") continue;
        const auto scan = ParseScipScan(reply, SmallLaser());
        if (!scan) continue;
        ++num_right;
        CHECK(scan->scan.ranges_m == std::vector<float>{5.432f, 0.0f, 1.234f});
      }
      CHECK(num_right >= 2);
    }
  }
}

TEST_CASE("noise in the place of a scan, without the end of any line, costs no other") {
  for (const std::size_t size : {1u, 63u, 255u, 256u, 257u, 5000u}) {
    CAPTURE(size);
    DeviceReport report;
    CHECK(Read(kScan + std::string(size, '\0') + kScan, report).size() == 2);
  }
}

TEST_CASE("garbage without end is no answer, and takes no memory") {
  DeviceReport report;
  ScipReader reader(report);
  for (int i = 0; i < 100; ++i) CHECK(reader.Take(std::string(100'000, 'x')).empty());
  for (int i = 0; i < 10'000; ++i) CHECK(reader.Take("x\n").empty());
  CHECK(reader.Take("\n\n" + kScan).size() == 1);
  CHECK(report.counts["bad_checksum"] == 1);
}

}  // namespace crsm
