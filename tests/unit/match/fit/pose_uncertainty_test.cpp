#include "common/match/fit/pose_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "common/scan/hits.hpp"
#include "common/slam.hpp"
#include "common/worlds/simulator.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// A drive through a world: how often the true pose was within three standard deviations, and how large they were.
struct Drive {
  int num_matched = 0;
  int num_inside = 0;
  int num_degenerate = 0;
  std::vector<double> sigma_m;  ///< of the match, the larger one of x and y
};

Drive DriveThrough(const World& world, const Parameters& parameters) {
  Simulator simulator(world, 7);
  Slam slam(parameters);
  Drive drive;
  while (const auto scan = simulator.Next()) {
    const ScanMatch match = slam.Process(*scan).match;
    if (match.state != MatchState::kOk && match.state != MatchState::kDegenerate) continue;
    const Pose2 truth = *simulator.TruePose();
    const Pose2& found = match.T_map_laser;
    const double errors[] = {found.x_m - truth.x_m, found.y_m - truth.y_m, WrapAngle(found.yaw_rad - truth.yaw_rad)};
    const double variances[] = {match.covariance[0], match.covariance[3], match.covariance[5]};
    bool inside = true;
    for (int i = 0; i < 3; ++i) inside = inside && errors[i] * errors[i] <= 9.0 * variances[i];
    ++drive.num_matched;
    drive.num_inside += inside;
    drive.num_degenerate += match.state == MatchState::kDegenerate;
    drive.sigma_m.push_back(std::sqrt(std::max(variances[0], variances[1])));
  }
  std::sort(drive.sigma_m.begin(), drive.sigma_m.end());
  return drive;
}

PoseUncertainty UncertaintyOf(const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser, const ByteMap& map) {
  return ComputeUncertainty(hits_m, ComputeNormals(hits_m, Gaps(hits_m), map.geometry().cell_size_m()), T_map_laser,
                            map);
}

PoseUncertainty UncertaintyInRoom(const Pose2& T_map_laser, const ByteMap& map) {
  const ValidRays rays = FindValidRays(ScanRoom(T_map_laser), TestParameters().scan);
  return UncertaintyOf(ComputeHits(rays), T_map_laser, map);
}

ByteMap RoomMap() { return PaintMap(-2, 1, RoomByte); }

}  // namespace

TEST_CASE("in a room the pose is known to about a cell, wherever the laser looks") {
  const ByteMap map = RoomMap();
  for (const double yaw_rad : {0.0, 0.7, -2.5}) {
    const PoseUncertainty uncertainty = UncertaintyInRoom({0.5, 0.3, yaw_rad}, map);
    CHECK_FALSE(uncertainty.degenerate());
    CHECK(std::sqrt(uncertainty.covariance(0, 0)) < 0.055);
    CHECK(std::sqrt(uncertainty.covariance(1, 1)) < 0.055);
    CHECK(std::sqrt(uncertainty.covariance(2, 2)) < 0.02);
    CHECK(uncertainty.covariance.isApprox(uncertainty.covariance.transpose()));
  }
}

TEST_CASE("a hit is on a wall of the map that is in its cell, or in one of the four beside it") {
  constexpr int kWall = 80;  // of its column or row of cells, in the midst of a tile
  for (const bool upright : {true, false}) {
    const ByteMap map = PaintMap(
        -2, 1, [&](Cell cell) { return (upright ? cell.x : cell.y) == kWall ? kOccupiedByte : std::uint8_t{255}; });
    for (const int beside : {-2, -1, 0, 1, 2}) {
      Eigen::Matrix2Xd hits_m(2, 40);
      for (int i = 0; i < hits_m.cols(); ++i) {
        const double across_m = 0.05 * (kWall + beside + 0.5);
        const double along_m = 0.05 * (i - 20) + 0.51;
        hits_m.col(i) << (upright ? across_m : along_m), (upright ? along_m : across_m);
      }
      const PoseUncertainty uncertainty = UncertaintyOf(hits_m, {}, map);
      INFO("upright " << upright << ", " << beside << " cells beside it");
      CHECK((uncertainty.covariance(upright ? 0 : 1, upright ? 0 : 1) < 0.1) == (std::abs(beside) <= 1));
    }
  }
}

