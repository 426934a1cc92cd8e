#include "common/results/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "common/map/map_geometry.hpp"
#include "common/results/png.hpp"
#include "common/scan/deskew.hpp"

namespace crsm {

namespace {

constexpr int kWantedSide = 1600;      // pixels on the longer side of an enlarged map
constexpr int kMaxSide = 4000;         // pixels: larger maps are shrunk to this
constexpr int kMaxEnlargement = 16;    // pixels a cell: a map of few cells stays small
constexpr int kStripHeight = 44;       // pixels, of the caption below a picture of kWantedSide or less
constexpr int kMinWidth = 640;         // pixels: that caption's text fits
constexpr int kMinWidthLoops = 900;    // ... with what it says of loops
constexpr int kMinWidthBreaks = 1300;  // ... and of breaks, joins and pieces
constexpr int kSubpixelBits = 4;       // OpenCV draws to 1/16 of a pixel

// Red, green, blue.
const cv::Scalar kPathColour(20, 100, 210);
const cv::Scalar kStartColour(30, 160, 50);
const cv::Scalar kEndColour(220, 30, 40);
const cv::Scalar kLostColour(255, 130, 0);
const cv::Scalar kHitColour(200, 30, 200);
const cv::Scalar kLoopColour(0, 170, 170);
const cv::Scalar kRejectedColour(130, 70, 20);
const cv::Scalar kJoinColour(90, 30, 170);
const cv::Scalar kBreakColour(200, 0, 90);
const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kPaper(255, 255, 255);

std::string EncodePicture(const cv::Mat& picture, PngEncoder& encoder) {
  return encoder.Encode({picture.cols, picture.rows, picture.channels(), picture.data});
}

/// The map as a picture, y up.
cv::Mat ToPicture(const DenseGrid& grid) {
  // OpenCV takes no const data; the flip copies it.
  const cv::Mat rows(grid.height_cells, grid.width_cells, CV_8UC1, const_cast<std::uint8_t*>(grid.cells.data()));
  cv::Mat picture;
  cv::flip(rows, picture, 0);
  return picture;
}

double ComputePixelsPerCell(const DenseGrid& grid) {
  const int longer_side = std::max(grid.width_cells, grid.height_cells);
  if (longer_side > kMaxSide) return static_cast<double>(kMaxSide) / longer_side;
  return std::clamp(kWantedSide / longer_side, 1, kMaxEnlargement);
}

/// The overview while it is drawn.
class Canvas {
 public:
  Canvas(const DenseGrid& grid, int min_width)
      : geometry_(grid.cell_size_m),
        pixels_per_cell_(ComputePixelsPerCell(grid)),
        left_cells_(grid.origin_x_cells),
        top_cells_(grid.origin_y_cells + grid.height_cells) {
    cv::Mat map;
    const auto ToPixels = [&](int cells) {
      return std::max(1, static_cast<int>(std::lround(cells * pixels_per_cell_)));
    };
    cv::resize(ToPicture(grid), map, {ToPixels(grid.width_cells), ToPixels(grid.height_cells)}, 0.0, 0.0,
               pixels_per_cell_ < 1.0 ? cv::INTER_AREA : cv::INTER_NEAREST);
    enlargement_ = std::max(1.0, static_cast<double>(std::max(map.cols, map.rows)) / kWantedSide);
    image_ = cv::Mat(map.rows + Enlarge(kStripHeight), std::max(map.cols, Enlarge(min_width)), CV_8UC3, kPaper);
    map_ = image_(cv::Rect(0, 0, map.cols, map.rows));
    cv::cvtColor(map, map_, cv::COLOR_GRAY2RGB);
  }

  const cv::Mat& image() const { return image_; }

  /// Draws the path on to its next point, if that is elsewhere in the picture: a robot that stands costs nothing.
  void GoTo(const cv::Point2d& point_m) {
    const cv::Point point = ToSubpixels(point_m);
    if (path_end_ && *path_end_ != point) DrawLine(*path_end_, point, kPathColour);
    path_end_ = point;
  }

  /// A line between two discs: a short one shows too.
  void DrawPair(const cv::Point2d& from_m, const cv::Point2d& to_m, const cv::Scalar& colour) {
    DrawLine(ToSubpixels(from_m), ToSubpixels(to_m), colour);
    for (const cv::Point2d& end_m : {from_m, to_m}) DrawDisc(end_m, 5.0, colour);
  }

