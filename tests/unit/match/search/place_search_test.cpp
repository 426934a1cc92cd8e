#include "common/match/search/place_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "catch.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

constexpr double kCell_m = 0.05;
constexpr double kFarthest_m = 5.0;
constexpr PlaceTerms kTerms{kFarthest_m, 0.5, 0.9, 1'000'000};

using Points = std::vector<Eigen::Vector2d>;

Eigen::Matrix2Xd ToMatrix(const Points& points) {
  Eigen::Matrix2Xd matrix(2, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) matrix.col(static_cast<Eigen::Index>(i)) = points[i];
  return matrix;
}

void AddWall(Points& points, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const int steps = static_cast<int>((to - from).norm() / 0.04);
  for (int i = 0; i <= steps; ++i) points.push_back(from + (to - from) * i / steps);
}

/// A room of about 7 m x 5 m with some pieces of furniture, of which no two are alike.
Points MakeRoom(std::uint64_t seed, const Eigen::Vector2d& middle = {0.0, 0.0}) {
  Random random(seed);
  const double w_m = random.Uniform(3.0, 3.6);
  const double h_m = random.Uniform(2.2, 2.8);
  Points room;
  AddWall(room, {-w_m, -h_m}, {w_m, -h_m});
  AddWall(room, {w_m, -h_m}, {w_m, h_m});
  AddWall(room, {w_m, h_m}, {-w_m, h_m});
  AddWall(room, {-w_m, h_m}, {-w_m, -h_m});
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector2d corner(random.Uniform(-2.5, 1.5), random.Uniform(-2.0, 1.5));
    const double angle_rad = random.Uniform(0.0, 1.5);
    const Eigen::Vector2d side(std::cos(angle_rad), std::sin(angle_rad));
    AddWall(room, corner, corner + random.Uniform(0.4, 1.2) * side);
    AddWall(room, corner, corner + random.Uniform(0.4, 1.2) * Eigen::Vector2d(-side.y(), side.x()));
  }
  for (Eigen::Vector2d& point : room) point += middle;
  return room;
}

/// What of some hits is seen from a pose: every second of those nearer than kFarthest_m, and as many points that are
/// nowhere as a tenth of them.
Eigen::Matrix2Xd SeeFrom(const Pose2& T_map_laser, const Points& hits, std::uint64_t seed) {
  Random random(seed, 7);
  const Pose2 T_laser_map = Inverse(T_map_laser);
  const auto [sin, cos] = ComputeSinCos(T_laser_map.yaw_rad);
  Points seen;
  for (std::size_t i = 0; i < hits.size(); i += 2) {
    const Eigen::Vector2d at(T_laser_map.x_m + cos * hits[i].x() - sin * hits[i].y(),
                             T_laser_map.y_m + sin * hits[i].x() + cos * hits[i].y());
    if (at.norm() < kFarthest_m) seen.push_back(at);
    if (i % 20 == 0) seen.push_back({random.Uniform(-3.0, 3.0), random.Uniform(-3.0, 3.0)});
  }
  return ToMatrix(seen);
}

/// A slower count of the points that lie on hits, give or take a cell: a set of cells, and nothing of the pyramid but
/// where its grid begins, two cells below the lowest hit.
class SlowMap {
 public:
  explicit SlowMap(const Eigen::Matrix2Xd& hits_m) : origin_m_(hits_m.rowwise().minCoeff().array() - 2.0 * kCell_m) {
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
      const Eigen::Vector2d cell = (hits_m.col(i) - origin_m_) / kCell_m;
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          cells_.insert({static_cast<int>(std::floor(cell.x())) + x, static_cast<int>(std::floor(cell.y())) + y});
        }
      }
    }
  }

  int Count(const Eigen::Matrix2Xd& points_m, const Pose2& pose) const {
    const auto [sin, cos] = ComputeSinCos(pose.yaw_rad);
    int count = 0;
    for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
      const double x_m = pose.x_m + cos * points_m(0, i) - sin * points_m(1, i) - origin_m_.x();
      const double y_m = pose.y_m + sin * points_m(0, i) + cos * points_m(1, i) - origin_m_.y();
      count += static_cast<int>(
          cells_.count({static_cast<int>(std::floor(x_m / kCell_m)), static_cast<int>(std::floor(y_m / kCell_m))}));
    }
    return count;
  }

 private:
  Eigen::Vector2d origin_m_;
  std::set<std::pair<int, int>> cells_;
};

