#include "common/results/map_panel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace crsm {
namespace {

constexpr int kWantedSide = 1600;    // pixels on the longer side of an enlarged map
constexpr int kMaxSide = 4000;       // pixels: larger maps are shrunk to this
constexpr int kMaxEnlargement = 16;  // pixels a cell: a map of few cells stays small
constexpr int kSubpixelBits = 4;     // OpenCV draws to 1/16 of a pixel
constexpr int kManyPairs = 300;      // with more, lines are half as dark and dots half as large

// Pixels, to be enlarged.
constexpr int kLeftMargin = 76;  // "-1000 m" has room
constexpr int kLowerMargin = 40;
constexpr int kOtherMargin = 24;
constexpr int kMinWidth = 1000;  // the caption is read without many breaks
constexpr int kMinHeight = 280;
constexpr int kRoomForCaption = 400;
constexpr double kDeepestDoubt = 0.6;  // of its colour over the floor
constexpr double kLetters = 0.45;      // times OpenCV's

double ComputePixelsPerCell(const DenseGrid& grid) {
  const int longer_side = std::max(grid.width_cells, grid.height_cells);
  if (longer_side > kMaxSide) return static_cast<double>(kMaxSide) / longer_side;
  return std::clamp(kWantedSide / longer_side, 1, kMaxEnlargement);
}

using Colour = cv::Vec3b;

Colour Mix(const cv::Scalar& of_0, const cv::Scalar& of_1, double share) {
  const cv::Scalar mixed = of_0 * (1.0 - share) + of_1 * share;
  return {cv::saturate_cast<std::uint8_t>(mixed[0]), cv::saturate_cast<std::uint8_t>(mixed[1]),
          cv::saturate_cast<std::uint8_t>(mixed[2])};
}

/// Lays a colour over a pixel. share: of the colour, in 1/256.
void Cover(const cv::Vec3i& colour, int share, Colour& pixel) {
  for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>((pixel[c] * (256 - share) + colour[c] * share) >> 8);
}

cv::Vec3i ToIntegers(const cv::Scalar& colour) {
  return {static_cast<int>(colour[0]), static_cast<int>(colour[1]), static_cast<int>(colour[2])};
}

/// Lays a colour over a picture where the mask is 255, and as much less of it as the mask is less.
void Cover(const cv::Mat& mask, const cv::Scalar& colour, double opacity, cv::Mat picture) {
  const cv::Vec3i integers = ToIntegers(colour);
  for (int y = 0; y < mask.rows; ++y) {
    const std::uint8_t* row = mask.ptr<std::uint8_t>(y);
    Colour* pixels = picture.ptr<Colour>(y);
    for (int x = 0; x < mask.cols; ++x) {
      if (row[x] > 0) Cover(integers, static_cast<int>(std::lround(row[x] * opacity * 256 / 255)), pixels[x]);
    }
  }
}

/// The floor under walls is as unexplored: it is not seen.
std::array<Colour, 256> FloorColours() {
  std::array<Colour, 256> colours;
  for (int i = 0; i < 256; ++i) {
    const double share = std::max(0, i - kUnexploredByte) / static_cast<double>(kFreeByte - kUnexploredByte);
    colours[static_cast<std::size_t>(i)] = Mix(overview_colour::kUnexplored, overview_colour::kFree, share);
  }
  return colours;
}

}  // namespace

double OverviewScale::StepM() const {
  const double shortest_m = Enlarge(100) / pixels_per_m;
  const double decade_m = std::pow(10.0, std::floor(std::log10(shortest_m)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade_m >= shortest_m) return factor * decade_m;
  }
  return 10.0 * decade_m;
}

MapPanel::MapPanel(const DenseGrid& grid)
    : grid_(grid), geometry_(grid.cell_size_m), pixels_per_cell_(ComputePixelsPerCell(grid)) {
  const auto ToPixels = [&](int cells) { return std::max(1, static_cast<int>(std::lround(cells * pixels_per_cell_))); };
  const cv::Size size(ToPixels(grid.width_cells), ToPixels(grid.height_cells));
  scale_.enlargement = std::max(1.0, static_cast<double>(std::max(size.width, size.height)) / kWantedSide);
  scale_.pixels_per_m = geometry_.ToCells(1.0) * pixels_per_cell_;
  const int left = scale_.Enlarge(kLeftMargin);
  const int top = scale_.Enlarge(kOtherMargin);
  const int width = std::max(size.width + left + top, scale_.Enlarge(kMinWidth));
  const int height = std::max(size.height + top + scale_.Enlarge(kLowerMargin), scale_.Enlarge(kMinHeight));
  map_ = cv::Rect(
      cv::Point((width + left - top - size.width) / 2, (height - scale_.Enlarge(kLowerMargin) + top - size.height) / 2),
      size);
  origin_ = {map_.x - grid.origin_x_cells * pixels_per_cell_,
             map_.y + (grid.origin_y_cells + grid.height_cells) * pixels_per_cell_};
  image_.create(height + scale_.Enlarge(kRoomForCaption), width, CV_8UC3);
  image_.resize(static_cast<std::size_t>(height));  // the caption is added without a copy
  DrawFloor();
  for (const cv::Rect& side :
       {cv::Rect(0, 0, width, map_.y), cv::Rect(0, map_.br().y, width, height - map_.br().y),
        cv::Rect(0, map_.y, map_.x, map_.height), cv::Rect(map_.br().x, map_.y, width - map_.br().x, map_.height)}) {
    image_(side) = overview_colour::kUnexplored;
  }
}