  /// A small cross between two diagonals.
  void DrawCross(const cv::Point2d& centre_m, const cv::Scalar& colour) {
    const cv::Point centre = ToSubpixels(centre_m);
    const int arm = static_cast<int>(std::lround(enlargement_ * kArm)) << kSubpixelBits;
    DrawLine(centre + cv::Point(-arm, -arm), centre + cv::Point(arm, arm), colour);
    DrawLine(centre + cv::Point(-arm, arm), centre + cv::Point(arm, -arm), colour);
  }

  /// radius_pixels: in a picture of kWantedSide.
  void DrawDisc(const cv::Point2d& centre_m, double radius_pixels, const cv::Scalar& colour) {
    const auto radius = static_cast<int>(std::lround(enlargement_ * radius_pixels * (1 << kSubpixelBits)));
    cv::circle(map_, ToSubpixels(centre_m), radius, colour, cv::FILLED, cv::LINE_AA, kSubpixelBits);
  }

  /// A bar of 1, 2 or 5 times a power of ten metres, as long as a fifth of the picture at most.
  void DrawScaleBar() {
    const double pixels_per_m = geometry_.ToCells(1.0) * pixels_per_cell_;
    const double longest_m = 0.2 * image_.cols / pixels_per_m;
    const double decade_m = std::pow(10.0, std::floor(std::log10(longest_m)));
    const double factor = longest_m >= 5.0 * decade_m ? 5.0 : longest_m >= 2.0 * decade_m ? 2.0 : 1.0;
    const double length_m = factor * decade_m;
    const int left = Enlarge(kMargin);
    const int right = left + static_cast<int>(std::lround(length_m * pixels_per_m));
    const int y = map_.rows + Enlarge(kStripHeight) / 2;
    const int half_tick = Enlarge(6);
    cv::line(image_, {left, y}, {right, y}, kInk, Enlarge(2));
    for (const int x : {left, right}) cv::line(image_, {x, y - half_tick}, {x, y + half_tick}, kInk, Enlarge(2));
    caption_x_ = right + left;
    AddCaption(fmt::format("{:g} m", length_m), kInk);
  }

  /// Adds words to the strip, from left to right.
  void AddCaption(const std::string& text, const cv::Scalar& colour) {
    const double text_scale = 0.5 * enlargement_;
    const int thickness = Enlarge(1);
    cv::putText(image_, text, {caption_x_, map_.rows + Enlarge(kStripHeight) / 2 + Enlarge(5)},
                cv::FONT_HERSHEY_SIMPLEX, text_scale, colour, thickness, cv::LINE_AA);
    caption_x_ +=
        cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, text_scale, thickness, nullptr).width + Enlarge(kMargin);
  }

 private:
  static constexpr int kMargin = 14;   // pixels, in the strip
  static constexpr double kArm = 8.0;  // pixels, of a cross in a picture of kWantedSide

  void DrawLine(const cv::Point& from, const cv::Point& to, const cv::Scalar& colour) {
    cv::line(map_, from, to, colour, Enlarge(2), cv::LINE_AA, kSubpixelBits);
  }

  /// Lines and letters of a large picture are as large in it as those of a smaller one: both are seen on one screen.
  int Enlarge(int pixels) const { return static_cast<int>(std::lround(pixels * enlargement_)); }

  cv::Point ToSubpixels(const cv::Point2d& point_m) const {
    // The limit keeps a point far outside within OpenCV's integers. A pixel's centre is at its whole number.
    const auto ToInteger = [](double pixels) {
      return static_cast<int>(std::lround((std::clamp(pixels, -1e5, 1e5) - 0.5) * (1 << kSubpixelBits)));
    };
    return {ToInteger((geometry_.ToCells(point_m.x) - left_cells_) * pixels_per_cell_),
            ToInteger((top_cells_ - geometry_.ToCells(point_m.y)) * pixels_per_cell_)};
  }

