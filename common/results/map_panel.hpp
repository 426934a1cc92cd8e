#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/diagnosis/changes.hpp"
#include "common/graph/pieces.hpp"
#include "common/map/dense_grid.hpp"
#include "common/map/map_geometry.hpp"
#include "common/results/overview_style.hpp"

namespace crsm {

/// Two places that belong together [m], map frame.
struct PointPair {
  cv::Point2d from_m;
  cv::Point2d to_m;
};

/// The upper part of the overview: the floor, what is drawn on it, and the walls over all of that. Around the map it is
/// unexplored.
class MapPanel {
 public:
  /// grid: at least one cell; it must live as long as the panel.
  explicit MapPanel(const DenseGrid& grid);

  const cv::Mat& image() const { return image_; }
  const OverviewScale& scale() const { return scale_; }

  /// Lays a colour over the floor, the deeper, the further off the map may be at the nearest of some places. Before
  /// anything else is drawn. most_m: where it is deepest, > 0.
  void DrawDoubts(const std::vector<Doubt>& doubts, double most_m);
  /// Draws the path on to its next point, if that is elsewhere in the picture: a robot that stands costs nothing.
  void GoTo(const cv::Point2d& point_m);
  /// Where the path goes on after this is not joined with where it was.
  void BreakPath() { path_end_.reset(); }
  /// Joins both ends of each pair by a line between two dots. Lines do not add up, however many there are.
  void DrawPairs(const std::vector<PointPair>& pairs, const PairStyle& style);
  /// radius_pixels, arm_pixels: of a picture that is not shrunk.
  void DrawDisc(const cv::Point2d& centre_m, double radius_pixels, const cv::Scalar& colour);
  /// Wider than a wall of one cell, which is drawn over it.
  void DrawHit(const cv::Point2d& place_m);
  void DrawCross(const cv::Point2d& centre_m, const cv::Scalar& colour);
  void DrawRing(const cv::Point2d& centre_m);
  /// A rectangle, lightly filled.
  void DrawChange(const MapChange& change);
  /// Two arrows that show where the map's x and y point, from its origin.
  void DrawOrigin();
  void DrawWalls();
  /// Words right of a place and above it.
  void DrawLabel(const cv::Point2d& place_m, const std::string& text, const cv::Scalar& colour);
  /// Coordinates along the left and lower edge.
  void DrawRulers();

 private:
  void DrawFloor();
  /// corner: of the part of the picture that the mask is for, in subpixels.
  void DrawPair(const PointPair& pair, bool dashed, double dot_radius, const cv::Point& corner, cv::Mat& mask) const;
  void DrawRulerOfX();
  void DrawRulerOfY();
  cv::Point ToSubpixels(const cv::Point2d& point_m) const;
  cv::Point ToPixels(const cv::Point2d& point_m) const;

  const DenseGrid& grid_;
  MapGeometry geometry_;
  double pixels_per_cell_;
  OverviewScale scale_;
  cv::Mat image_;
  cv::Rect map_;                       ///< where the map is in image_
  cv::Point2d origin_;                 ///< the map frame's origin [pixels]
  std::optional<cv::Point> path_end_;  // in subpixels
};

}  // namespace crsm