void MapPanel::DrawFloor() {
  // OpenCV takes no const data; it is only read.
  const cv::Mat cells(grid_.height_cells, grid_.width_cells, CV_8UC1, const_cast<std::uint8_t*>(grid_.cells.data()));
  cv::Mat floor;
  cv::resize(cells, floor, map_.size(), 0.0, 0.0, pixels_per_cell_ < 1.0 ? cv::INTER_AREA : cv::INTER_NEAREST);
  const std::array<Colour, 256> colours = FloorColours();
  for (int y = 0; y < floor.rows; ++y) {  // y up
    const std::uint8_t* row = floor.ptr<std::uint8_t>(y);
    std::transform(row, row + floor.cols, image_.ptr<Colour>(map_.br().y - 1 - y) + map_.x,
                   [&](std::uint8_t byte) { return colours[byte]; });
  }
}

void MapPanel::DrawDoubts(const std::vector<Doubt>& doubts, double most_m) {
  cv::Mat is_elsewhere(map_.size(), CV_8UC1, cv::Scalar(255));
  const cv::Rect inside(cv::Point(0, 0), map_.size());
  const auto PixelOf = [&](const Doubt& doubt) { return ToPixels({doubt.at.x_m, doubt.at.y_m}) - map_.tl(); };
  for (const Doubt& doubt : doubts) {
    if (inside.contains(PixelOf(doubt))) is_elsewhere.at<std::uint8_t>(PixelOf(doubt)) = 0;
  }
  cv::Mat distances, nearest;
  cv::distanceTransform(is_elsewhere, distances, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<int> shares(doubts.size() + 1, 0);  // by label, in 1/256
  for (const Doubt& doubt : doubts) {
    if (!inside.contains(PixelOf(doubt))) continue;
    int& share = shares[static_cast<std::size_t>(nearest.at<int>(PixelOf(doubt)))];
    share = std::max(share, static_cast<int>(256 * kDeepestDoubt * std::min(doubt.off_m / most_m, 1.0)));
  }
  const Colour unexplored = Mix(overview_colour::kUnexplored, overview_colour::kFree, 0.0);
  const cv::Vec3i colour = ToIntegers(overview_colour::kDoubt);
  for (int y = 0; y < map_.height; ++y) {
    Colour* pixels = image_.ptr<Colour>(map_.y + y) + map_.x;
    for (int x = 0; x < map_.width; ++x) {
      if (pixels[x] != unexplored) Cover(colour, shares[static_cast<std::size_t>(nearest.at<int>(y, x))], pixels[x]);
    }
  }
}

/// Each pixel that holds a bit of an occupied cell shows it: walls of a map that is shrunk stay.
void MapPanel::DrawWalls() {
  const cv::Vec3i colour = ToIntegers(overview_colour::kWall);
  const auto Begin = [&](int cells) { return static_cast<int>(cells * pixels_per_cell_); };
  for (int row = 0; row < grid_.height_cells; ++row) {
    const std::uint8_t* cells = &grid_.cells[grid_.IndexOf(0, row)];
    const int first_y = std::min(Begin(row), map_.height - 1);
    const int end_y = std::max(first_y + 1, Begin(row + 1));
    for (int column = 0; column < grid_.width_cells; ++column) {
      if (!IsOccupied(cells[column])) continue;
      const int share = (kUnexploredByte - cells[column]) * 256 / kUnexploredByte;
      const int first_x = std::min(Begin(column), map_.width - 1);
      const int end_x = std::max(first_x + 1, Begin(column + 1));
      for (int y = first_y; y < end_y; ++y) {
        Colour* pixels = image_.ptr<Colour>(map_.br().y - 1 - y) + map_.x;
        for (int x = first_x; x < end_x; ++x) Cover(colour, share, pixels[x]);
      }
    }
  }
}

void MapPanel::GoTo(const cv::Point2d& point_m) {
  const cv::Point point = ToSubpixels(point_m);
  if (path_end_ && *path_end_ != point) {
    cv::line(image_, *path_end_, point, overview_colour::kPath, scale_.ThinLine(), cv::LINE_AA, kSubpixelBits);
  }
  path_end_ = point;
}

void MapPanel::DrawPairs(const std::vector<PointPair>& pairs, const PairStyle& style) {
  if (pairs.empty()) return;
  std::vector<cv::Point> ends;
  for (const PointPair& pair : pairs) {
    ends.push_back(ToPixels(pair.from_m));
    ends.push_back(ToPixels(pair.to_m));
  }
  const int rim = scale_.Enlarge(style.dot_radius) + 2;
  const cv::Rect box = cv::boundingRect(ends);
  const cv::Rect touched = cv::Rect(box.tl() - cv::Point(rim, rim), box.br() + cv::Point(rim, rim)) &
                           cv::Rect(cv::Point(0, 0), image_.size());
  if (touched.empty()) return;
  cv::Mat mask = cv::Mat::zeros(touched.size(), CV_8UC1);
  const double strength = pairs.size() > kManyPairs ? 0.5 : 1.0;
  for (const PointPair& pair : pairs) {
    DrawPair(pair, style.dashed, strength * style.dot_radius, touched.tl() * (1 << kSubpixelBits), mask);
  }
  Cover(mask, style.colour, strength * style.opacity, image_(touched));
}

/// A pair that is shorter than its dots is a dot.
void MapPanel::DrawPair(const PointPair& pair, bool dashed, double dot_radius, const cv::Point& corner,
                        cv::Mat& mask) const {
  constexpr int kDash = 7;  // pixels, to be enlarged
  constexpr int kMostDashes = 1000;
  const cv::Point from = ToSubpixels(pair.from_m) - corner;
  const cv::Point to = ToSubpixels(pair.to_m) - corner;
  const double dash = scale_.Enlarge(kDash) * (1 << kSubpixelBits);
  const int num_parts = dashed ? std::clamp(static_cast<int>(cv::norm(to - from) / dash), 1, kMostDashes) | 1 : 1;
  for (int i = 0; i < num_parts; i += 2) {
    cv::line(mask, from + (to - from) * (static_cast<double>(i) / num_parts),
             from + (to - from) * (static_cast<double>(i + 1) / num_parts), 255, scale_.ThinLine(), cv::LINE_AA,
             kSubpixelBits);
  }
  const auto radius = static_cast<int>(std::lround(scale_.enlargement * dot_radius * (1 << kSubpixelBits)));
  for (const cv::Point& end : {from, to}) cv::circle(mask, end, radius, 255, cv::FILLED, cv::LINE_AA, kSubpixelBits);
}

void MapPanel::DrawDisc(const cv::Point2d& centre_m, double radius_pixels, const cv::Scalar& colour) {
  const auto radius = static_cast<int>(std::lround(scale_.enlargement * radius_pixels * (1 << kSubpixelBits)));
  cv::circle(image_, ToSubpixels(centre_m), radius, colour, cv::FILLED, cv::LINE_AA, kSubpixelBits);
}

void MapPanel::DrawHit(const cv::Point2d& place_m) {
  DrawDisc(place_m, std::max(3.0, 0.75 * pixels_per_cell_), overview_colour::kHit);
}

void MapPanel::DrawCross(const cv::Point2d& centre_m, const cv::Scalar& colour) {
  const cv::Point centre = ToSubpixels(centre_m);
  const int arm = scale_.Enlarge(8) << kSubpixelBits;
  for (const cv::Point& end : {cv::Point(arm, arm), cv::Point(arm, -arm)}) {
    cv::line(image_, centre - end, centre + end, colour, scale_.Enlarge(2), cv::LINE_AA, kSubpixelBits);
  }
}

void MapPanel::DrawChange(const MapChange& change) {
  const cv::Scalar& colour = change.kind == ChangeKind::kNew ? overview_colour::kNew : overview_colour::kGone;
  const auto [sin, cos] = ComputeSinCos(change.yaw_rad);
  const cv::Point2d along(0.5 * change.length_m * cos, 0.5 * change.length_m * sin);
  const cv::Point2d across(-0.5 * change.width_m * sin, 0.5 * change.width_m * cos);
  const cv::Point2d middle(change.middle.x_m, change.middle.y_m);
  std::vector<cv::Point> corners;
  for (const cv::Point2d& corner :
       {middle + along + across, middle - along + across, middle - along - across, middle + along - across}) {
    corners.push_back(ToSubpixels(corner));
  }
  cv::Mat mask = cv::Mat::zeros(image_.size(), CV_8UC1);
  constexpr double kOpacity = 0.3;
  cv::fillPoly(mask, std::vector{corners}, cv::Scalar(255), cv::LINE_AA, kSubpixelBits);
  Cover(mask, colour, kOpacity, image_);
  cv::polylines(image_, std::vector{corners}, true, colour, scale_.Enlarge(2), cv::LINE_AA, kSubpixelBits);
}

void MapPanel::DrawRing(const cv::Point2d& centre_m) {
  cv::circle(image_, ToSubpixels(centre_m), scale_.Enlarge(22) << kSubpixelBits, overview_colour::kDoubt,
             scale_.Enlarge(2), cv::LINE_AA, kSubpixelBits);
}

void MapPanel::DrawOrigin() {
  const cv::Point origin = ToPixels({0.0, 0.0});
  const int arm = scale_.Enlarge(34);
  for (const auto& [end, name] : {std::pair(cv::Point(arm, 0), "x"), {cv::Point(0, -arm), "y"}}) {
    cv::arrowedLine(image_, origin, origin + end, overview_colour::kInk, scale_.Enlarge(1), cv::LINE_AA, 0, 0.2);
    cv::putText(image_, name, origin + end + cv::Point(scale_.Enlarge(4), scale_.Enlarge(-2)), cv::FONT_HERSHEY_SIMPLEX,
                kLetters * scale_.enlargement, overview_colour::kInk, scale_.Enlarge(1), cv::LINE_AA);
  }
}

void MapPanel::DrawLabel(const cv::Point2d& place_m, const std::string& text, const cv::Scalar& colour) {
  const cv::Point at = ToPixels(place_m) + cv::Point(scale_.Enlarge(12), scale_.Enlarge(-8));
  // A pale rim, to be read on walls too.
  for (const auto& [rim, ink] : {std::pair(scale_.Enlarge(4), overview_colour::kFree), {scale_.Enlarge(1), colour}}) {
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, kLetters * scale_.enlargement, ink, rim, cv::LINE_AA);
  }
}