/// A room, and what is seen of it from a pose.
struct Sight {
  Sight(std::uint64_t seed, const Pose2& T_map_laser)
      : room(MakeRoom(seed)),
        pyramid(ToMatrix(room), kCell_m),
        points_m(SeeFrom(T_map_laser, room, seed)),
        x_cells((points_m.row(0).array() / kCell_m).cast<float>()),
        y_cells((points_m.row(1).array() / kCell_m).cast<float>()) {}

  std::array<int, 4> Count(int level, const Pose2& pose, int least = 0) const {
    return pyramid.Count(level, x_cells, y_cells, pose, least);
  }

  Points room;
  HitPyramid pyramid;
  Eigen::Matrix2Xd points_m;
  Eigen::ArrayXf x_cells, y_cells;
};

}  // namespace

TEST_CASE("the place that is found is the best that looking everywhere finds") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    Random random(seed, 3);
    const Pose2 truth{random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3), random.Uniform(-0.03, 0.03)};
    const Sight sight(seed, truth);
    const PlaceWindow window{{0.01, 0.02, 0.003}, 0.4, 0.04};
    const Place place = FindPlace(sight.pyramid, sight.points_m, window, kTerms);

    const SlowMap slow(ToMatrix(sight.room));
    int most = 0;
    for (int yaw = -4; yaw <= 4; ++yaw) {
      for (int y = -8; y <= 8; ++y) {
        for (int x = -8; x <= 8; ++x) {
          const Pose2 pose{window.centre.x_m + kCell_m * x, window.centre.y_m + kCell_m * y,
                           window.centre.yaw_rad + kCell_m / kFarthest_m * yaw};
          most = std::max(most, slow.Count(sight.points_m, pose));
        }
      }
    }
    const double num_points = static_cast<double>(sight.points_m.cols());
    // A point on the border of a cell falls on one side of it or the other with single precision.
    CHECK(place.score * num_points == Approx(most).margin(1.5));
    CHECK(slow.Count(sight.points_m, place.pose) >= most - 2);
    CHECK(std::hypot(place.pose.x_m - truth.x_m, place.pose.y_m - truth.y_m) < 2 * kCell_m);
    CHECK(std::abs(place.pose.yaw_rad - truth.yaw_rad) < 0.02);
    CHECK(place.rival == 0.0);
    CHECK(place.evaluations < 17 * 17 * 9);  // looking everywhere
  }
}

TEST_CASE("what a coarse level counts is no less than what any pose of its node has") {
  Random random(5);
  const Sight sight(9, {0.3, -0.2, 0.4});
  for (int level = 1; level < HitPyramid::kLevels; ++level) {
    CAPTURE(level);
    const int last = (1 << level) - 1;
    for (int i = 0; i < 200; ++i) {
      const Pose2 first{random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0), random.Uniform(-3.0, 3.0)};
      const auto At = [&](double x, double y, double yaw) {
        return Pose2{first.x_m + kCell_m * x, first.y_m + kCell_m * y, first.yaw_rad + kCell_m / kFarthest_m * yaw};
      };
      const int bound = sight.Count(level, At(0.5 * last, 0.5 * last, 0.5 * last))[0];
      const auto Any = [&] { return static_cast<int>(random.Next() % (static_cast<std::uint64_t>(last) + 1)); };
      const int within = sight.Count(0, At(Any(), Any(), Any()))[0];
      const int corner = sight.Count(0, At(0, last, 0))[0];
      REQUIRE(bound >= std::max(within, corner));
    }
  }
}

TEST_CASE("four poses are counted at once, each as if it was alone") {
  Random random(6);
  const Sight sight(8, {0.3, -0.2, 0.4});
  for (int level = 0; level < HitPyramid::kLevels; ++level) {
    const double step_m = kCell_m * (1 << level);
    for (int i = 0; i < 100; ++i) {
      // Also where most points lie beyond one side of the grid or another.
      const Pose2 pose{random.Uniform(-9.0, 9.0), random.Uniform(-7.0, 7.0), random.Uniform(-3.0, 3.0)};
      const auto At = [&](int x, int y) { return Pose2{pose.x_m + x * step_m, pose.y_m + y * step_m, pose.yaw_rad}; };
      const std::array<int, 4> counts = sight.Count(level, pose);
      for (int k = 0; k < 4; ++k) {
        CAPTURE(level, i, k);
        // A point on the border of a cell falls on one side of it or the other with single precision.
        const int alone = sight.Count(level, At(k & 1, k >> 1))[0];
        REQUIRE(std::abs(counts[static_cast<std::size_t>(k)] - alone) <= 1);
      }
    }
  }
}

