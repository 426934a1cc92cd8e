#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/plan/plan.hpp"

namespace crsm {

/// The sine of the angle from one unit vector to another.
inline double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Sums over hits: what a line is fitted to.
struct HitSums {
  double num = 0.0;
  Eigen::Vector2d mean_m = Eigen::Vector2d::Zero();
  Eigen::Matrix2d scatter_m2 = Eigen::Matrix2d::Zero();  ///< sum over squares about the mean

  void Add(const Eigen::Vector2d& hit_m);
  void Add(const HitSums& other);
};

/// Hits of one scan that follow each other on a straight line. Map frame.
struct WallStretch {
  int scan = 0;
  Eigen::Vector2d from_m;  ///< on its line
  Eigen::Vector2d to_m;
  Eigen::Vector2d normal;  ///< unit vector, towards the laser
  HitSums hits;
};

/// A straight line that faces one side. Map frame.
struct WallLine {
  Eigen::Vector2d origin_m;
  Eigen::Vector2d along;   ///< unit vector
  Eigen::Vector2d normal;  ///< unit vector, towards who saw it
  double sigma_offset_m = 0.0;
  double sigma_yaw_rad = 0.0;
  bool two_faced = false;  ///< seen from both sides
  bool snapped = false;
  std::vector<int> stretches;  ///< numbers of those that it was fitted to
  double from_m = 0.0;         ///< along it, from the origin: what they cover
  double to_m = 0.0;

  double Along(const Eigen::Vector2d& at_m) const { return along.dot(at_m - origin_m); }
  double Across(const Eigen::Vector2d& at_m) const { return normal.dot(at_m - origin_m); }
  Eigen::Vector2d At(double along_m) const { return origin_m + along_m * along; }
};

/// The straight stretches in a scan.
/// Source: iterative end point fit (Duda and Hart, Pattern Classification and Scene Analysis, 1973).
std::vector<WallStretch> FindStretches(const PlacedScan& scan, int number, const PlanConstants::Stretch& constants);

/// The lines that the stretches lie on, longest stretches first.
std::vector<WallLine> FitLines(const std::vector<WallStretch>& stretches, const PlanConstants::Line& constants);

/// Main directions of the lines, in [0, pi / 2); and turns lines to them about their middle where nothing speaks
/// against it.
std::vector<double> SnapLines(std::vector<WallLine>& lines, const PlanConstants::Direction& constants);

}  // namespace crsm