void MapPanel::DrawRulers() {
  DrawRulerOfX();
  DrawRulerOfY();
}

void MapPanel::DrawRulerOfX() {
  const double step_m = scale_.StepM();
  const double step = step_m * scale_.pixels_per_m;
  const int left = scale_.Enlarge(kLeftMargin);
  for (int i = static_cast<int>(std::ceil((left - origin_.x) / step)); origin_.x + i * step < image_.cols; ++i) {
    const int x = static_cast<int>(origin_.x + i * step);
    cv::line(image_, {x, image_.rows - scale_.Enlarge(9)}, {x, image_.rows}, overview_colour::kRuler,
             scale_.Enlarge(1));
    const std::string text = fmt::format("{:g} m", i * step_m);
    const double letters = kLetters * scale_.enlargement;
    const int width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, letters, 1, nullptr).width;
    if (x + width / 2 + scale_.Enlarge(4) > image_.cols) continue;
    cv::putText(image_, text, {x - width / 2, image_.rows - scale_.Enlarge(15)}, cv::FONT_HERSHEY_SIMPLEX, letters,
                overview_colour::kRuler, scale_.Enlarge(1), cv::LINE_AA);
  }
}

void MapPanel::DrawRulerOfY() {
  const double step_m = scale_.StepM();
  const double step = step_m * scale_.pixels_per_m;
  const int bottom = image_.rows - scale_.Enlarge(kLowerMargin);
  for (int i = static_cast<int>(std::ceil((origin_.y - bottom) / step)); origin_.y - i * step >= scale_.Enlarge(10);
       ++i) {
    const int y = static_cast<int>(origin_.y - i * step);
    cv::line(image_, {0, y}, {scale_.Enlarge(9), y}, overview_colour::kRuler, scale_.Enlarge(1));
    cv::putText(image_, fmt::format("{:g} m", i * step_m), {scale_.Enlarge(14), y + scale_.Enlarge(5)},
                cv::FONT_HERSHEY_SIMPLEX, kLetters * scale_.enlargement, overview_colour::kRuler, scale_.Enlarge(1),
                cv::LINE_AA);
  }
}

cv::Point MapPanel::ToSubpixels(const cv::Point2d& point_m) const {
  // The limit keeps a point far outside within OpenCV's integers. A pixel's centre is at its whole number.
  const auto ToInteger = [](double pixels) {
    return static_cast<int>(std::lround((std::clamp(pixels, -1e5, 1e5) - 0.5) * (1 << kSubpixelBits)));
  };
  return {ToInteger(origin_.x + point_m.x * scale_.pixels_per_m),
          ToInteger(origin_.y - point_m.y * scale_.pixels_per_m)};
}

cv::Point MapPanel::ToPixels(const cv::Point2d& point_m) const {
  const cv::Point subpixels = ToSubpixels(point_m);
  return {subpixels.x >> kSubpixelBits, subpixels.y >> kSubpixelBits};
}

}  // namespace crsm