TEST_CASE("counts that cannot reach what is asked for are some numbers below that") {
  const Sight sight(2, {});
  const Pose2 off{0.7, 0.3, 0.2};
  const std::array<int, 4> counts = sight.Count(0, off);
  const auto Most = [](const std::array<int, 4>& of) { return *std::max_element(of.begin(), of.end()); };
  CHECK(sight.Count(0, off, Most(counts)) == counts);
  CHECK(Most(sight.Count(0, off, Most(counts) + 1)) < Most(counts) + 1);
  CHECK(Most(sight.Count(0, off, static_cast<int>(sight.points_m.cols()))) < sight.points_m.cols());
  CHECK(sight.Count(0, {1e3, -1e3, 0.0}) == std::array<int, 4>{});
}

TEST_CASE("a second room like the first is a rival, one that differs is none") {
  Points rooms = MakeRoom(3);
  const Eigen::Matrix2Xd points_m = SeeFrom({}, rooms, 3);
  const PlaceWindow window{{4.0, 0.0, 0.0}, 6.0, 0.1};
  const auto Find = [&] { return FindPlace(HitPyramid(ToMatrix(rooms), kCell_m), points_m, window, kTerms); };
  const Place alone = Find();
  CHECK(alone.score > 0.85);
  CHECK(alone.rival == 0.0);
  const Points other = MakeRoom(4, {8.0, 0.0});
  Points same = MakeRoom(3, {8.0, 0.0});
  const Points first = rooms;
  rooms.insert(rooms.end(), other.begin(), other.end());
  CHECK(Find().rival == 0.0);
  CHECK(std::hypot(Find().pose.x_m, Find().pose.y_m) < 2 * kCell_m);
  rooms = first;
  rooms.insert(rooms.end(), same.begin(), same.end());
  const Place twice = Find();
  CHECK(twice.score > 0.85);
  CHECK(twice.rival >= 0.9 * twice.score);
}

TEST_CASE("where the place is not in the window, nothing is found") {
  const Sight sight(5, {});
  const Place place = FindPlace(sight.pyramid, sight.points_m, {{20.0, 0.0, 0.0}, 2.0, 0.1}, kTerms);
  CHECK(place.score == 0.0);
  CHECK(place.rival == 0.0);
  CHECK(place.evaluations > 0);
}

TEST_CASE("a search that takes too long counts as one in which all is alike") {
  const Sight sight(6, {0.4, 0.3, 0.02});
  const PlaceWindow window{{}, 3.0, 0.2};
  const Place whole = FindPlace(sight.pyramid, sight.points_m, window, kTerms);
  REQUIRE(whole.rival == 0.0);
  PlaceTerms few = kTerms;
  few.most_evaluations = whole.evaluations / 10;
  const Place cut = FindPlace(sight.pyramid, sight.points_m, window, few);
  CHECK(cut.rival == cut.score);
  CHECK(cut.score > 0.0);
  CHECK(cut.evaluations < whole.evaluations);
}

TEST_CASE("among no hits there is no place") {
  const HitPyramid pyramid(Eigen::Matrix2Xd(2, 0), kCell_m);
  CHECK(FindPlace(pyramid, SeeFrom({}, MakeRoom(7), 7), {{}, 1.0, 0.1}, kTerms).score == 0.0);
  CHECK(FindPlace(pyramid, Eigen::Matrix2Xd(2, 0), {{}, 1.0, 0.1}, kTerms).score == 0.0);
}

TEST_CASE("one hit is found by one point, wherever it lies on the lattice") {
  const HitPyramid pyramid(Eigen::Matrix2Xd(Eigen::Vector2d(7.02, -3.01)), kCell_m);
  const Place place =
      FindPlace(pyramid, Eigen::Matrix2Xd(Eigen::Vector2d(1.0, 0.0)), {{6.5, -2.5, 0.0}, 1.0, 0.0}, kTerms);
  CHECK(place.score == 1.0);
  CHECK(std::abs(place.pose.x_m + 1.0 - 7.02) < 2 * kCell_m);
  CHECK(std::abs(place.pose.y_m + 3.01) < 2 * kCell_m);
}

TEST_CASE("where all directions are looked in, the place at the end of the window is no rival to itself") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    INFO(seed);
    const Points room = MakeRoom(seed);
    for (const double yaw_rad : {kPi, kPi - 0.03, -kPi + 0.03}) {
      const Pose2 truth{0.3, -0.2, yaw_rad};
      const Place place =
          FindPlace(HitPyramid(ToMatrix(room), kCell_m), SeeFrom(truth, room, seed), {{}, 1.0, kPi}, kTerms);
      CHECK(place.score > 0.8);
      CHECK(std::abs(WrapAngle(place.pose.yaw_rad - yaw_rad)) < 0.05);
      CHECK(place.rival == 0.0);
    }
  }
}

