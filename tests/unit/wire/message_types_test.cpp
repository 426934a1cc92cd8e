#include "services/wire/message_types.hpp"

#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>

#include "catch.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

/// What is said of a scan with one thing wrong.
template <class Change>
std::string Describe(Change change) {
  bot_core::planar_lidar_t scan = LidarMessage();
  change(scan);
  return DescribeRefusedLaser(Encode(scan));
}

bool Says(const std::string& text, const std::string& expected) {
  CAPTURE(text);
  return text.find(expected) != std::string::npos && text.find('\n') == std::string::npos;
}

}  // namespace

TEST_CASE("types are known by their fingerprints, others are said in hexadecimal") {
  const auto Name = [](std::int64_t fingerprint) { return NameOfType(static_cast<std::uint64_t>(fingerprint)); };
  CHECK(Name(bot_core::planar_lidar_t::getHash()) == "bot_core.planar_lidar_t");
  CHECK(NameOfType(0xe3d17423180b5e8d) == "bot_core.planar_lidar_t");  // as libbot2 has it
  CHECK(Name(bot_core::pose_t::getHash()) == "bot_core.pose_t");
  CHECK(Name(botlab::lidar_t::getHash()) == "botlab.lidar_t");
  CHECK(Name(botlab::lidar_nranges_t::getHash()) == "botlab.lidar_t");
  CHECK(Name(scan_match_t::getHash()) == "crsm.scan_match_t");
  CHECK(Name(keyframe_t::getHash()) == "crsm.keyframe_t");
  CHECK(Name(keyframe_request_t::getHash()) == "crsm.keyframe_request_t");
  CHECK(Name(pose_graph_t::getHash()) == "crsm.pose_graph_t");
  CHECK(NameOfType(0x0011223344556677) == "a type with fingerprint 0x0011223344556677");
  CHECK(NameOfType(0) == "a type with fingerprint 0x0000000000000000");
}

TEST_CASE("a message of another type is named, and the right type with it") {
  const std::string text = DescribeRefusedLaser(Encode(PoseMessage()));
  CHECK(Says(text, "messages are bot_core.pose_t"));
  CHECK(Says(text, "bot_core.planar_lidar_t, "));
  CHECK(Says(DescribeRefusedLaser({}), "too short"));
}

TEST_CASE("angles in degrees are recognised, be it by the first one or by the whole sweep") {
  const auto kDegrees = "look like degrees";
  CHECK(Says(Describe([](auto& scan) { scan.rad0 = -90.0f, scan.radstep = 1.0f; }), kDegrees));
  CHECK(Says(Describe([](auto& scan) { scan.rad0 = 0.0f, scan.radstep = 120.0f; }), kDegrees));
  CHECK(Says(Describe([](auto& scan) { scan.rad0 = 180.0f, scan.radstep = -120.0f; }), "divide by 57.2958"));
  CHECK_FALSE(Says(Describe([](auto& scan) { scan.rad0 = 1e9f; }), kDegrees));
  CHECK_FALSE(Says(Describe([](auto& scan) { scan.radstep = std::numeric_limits<float>::quiet_NaN(); }), kDegrees));
}

TEST_CASE("every other reason to refuse a scan is said by the name of its field") {
  CHECK(Says(Describe([](auto& scan) { scan.utime = -5; }), "utime is below 0 (-5)"));
  CHECK(Says(Describe([](auto& scan) { scan.radstep = 0.0f; }), "radstep 0"));
  CHECK(Says(Describe([](auto& scan) { scan.rad0 = std::numeric_limits<float>::infinity(); }), "rad0 is inf"));
  CHECK(Says(Describe([](auto& scan) { scan.nranges = 1, scan.ranges = {1.0f}, scan.nintensities = 0; }), "1 rays"));
  CHECK(Says(Describe([](auto& scan) { scan.nintensities = 1; }), "3 ranges and 1 intensities"));
  std::vector<std::uint8_t> cut = Encode(LidarMessage());
  cut.pop_back();
  CHECK(Says(DescribeRefusedLaser(cut), "are cut"));
}

}  // namespace crsm