  MapGeometry geometry_;
  double pixels_per_cell_;
  double enlargement_ = 1.0;
  int left_cells_;
  int top_cells_;
  cv::Mat image_;
  cv::Mat map_;  // the upper part of image_
  int caption_x_ = 0;
  std::optional<cv::Point> path_end_;  // in subpixels
};

cv::Point2d PointOf(const Pose2& pose) { return {pose.x_m, pose.y_m}; }

/// What is drawn over the path, or said of it.
struct Path {
  std::int64_t num_scans = 0;
  std::int64_t num_lost = 0;
  std::int64_t num_elsewhere = 0;  ///< on other pieces, lost ones too
  std::optional<cv::Point2d> start_m;
  cv::Point2d end_m;
  std::optional<ScanMatch> last;  ///< the match of the last scan
};

Path DrawPath(const Results& results, Canvas& canvas) {
  Path path;
  path.num_scans = results.num_left_out;
  path.num_lost = results.num_lost_left_out;
  results.matches.ForEach([&](const ScanMatch& match) {
    ++path.num_scans;
    if (match.floating) {
      ++path.num_elsewhere;
      return;
    }
    if (match.utime == results.last_scan.utime) path.last = match;
    if (match.state == MatchState::kLost) {
      ++path.num_lost;
      return;
    }
    path.end_m = PointOf(match.T_map_laser);
    if (!path.start_m) path.start_m = path.end_m;
    canvas.GoTo(path.end_m);
  });
  return path;
}

void DrawScan(const ValidRays& rays, const Pose2& T_map_laser, Canvas& canvas) {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  for (const auto& hit_m : hits_m.colwise()) {
    canvas.DrawDisc(PointOf(T_map_laser * Pose2{hit_m.x(), hit_m.y(), 0.0}), 2.0, kHitColour);
  }
}

/// Where the path on this map ends because the robot was lost or nothing was recorded.
void DrawBreaks(const MapPieces& pieces, Canvas& canvas) {
  for (const Break& at : pieces.breaks) {
    if (at.piece_before == 1) canvas.DrawCross(PointOf(at.T_map_before), kBreakColour);
  }
}

void AddCaptionsOfPieces(const Results& results, Canvas& canvas) {
  const MapPieces& pieces = results.pieces;
  if (pieces.num_breaks == 0) return;
  canvas.AddCaption(fmt::format("{} breaks (x)", pieces.num_breaks), kBreakColour);
  const auto num_joins = std::ranges::count(results.loops, true, &PlacedLoop::joins);
  if (num_joins > 0) canvas.AddCaption(fmt::format("{} joined", num_joins), kJoinColour);
  canvas.AddCaption(
      pieces.num_pieces == 1 ? "map in one piece" : fmt::format("the largest of {} pieces", pieces.num_pieces), kInk);
}

void AddCaptions(const Results& results, const Path& path, Canvas& canvas) {
  canvas.DrawScaleBar();
  std::string scans = fmt::format("{} scans, {} lost", path.num_scans, path.num_lost);
  if (path.num_elsewhere > 0) scans += fmt::format(", {} on other pieces", path.num_elsewhere);
  canvas.AddCaption(scans, kInk);
  canvas.AddCaption("path", kPathColour);
  canvas.AddCaption("start", kStartColour);
  canvas.AddCaption("end", kEndColour);
  canvas.AddCaption("lost", kLostColour);
  canvas.AddCaption("last scan", kHitColour);
  const auto num_rejected = std::ranges::count(results.loops, true, &PlacedLoop::rejected);
  if (!results.loops.empty()) {
    canvas.AddCaption(fmt::format("{} loops closed", std::ssize(results.loops) - num_rejected), kLoopColour);
  }
  if (num_rejected > 0) canvas.AddCaption(fmt::format("{} rejected", num_rejected), kRejectedColour);
  AddCaptionsOfPieces(results, canvas);
}

int MinWidth(const Results& results) {
  if (results.pieces.num_breaks > 0) return kMinWidthBreaks;
  return results.loops.empty() ? kMinWidth : kMinWidthLoops;
}

const cv::Scalar& ColourOf(const PlacedLoop& loop) {
  return loop.rejected ? kRejectedColour : loop.joins ? kJoinColour : kLoopColour;
}

}  // namespace

std::string EncodeMap(const DenseGrid& grid, PngEncoder& encoder) { return EncodePicture(ToPicture(grid), encoder); }

std::string EncodeOverview(const Results& results, PngEncoder& encoder) {
  Canvas canvas(results.grid, MinWidth(results));
  const Path path = DrawPath(results, canvas);
  for (const PlacedLoop& loop : results.loops) {
    canvas.DrawPair(PointOf(loop.T_map_older), PointOf(loop.T_map_newer), ColourOf(loop));
  }
  const auto DrawIfLost = [&](const ScanMatch& match) {
    if (match.state != MatchState::kLost || match.floating) return;
    canvas.DrawDisc(PointOf(match.T_map_laser), 3.0, kLostColour);
  };
  if (path.num_lost > 0) results.matches.ForEach(DrawIfLost);  // over the whole path
  DrawBreaks(results.pieces, canvas);
  if (path.last) DrawScan(Deskew(results.last_scan.rays, path.last->twist), path.last->T_map_laser, canvas);
  if (path.start_m) {
    canvas.DrawDisc(*path.start_m, 7.0, kStartColour);
    canvas.DrawDisc(path.end_m, 7.0, kEndColour);
  }
  AddCaptions(results, path, canvas);
  return EncodePicture(canvas.image(), encoder);
}

}  // namespace crsm
