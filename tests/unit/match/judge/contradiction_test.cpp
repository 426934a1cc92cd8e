#include "common/match/judge/contradiction.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

/// Free from x = 0 to 4 m, a wall at x = 4 m, unexplored beyond.
ByteMap MakeMap() {
  ByteMap map(0.05);
  for (int x = 0; x <= 80; ++x) {
    for (int y = -40; y <= 40; ++y) map.Set({x, y}, x == 80 ? 0 : 255);
  }
  return map;
}

double ContradictionOf(double x_m, double y_m) {
  return ComputeContradiction(MakeMap(), Eigen::Vector2d(x_m, y_m), {1.0, 0.0, 0.0});
}

}  // namespace

TEST_CASE("a ray contradicts the map that ends where nothing stands, or passes through a wall of two cells") {
  CHECK(ContradictionOf(3.0, 0.0) == 0.0);   // to the wall
  CHECK(ContradictionOf(2.9, 0.0) == 0.0);   // nearly
  CHECK(ContradictionOf(2.0, 0.0) == 1.0);   // before it
  CHECK(ContradictionOf(3.1, 0.0) == 0.0);   // just behind it
  CHECK(ContradictionOf(-3.0, 0.0) == 0.0);  // into the unexplored
  ByteMap thick = MakeMap();
  for (int y = -40; y <= 40; ++y) thick.Set({81, y}, 0);
  const Eigen::Vector2d far(5.0, 0.1);
  CHECK(ComputeContradiction(thick, far, {1.0, 0.0, 0.0}) == 1.0);
  CHECK(ComputeContradiction(MakeMap(), far, {1.0, 0.0, 0.0}) == 0.0);  // a single cell may be an error of drawing
}

TEST_CASE("the share of rays that contradict is given, in the frame of the map") {
  Eigen::Matrix2Xd hits_m(2, 4);
  hits_m << 0.0, 0.0, 0.5, 1.0, -3.0, -2.0, -1.0, -1.0;
  CHECK(ComputeContradiction(MakeMap(), hits_m, {1.0, 0.0, kPi / 2.0}) == Approx(0.75));
  CHECK(ComputeContradiction(MakeMap(), Eigen::Matrix2Xd(2, 0), {}) == 0.0);
  CHECK(ComputeContradiction(ByteMap(0.05), hits_m, {}) == 0.0);
}

}  // namespace crsm