TEST_CASE("where nothing stands a point counts against a place, and where nothing is known it counts nothing") {
  Points wall;
  AddWall(wall, {2.0, -2.0}, {2.0, 2.0});
  Eigen::Matrix4Xd rays_m(4, 0);
  for (double y_m = -1.9; y_m < 1.95; y_m += 0.02) {
    rays_m.conservativeResize(4, rays_m.cols() + 1);
    rays_m.col(rays_m.cols() - 1) << -2.0, y_m, 1.8, y_m;
  }
  Points room = wall;  // so that the grid reaches there
  AddWall(room, {-2.5, -2.5}, {-2.5, 2.5});
  const HitPyramid pyramid(ToMatrix(room), kCell_m, rays_m);
  Points points = {{2.0, 0.0}, {2.0, 1.0}, {2.0, -1.0}};  // hits
  const auto ScoreAt = [&](const Points& of) {
    const Eigen::Matrix2Xd points_m = ToMatrix(of);
    return pyramid.Count(0, (points_m.row(0) / kCell_m).array().cast<float>(),
                         (points_m.row(1) / kCell_m).array().cast<float>(), {}, -1000)[0];
  };
  CHECK(ScoreAt(points) == 3);
  points.emplace_back(0.0, 0.0);  // free
  CHECK(ScoreAt(points) == 3 - HitPyramid::kFreeWeight);
  points.emplace_back(3.0, 0.0);  // behind the wall
  CHECK(ScoreAt(points) == 3 - HitPyramid::kFreeWeight);
}

TEST_CASE("what is found with free space counted is the best of all poses, and no bound is too low") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Points room = MakeRoom(seed);
    const Pose2 pose{0.4, -0.3, 0.2};
    Eigen::Matrix4Xd rays_m(4, static_cast<Eigen::Index>(room.size()));
    for (std::size_t i = 0; i < room.size(); ++i) rays_m.col(static_cast<Eigen::Index>(i)) << 0.0, 0.0, 0.9 * room[i];
    const HitPyramid pyramid(ToMatrix(room), kCell_m, rays_m);
    const Eigen::Matrix2Xd points_m = SeeFrom(pose, room, seed);
    const Place place = FindPlace(pyramid, points_m, {{}, 0.8, 0.4}, kTerms);
    CHECK(std::hypot(place.pose.x_m - pose.x_m, place.pose.y_m - pose.y_m) < 0.1);
    const Eigen::ArrayXf x_cells = (points_m.row(0) / kCell_m).array().cast<float>();
    const Eigen::ArrayXf y_cells = (points_m.row(1) / kCell_m).array().cast<float>();
    for (int level = 1; level < HitPyramid::kLevels; ++level) {
      const double middle_m = 0.5 * ((1 << level) - 1) * kCell_m;
      const auto bounds = pyramid.Count(level, x_cells, y_cells, {middle_m, middle_m, 0.1}, -100'000);
      for (int dx = 0; dx < 1 << level; dx += 3) {
        for (int dy = 0; dy < 1 << level; dy += 3) {
          const auto counts = pyramid.Count(0, x_cells, y_cells, {dx * kCell_m, dy * kCell_m, 0.1}, -100'000);
          REQUIRE(counts[0] <= bounds[0]);
        }
      }
    }
  }
}

TEST_CASE("of the turns of a window only those that are allowed are looked at") {
  const Points room = MakeRoom(3);
  const Pose2 pose{0.3, 0.2, 1.0};
  const HitPyramid pyramid(ToMatrix(room), kCell_m);
  const Eigen::Matrix2Xd points_m = SeeFrom(pose, room, 3);
  Turns turns;
  turns.set(57);  // 1 rad, to within a degree
  turns.set(58);
  const Place with = FindPlace(pyramid, points_m, {{}, 1.0, kPi, turns}, kTerms);
  const Place all = FindPlace(pyramid, points_m, {{}, 1.0, kPi}, kTerms);
  CHECK(with.pose == all.pose);
  CHECK(with.score == all.score);
  CHECK(with.evaluations < all.evaluations / 2);
  turns.reset();
  turns.set(150);
  CHECK(FindPlace(pyramid, points_m, {{}, 1.0, kPi, turns}, kTerms).score == 0.0);
}

}  // namespace crsm
