#include "common/results/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "common/map/map_geometry.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

namespace {

constexpr int kWantedSide = 1600;    // pixels on the longer side of an enlarged map
constexpr int kMaxSide = 4000;       // pixels: larger maps are shrunk to this
constexpr int kMaxEnlargement = 16;  // pixels a cell: a map of few cells stays small
constexpr int kStripHeight = 44;     // pixels, of the caption below a picture of kWantedSide or less
constexpr int kMinWidth = 640;       // pixels: that caption's text fits
constexpr int kSubpixelBits = 4;     // OpenCV draws to 1/16 of a pixel

// Blue, green, red.
const cv::Scalar kPathColour(210, 100, 20);
const cv::Scalar kStartColour(50, 160, 30);
const cv::Scalar kEndColour(40, 30, 220);
const cv::Scalar kLostColour(0, 130, 255);
const cv::Scalar kHitColour(200, 30, 200);
const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kPaper(255, 255, 255);

std::string EncodePng(const cv::Mat& image) {
  std::vector<uchar> bytes;
  // Named, so that another version's defaults do not change the bytes.
  cv::imencode(".png", image, bytes,
               {cv::IMWRITE_PNG_COMPRESSION, 6, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_DEFAULT});
  return {bytes.begin(), bytes.end()};
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
  explicit Canvas(const DenseGrid& grid)
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
    image_ = cv::Mat(map.rows + Enlarge(kStripHeight), std::max(map.cols, Enlarge(kMinWidth)), CV_8UC3, kPaper);
    map_ = image_(cv::Rect(0, 0, map.cols, map.rows));
    cv::cvtColor(map, map_, cv::COLOR_GRAY2BGR);
  }

  const cv::Mat& image() const { return image_; }

  /// Draws the path on to its next point, if that is elsewhere in the picture: a robot that stands costs nothing.
  void GoTo(const cv::Point2d& point_m) {
    const cv::Point point = ToSubpixels(point_m);
    if (path_end_ && *path_end_ != point) {
      cv::line(map_, *path_end_, point, kPathColour, Enlarge(2), cv::LINE_AA, kSubpixelBits);
    }
    path_end_ = point;
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
  static constexpr int kMargin = 14;  // pixels, in the strip

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

void DrawScan(const ValidRays& rays, const Pose2& T_map_laser, Canvas& canvas) {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  for (const auto& hit_m : hits_m.colwise()) {
    const Pose2 T_map_hit = T_map_laser * Pose2{hit_m.x(), hit_m.y(), 0.0};
    canvas.DrawDisc({T_map_hit.x_m, T_map_hit.y_m}, 2.0, kHitColour);
  }
}

}  // namespace

std::string EncodeMap(const DenseGrid& grid) { return EncodePng(ToPicture(grid)); }

std::string EncodeOverview(const Results& results) {
  Canvas canvas(results.grid);
  std::int64_t num_scans = results.num_left_out;
  std::int64_t num_lost = results.num_lost_left_out;
  std::optional<cv::Point2d> start_m;
  cv::Point2d end_m;
  std::optional<Pose2> last_pose;
  const auto PointOf = [](const ScanMatch& match) { return cv::Point2d(match.T_map_laser.x_m, match.T_map_laser.y_m); };
  results.matches.ForEach([&](const ScanMatch& match) {
    ++num_scans;
    if (match.utime == results.last_scan.utime) last_pose = match.T_map_laser;
    if (match.state == MatchState::kLost) {
      ++num_lost;
      return;
    }
    end_m = PointOf(match);
    if (!start_m) start_m = end_m;
    canvas.GoTo(end_m);
  });
  const auto DrawIfLost = [&](const ScanMatch& match) {
    if (match.state == MatchState::kLost) canvas.DrawDisc(PointOf(match), 3.0, kLostColour);
  };
  if (num_lost > 0) results.matches.ForEach(DrawIfLost);  // over the whole path
  if (last_pose) DrawScan(results.last_scan.rays, *last_pose, canvas);
  if (start_m) {
    canvas.DrawDisc(*start_m, 7.0, kStartColour);
    canvas.DrawDisc(end_m, 7.0, kEndColour);
  }

  canvas.DrawScaleBar();
  canvas.AddCaption(fmt::format("{} scans, {} lost", num_scans, num_lost), kInk);
  canvas.AddCaption("path", kPathColour);
  canvas.AddCaption("start", kStartColour);
  canvas.AddCaption("end", kEndColour);
  canvas.AddCaption("lost", kLostColour);
  canvas.AddCaption("last scan", kHitColour);
  return EncodePng(canvas.image());
}

}  // namespace crsm
