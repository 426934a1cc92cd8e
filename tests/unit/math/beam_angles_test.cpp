#include "common/math/beam_angles.hpp"

#include "catch.hpp"

namespace crsm {

TEST_CASE("an angle that is looked up has the sine and cosine that are computed, the first time and again") {
  // More angles than are kept, twice: those that were pushed out are computed anew.
  for (int round = 0; round < 2; ++round) {
    for (int i = -1000; i <= 1000; ++i) {
      const double angle_rad = 0.001 * i;
      const SinCos computed = ComputeSinCos(angle_rad);
      const SinCos found = LookUpSinCos(angle_rad);
      REQUIRE(found.sin == computed.sin);
      REQUIRE(found.cos == computed.cos);
      REQUIRE(LookUpSinCos(angle_rad).sin == computed.sin);
    }
  }
}

}  // namespace crsm
