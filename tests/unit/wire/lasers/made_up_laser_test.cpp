// A laser that nobody has, known by this file alone: no other names it, and no log, process or list had to change.

#include "catch.hpp"
#include "lcm_events.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/laser_types.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

constexpr std::uint64_t kFingerprint = 0x0123456789abcdef;
constexpr std::size_t kMessageBytes = 8 + 2;

/// Its message: behind the fingerprint a byte for the utime, and a byte for the one range of all its beams [m].
std::optional<LaserReading> DecodeMadeUp(std::span<const std::uint8_t> bytes, const LaserMessageOptions&) {
  if (bytes.size() != kMessageBytes) return std::nullopt;
  return LaserReading{{bytes[8], 0.0f, 0.5f, std::vector<float>(3, bytes[9])}};
}

[[maybe_unused]] const bool kRegistered = RegisterLaserType(kFingerprint, {"made_up.ring_t", &DecodeMadeUp});

}  // namespace

TEST_CASE("a laser's type that registers itself is read from a log, and named where a log has no laser") {
  const auto event = [](std::uint64_t utime, std::uint64_t range_m) {
    return Event("RING", BigEndian(kFingerprint, 8) + BigEndian(utime, 1) + BigEndian(range_m, 1));
  };
  const ScratchFile log(event(7, 2) + Event("RING", BigEndian(kFingerprint, 8)) + event(9, 3));
  const auto source = OpenLaserSource(log.path(), {});
  const std::vector<LaserScan> expected{{7, 0.0f, 0.5f, {2.0f, 2.0f, 2.0f}}, {9, 0.0f, 0.5f, {3.0f, 3.0f, 3.0f}}};
  CHECK(ReadAll(*source) == expected);
  CHECK(source->Counts().at("bad_message") == 1);

  CHECK(LaserTypeNames().find("bot_core.planar_lidar_t, ") != std::string::npos);
  CHECK(LaserTypeNames().find(", made_up.ring_t") != std::string::npos);
}

TEST_CASE("a message is a laser's by its fingerprint, and two types cannot have the same") {
  const std::vector<std::uint8_t> ring{0x01, 0x23, 0x45, 0x67, 0x89, 0xab, 0xcd, 0xef};
  const std::span<const std::uint8_t> bytes(ring);
  REQUIRE(FindLaserType(bytes));
  CHECK(FindLaserType(bytes)->name == "made_up.ring_t");
  CHECK(FindLaserType(bytes.subspan(1)) == nullptr);
  CHECK(FindLaserType({}) == nullptr);
  CHECK_THROWS_AS(RegisterLaserType(kFingerprint, {"made_up.other_t", &DecodeMadeUp}), std::logic_error);
}

}  // namespace crsm
