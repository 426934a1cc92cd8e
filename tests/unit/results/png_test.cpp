#include "common/results/png.hpp"

#include <cstdint>
#include <stdexcept>

#include "catch.hpp"

namespace crsm {

// That a PNG holds what it is meant to is tested with a decoder of another make in results_test.cpp.
TEST_CASE("a picture that cannot be a PNG file is an error, no crash") {
  const std::uint8_t one = 0;
  CHECK_THROWS_AS(EncodePng({0, 1, 1, &one}), std::runtime_error);
  CHECK_THROWS_AS(EncodePng({1, -1, 1, &one}), std::runtime_error);
}

}  // namespace crsm
