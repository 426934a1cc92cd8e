#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/map/byte_map.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/search/line_spectrum.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// Hits of a stretch of the path on a grid, and on coarser and coarser ones that say whether there is one nearby.
class HitPyramid {
 public:
  static constexpr int kLevels = 7;
  /// What a point where nothing stands takes from what a point on a hit counts. At 107 right places in sim:demo no
  /// point lay there, at 73 wrong ones 5 to 20 in a hundred. Fixed: the tables of the innermost loop are made of it
  /// when this is compiled.
  static constexpr int kFreeWeight = 2;

  /// hits_m: 2 x N; of none there is no place. rays_m: 4 x M, from (rows 0, 1) to (rows 2, 3): between them nothing
  /// stands, but where hits are.
  HitPyramid(const Eigen::Matrix2Xd& hits_m, double cell_m,
             const Eigen::Matrix4Xd& rays_m = Eigen::Matrix4Xd::Zero(4, 0));

  /// Of a map, between two corners [m]: its occupied cells, and nothing stands where it is free.
  HitPyramid(const ByteMap& map, const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m, double cell_m);

  double cell_m() const { return cell_m_; }

  /// Points at a pose: how many lie on hits, give or take a cell, and how many where nothing stands.
  struct Overlay {
    int on_hits = 0;
    int on_free = 0;
  };
  /// points_m: 2 x N.
  Overlay Lay(const Eigen::Matrix2Xd& points_m, const Pose2& pose) const;

  /// How many of the points, moved to a pose, lie on hits, give or take a cell, less kFreeWeight times how many lie
  /// where nothing stands; at a level above 0, that at most if each was moved by up to 2^level - 1 cells more. x_cells,
  /// y_cells: of the points, in cells. Of four poses: this one, the one 2^level cells further along x, that along y,
  /// and that along both. Once it is clear that all four are less than `least`, some numbers below that.
  std::array<int, 4> Count(int level, const Eigen::ArrayXf& x_cells, const Eigen::ArrayXf& y_cells, const Pose2& pose,
                           int least) const;

 private:
  struct Grid {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> cells;
  };

  void Build(const Grid& hits, const Grid& free);
  static Grid Widen(const Grid& grid, int reach);
  static Grid Halve(const Grid& grid);
  static Grid Invert(Grid grid);
  static Grid JoinFour(const Grid& grid, int step);
  static Grid JoinFour(const Grid& hits, const Grid& free, int step);
  Grid DrawFree(const Grid& hits, const Eigen::Matrix4Xd& rays_m) const;

  double cell_m_;
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  std::array<Grid, kLevels> levels_;  ///< a cell has two bits for each of the four poses: hit, and free
};

/// How far something may be from where it is guessed, to each side.
struct PlaceReach {
  double reach_m;
  double reach_rad;
};

/// Where to look: so far to each side of a pose.
struct PlaceWindow {
  Pose2 centre;
  double reach_m;
  double reach_rad;
  std::optional<Turns> turns = std::nullopt;  ///< against the centre: only by these
};

/// What counts as a place.
struct PlaceTerms {
  double farthest_m;     ///< of the points from the laser
  double least_score;    ///< of the best place
  double rival_share;    ///< of the best score: as good as this, another place is a rival
  int most_evaluations;  ///< more say that too much is alike
  MatchConstants::OtherPlace other = {};
};

/// The best place of some points.
struct Place {
  Pose2 pose;
  double score = 0.0;  ///< as HitPyramid counts, of the number of points; 0 where none is good enough
  double rival = 0.0;  ///< that of the best other place, if it is a rival
  int evaluations = 0;
};

/// The best places of some points, each far from those before it, best first.
struct Places {
  std::vector<ScoredPose> places;  ///< a fitness is as HitPyramid counts, of the number of points
  double highest_left = 0.0;       ///< what another place may score: too much is alike, and the search was ended
  int evaluations = 0;
};

/// The places in the window, `most` at most, that score at least as much as the terms say. As of FindPlace.
Places FindPlaces(const HitPyramid& pyramid, const Eigen::Matrix2Xd& points_m, const PlaceWindow& window,
                  const PlaceTerms& terms, std::size_t most);

/// Finds the best place in the window, and whether there is another one as good, 0.6 m or 0.2 rad away, without looking
/// everywhere: branch and bound. Source: Olson, "M3RSM: Many-to-many multi-resolution scan matching", ICRA 2015; Hess,
/// Kohler, Rapp and Andor, "Real-time loop closure in 2D LIDAR SLAM", ICRA 2016, section V. points_m: 2 x N.
Place FindPlace(const HitPyramid& pyramid, const Eigen::Matrix2Xd& points_m, const PlaceWindow& window,
                const PlaceTerms& terms);

}  // namespace crsm