TEST_CASE("where one wall is seen to one side, errors of yaw and of position go together as they do on that wall") {
  // A wall ahead at x = 4.025 m of which only the left end is seen, y > 0: turned too far to the left, the laser would
  // see that piece too near, unless it stood too far ahead as well. So x and yaw err alike there, and against each
  // other at the right end. Of a wall to the left, y = 3.025 m, the piece that lies ahead makes y and yaw err against
  // each other, the piece that lies behind alike.
  struct Piece {
    double from_rad, to_rad;  // seen from the origin, map frame
    int coupled;              // index of the coordinate across the wall
    double sign;
  };
  for (const auto& [from_rad, to_rad, coupled, sign] :
       {Piece{0.15, 0.6, 0, 1.0}, {-0.45, -0.15, 0, -1.0}, {1.0, 1.4, 1, -1.0}, {1.7, 2.2, 1, 1.0}}) {
    for (const double yaw_rad : {0.0, 0.8, -2.0}) {
      const Pose2 pose{0.0, 0.0, yaw_rad};
      const Eigen::Matrix2Xd all_m = ComputeHits(FindValidRays(ScanRoom(pose), TestParameters().scan));
      std::vector<Eigen::Vector2d> seen_m;
      for (Eigen::Index i = 0; i < all_m.cols(); ++i) {
        const double angle_rad = WrapAngle(std::atan2(all_m(1, i), all_m(0, i)) + yaw_rad);
        if (angle_rad > from_rad && angle_rad < to_rad) seen_m.emplace_back(all_m.col(i));
      }
      Eigen::Matrix2Xd hits_m(2, static_cast<Eigen::Index>(seen_m.size()));
      for (std::size_t i = 0; i < seen_m.size(); ++i) hits_m.col(static_cast<Eigen::Index>(i)) = seen_m[i];
      const Eigen::Matrix3d c = UncertaintyOf(hits_m, pose, RoomMap()).covariance;
      CAPTURE(from_rad, yaw_rad);
      // How much they have in common depends on how long the piece is; no less than a fifth in these.
      CHECK(sign * c(coupled, 2) / std::sqrt(c(coupled, coupled) * c(2, 2)) > 0.2);
    }
  }
}

TEST_CASE("posts that stand in the open fix a pose, and hits far apart on a wall do not") {
  // Seven posts around the laser, a cell each, and hits on them.
  constexpr std::uint8_t kFree = 255;
  Eigen::Matrix2Xd hits_m(2, 7);
  for (int i = 0; i < hits_m.cols(); ++i) {
    const double angle_rad = -2.8 + 0.9 * i;
    hits_m.col(i) << (3.0 + 0.3 * i) * std::cos(angle_rad), (3.0 + 0.3 * i) * std::sin(angle_rad);
  }
  const auto IsPost = [&](Cell cell) {
    const auto Cells = [](double length_m) { return static_cast<int>(std::floor(length_m / 0.05)); };
    for (const auto& hit_m : hits_m.colwise()) {
      if (cell == Cell{Cells(hit_m.x()), Cells(hit_m.y())}) return true;
    }
    return false;
  };
  const auto Open = [&](Cell cell) { return IsPost(cell) ? kOccupiedByte : kFree; };
  const PoseUncertainty posts = UncertaintyOf(hits_m, {}, PaintMap(-2, 1, Open));
  CHECK_FALSE(posts.degenerate());
  CHECK(std::sqrt(posts.covariance(0, 0)) < 0.1);
  CHECK(std::sqrt(posts.covariance(1, 1)) < 0.1);

  // The same cells where half of what is around them is not known, as along a wall that is not drawn yet.
  const auto HalfKnown = [&](Cell cell) {
    return IsPost(cell) ? kOccupiedByte : ((cell.x + cell.y) & 1) == 0 ? kFree : kUnexploredByte;
  };
  CHECK(UncertaintyOf(hits_m, {}, PaintMap(-2, 1, HalfKnown)).degenerate());

  // Hits on a wall, too far apart to be one surface.
  Eigen::Matrix2Xd apart_m(2, 7);
  for (int i = 0; i < apart_m.cols(); ++i) apart_m.col(i) << 1.0 + 0.85 * i, 2.01;
  const auto Wall = [&](Cell cell) { return cell.y == 40 ? kOccupiedByte : kFree; };
  CHECK(UncertaintyOf(apart_m, {}, PaintMap(-2, 1, Wall)).degenerate());
}

TEST_CASE("without hits, or where their walls are not on the map, nothing is known") {
  for (const PoseUncertainty& uncertainty :
       {UncertaintyInRoom({0.5, 0.3, 0.0}, ByteMap(0.05)), UncertaintyOf(Eigen::Matrix2Xd(2, 0), {}, RoomMap())}) {
    CHECK(uncertainty.degenerate());
    CHECK(uncertainty.covariance.allFinite());
    CHECK(std::sqrt(uncertainty.covariance(0, 0)) > 0.9);
  }
}

TEST_CASE("the true pose lies within three standard deviations in 99 % of the scans, and these are no boast") {
  for (const char* name : {"demo", "env1", "env3"}) {
    CAPTURE(name);
    Parameters parameters;
    const bool papers = std::string(name) != "demo";
    if (papers) parameters.update.cell_size_m = 0.02;  // as the preset for the paper's worlds
    if (papers) parameters.scan.range_max_m = 9.5;
    const Drive drive = DriveThrough(LoadWorld(name), parameters);
    CHECK(drive.num_inside >= 0.99 * drive.num_matched);
    CHECK(drive.num_degenerate < 0.1 * drive.num_matched);
    CHECK(drive.sigma_m.at(drive.sigma_m.size() / 2) < 1.1 * parameters.update.cell_size_m);
  }
}

}  // namespace crsm
