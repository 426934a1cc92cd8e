#include "common/scan/surface.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr double kNearM = 0.1;
constexpr double kMaxM = 0.8;

Eigen::Matrix2Xd Hits(const std::vector<Eigen::Vector2d>& points_m) {
  Eigen::Matrix2Xd hits_m(2, static_cast<Eigen::Index>(points_m.size()));
  Eigen::Index column = 0;
  for (const auto& point_m : points_m) hits_m.col(column++) = point_m;
  return hits_m;
}

std::vector<bool> FindSurfaces(const Eigen::Matrix2Xd& hits_m, double near_m, double max_m,
                               const SurfaceConstants& constants = {}) {
  return Gaps(hits_m, constants).FindSurfaces(near_m, max_m);
}

}  // namespace

TEST_CASE("two hits are joined if they are near, whatever lies around them; fewer have no neighbours") {
  CHECK(FindSurfaces(Hits({}), kNearM, kMaxM).empty());
  CHECK(FindSurfaces(Hits({{1.0, 0.0}}), kNearM, kMaxM).empty());
  CHECK(FindSurfaces(Hits({{1.0, 0.0}, {1.0, 0.09}}), kNearM, kMaxM) == std::vector<bool>{true});
  CHECK(FindSurfaces(Hits({{1.0, 0.0}, {1.0, 0.11}}), kNearM, kMaxM) == std::vector<bool>{false});
}

TEST_CASE("a wall seen at a grazing angle is one surface up to the largest gap") {
  // The wall y = 1 m, hit by a beam every degree: its hits are 1 / sin^2(angle) degrees apart.
  Eigen::Matrix2Xd hits_m(2, 20);
  for (int i = 0; i < 20; ++i) hits_m.col(i) << 1.0 / std::tan((25 - i) * 3.14159265 / 180.0), 1.0;
  const auto joined = FindSurfaces(hits_m, kNearM, kMaxM);
  REQUIRE(joined.size() == 19);
  for (int i = 0; i < 19; ++i) {
    CAPTURE(i);
    CHECK(joined[static_cast<std::size_t>(i)] == (hits_m(0, i + 1) - hits_m(0, i) <= kMaxM));
  }
  CHECK(joined.front());
  CHECK_FALSE(joined.back());
}

TEST_CASE("a way within 5 degrees of the beam lies along it, in both directions") {
  const Eigen::Vector2d near_m(1.0, 0.0);
  CHECK(IsAlongBeam(near_m, {2.0, 0.0}));
  CHECK(IsAlongBeam(near_m, {2.0, 0.15}));
  CHECK(IsAlongBeam({2.0, 0.15}, near_m));
  CHECK_FALSE(IsAlongBeam(near_m, {2.0, 0.2}));
  CHECK_FALSE(IsAlongBeam(near_m, {1.0, 0.5}));
}

TEST_CASE("hits are joined along walls and round corners, and across no edge") {
  struct Case {
    const char* seen;
    std::vector<Eigen::Vector2d> hits_m;
    std::vector<bool> joined;
    double near_m = kNearM;
  };
  for (const Case& tested :
       {Case{"a cupboard's front, then the wall 0.6 m behind it",
             {{1.0, 0.0}, {1.0, 0.05}, {1.0, 0.1}, {1.6, 0.2}, {1.6, 0.28}, {1.6, 0.36}},
             {true, true, false, true, true}},
        {"a lone hit between two surfaces",
         {{1.0, 0.0}, {1.0, 0.05}, {1.4, 0.06}, {1.6, 0.5}, {1.6, 0.58}},
         {true, false, false, true}},
        {"a corner; the first hits are 0.2 m apart, and the next turns away by 27 degrees",
         {{1.0, 0.7}, {1.0, 0.9}, {0.95, 1.0}, {0.75, 1.0}, {0.55, 1.0}},
         {false, true, true, true},
         0.12},
        {"two hits in one place, which point to none", {{1.0, 0.0}, {1.0, 0.0}, {1.0, 0.5}}, {true, false}}}) {
    CAPTURE(tested.seen);
    CHECK(FindSurfaces(Hits(tested.hits_m), tested.near_m, kMaxM) == tested.joined);
  }
}

TEST_CASE("hits that are far apart go on where the line of the others points, within 15 degrees") {
  for (const double side : {1.0, -1.0}) {
    const auto Bent = [&](double angle_deg) {  // 0.09 m along x, then 0.18 m
      const double angle_rad = side * angle_deg * 3.14159265 / 180.0;
      return Hits({{1.0, 0.0}, {1.09, 0.0}, {1.09 + 0.18 * std::cos(angle_rad), 0.18 * std::sin(angle_rad)}});
    };
    CHECK(FindSurfaces(Bent(14.5), kNearM, kMaxM)[1]);
    CHECK_FALSE(FindSurfaces(Bent(15.5), kNearM, kMaxM)[1]);
    CHECK_FALSE(FindSurfaces(Bent(180.0), kNearM, kMaxM)[1]);  // nor where they turn back
  }
}

TEST_CASE("a door that stands back is not joined to its wall, however far apart the hits are") {
  // Hits on a wall 0.6 m apart, then on a door: that it stands back by 0.1 m is a bend of less than 10 degrees.
  const auto JoinedTo = [](double back_m) {
    return FindSurfaces(
        Hits({{2.4, 1.0}, {3.0, 1.0}, {3.6, 1.0}, {4.2, 1.0 + back_m}, {4.8, 1.0 + back_m}, {5.4, 1.0 + back_m}}),
        kNearM, kMaxM);
  };
  for (const double side : {1.0, -1.0}) {
    CHECK(JoinedTo(side * 0.04) == std::vector<bool>{true, true, true, true, true});
    CHECK(JoinedTo(side * 0.06) == std::vector<bool>{true, true, false, true, true});
  }
}

TEST_CASE("hits are of one line up to three times as far apart as the ones before or after") {
  const auto Joined = [](double gap_m, double next_gap_m) {
    return FindSurfaces(Hits({{1.0, 0.0}, {1.0, gap_m}, {1.0, gap_m + next_gap_m}}), kNearM, kMaxM);
  };
  CHECK(Joined(0.09, 0.26) == std::vector<bool>{true, true});
  CHECK(Joined(0.09, 0.28) == std::vector<bool>{true, false});
  CHECK(Joined(0.26, 0.09) == std::vector<bool>{true, true});
  CHECK(Joined(0.28, 0.09) == std::vector<bool>{false, true});
  CHECK(Joined(0.2, 0.59) == std::vector<bool>{true, true});
  CHECK(Joined(0.2, 0.61) == std::vector<bool>{false, false});
}

TEST_CASE("the laser itself is on no surface: the first two hits, in line with it, are joined by none before them") {
  // Of several lengths, because what stands before the first hit in memory may be anything, also the laser's place.
  for (int num_hits = 2; num_hits <= 40; ++num_hits) {
    Eigen::Matrix2Xd hits_m(2, num_hits);
    for (int i = 0; i < num_hits; ++i) hits_m.col(i) << 0.0, 2.0 * i;
    hits_m.col(0) << 0.5, 0.0;
    hits_m.col(1) << 1.0, 0.0;
    CHECK_FALSE(FindSurfaces(hits_m, kNearM, kMaxM).front());
  }
}

}  // namespace crsm
