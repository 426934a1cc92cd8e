#include "common/scan/packed_rays.hpp"

#include "catch.hpp"

using namespace crsm;

namespace {

/// Beams half a degree apart, but for every `left_out`th, that read whole millimetres, or not.
ValidRays MakeRays(int num_beams, int left_out, double unit_m = 0.001, float turned_rad = 0.0f) {
  ValidRays rays;
  for (int i = 0; i < num_beams; ++i) {
    if (i % left_out == 0) continue;
    rays.angle_rad.push_back(turned_rad - 1.5f + static_cast<float>(i) * 0.0087f);
    rays.range_m.push_back(static_cast<float>((1000 + 7 * i) * unit_m));
  }
  return rays;
}

}  // namespace

TEST_CASE("packed rays are exact, whatever their unit, and have no times") {
  for (const double unit_m : {0.001, 0.00025, 0.123456, 1.0}) {
    ValidRays rays = MakeRays(361, 5, unit_m);
    CAPTURE(unit_m);
    CHECK(PackedRays(rays).Unpack() == rays);
    CHECK(PackedRays(rays).size() == rays.size());
    CHECK(PackedRays(rays) == PackedRays(rays));
    rays.range_m[7] = 3.14159f;
    CHECK(PackedRays(rays).Unpack() == rays);
    ValidRays with_times = rays;
    with_times.time_s.assign(rays.size(), 0.1f);
    CHECK(PackedRays(with_times).Unpack() == rays);
  }
  CHECK(PackedRays(ValidRays()).Unpack() == ValidRays());
  CHECK(PackedRays().size() == 0);
  CHECK_FALSE(PackedRays(MakeRays(361, 5)) == PackedRays(MakeRays(361, 6)));
}

TEST_CASE("scans of a laser share the angles of its beams, and take a third of the memory") {
  PackedRays before = MakeRays(361, 5);
  for (int left_out = 6; left_out < 20; ++left_out) {
    const ValidRays rays = MakeRays(361, left_out);
    PackedRays packed = rays;
    packed.ShareAngles(before);
    CHECK(packed.Unpack() == rays);
    before = packed;
  }
  PackedRays last = MakeRays(361, 7);
  last.ShareAngles(before);
  CHECK(3 * last.num_bytes() < sizeof(ValidRays) + 2 * last.size() * sizeof(float));
}

TEST_CASE("a scan whose angles are shared already, and are those of another one and more, keeps them") {
  const PackedRays first = MakeRays(361, 5);
  PackedRays second = MakeRays(361, 6);
  second.ShareAngles(first);  // now with all 361
  PackedRays copy = second;
  copy.ShareAngles(PackedRays(MakeRays(361, 5)));
  PackedRays third = MakeRays(361, 6);
  third.ShareAngles(copy);
  CHECK(second.num_bytes() < 361 * sizeof(float));  // as it shares its angles with the third one
}

TEST_CASE("scans whose angles are others, or do not rise, keep their own") {
  const PackedRays before = MakeRays(361, 5);
  const ValidRays turned = MakeRays(361, 5, 0.001, 0.001f);
  ValidRays falling = MakeRays(361, 5);
  std::swap(falling.angle_rad[3], falling.angle_rad[4]);
  ValidRays twice = MakeRays(361, 5);
  twice.angle_rad[3] = twice.angle_rad[4];
  for (const ValidRays& rays : {turned, falling, twice, ValidRays()}) {
    PackedRays packed = rays;
    packed.ShareAngles(before);
    CHECK(packed.Unpack() == rays);
    PackedRays next = MakeRays(361, 5);
    next.ShareAngles(packed);
    CHECK(next == before);
  }
}
