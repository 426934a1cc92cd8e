#include "common/results/rescue_map.hpp"

#include <geotiff/geotiffio.h>
#include <geotiff/xtiffio.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>
#include <tiffio.hxx>

namespace crsm {
namespace {

// Red, green, blue.
using Colour = cv::Vec3b;
const Colour kUnexplored[]{{226, 226, 227}, {237, 237, 238}};  // a checker of 1 m
const Colour kExplored(255, 255, 255);
const Colour kGridLine(190, 190, 191);  // every half metre
const Colour kWall(0, 40, 120);
const cv::Scalar kPath(120, 0, 140);
const cv::Scalar kStart(255, 200, 0);
const cv::Scalar kVictim(240, 10, 10);
const cv::Scalar kHazard(255, 100, 30);
const cv::Scalar kInk(0, 50, 140);  // scale, axes, names
const cv::Scalar kWhite(255, 255, 255);

constexpr double kMargin_m = 2.0;
constexpr double kGridStep_m = 0.5;
constexpr double kTextSize = 0.5;  // of names

/// The picture, in pixels from its upper left corner.
class RescuePicture {
 public:
  explicit RescuePicture(const DenseGrid& grid) : grid_(grid) {
    constexpr double kFinest = 50.0;  // pixels of a metre
    constexpr double kMostPixels = 5000.0;
    left_m_ = std::floor(grid.origin_x_cells * grid.cell_size_m) - kMargin_m;
    top_m_ = std::ceil((grid.origin_y_cells + grid.height_cells) * grid.cell_size_m) + kMargin_m;
    const double width_m = std::ceil((grid.origin_x_cells + grid.width_cells) * grid.cell_size_m) + kMargin_m - left_m_;
    const double height_m = top_m_ - std::floor(grid.origin_y_cells * grid.cell_size_m) + kMargin_m;
    per_m_ = std::min(kFinest, kMostPixels / std::max(width_m, height_m));
    const auto ToPixels = [&](double size_m) { return std::max(1, static_cast<int>(std::lround(size_m * per_m_))); };
    image_.create(ToPixels(height_m), ToPixels(width_m), CV_8UC3);
    DrawFloor();
  }

  const cv::Mat& image() const { return image_; }
  double left_m() const { return left_m_; }
  double top_m() const { return top_m_; }
  double per_m() const { return per_m_; }

  void DrawWalls() {
    for (int row = 0; row < grid_.height_cells; ++row) {
      for (int column = 0; column < grid_.width_cells; ++column) {
        if (!IsOccupied(grid_.cells[grid_.IndexOf(column, row)])) continue;
        const double x_m = (grid_.origin_x_cells + column) * grid_.cell_size_m;
        const double y_m = (grid_.origin_y_cells + row) * grid_.cell_size_m;
        const cv::Point low = At(x_m, y_m + grid_.cell_size_m);
        const cv::Point high = At(x_m + grid_.cell_size_m, y_m);
        const cv::Rect cell(low, cv::Size(std::max(1, high.x - low.x), std::max(1, high.y - low.y)));
        image_(cell & cv::Rect({}, image_.size())).setTo(kWall);
      }
    }
  }

  void DrawPath(const RescuePath& path) {
    for (const auto& stretch : path.stretches()) {
      std::vector<cv::Point> line;
      for (const Pose2& pose : stretch) line.push_back(At(pose.x_m, pose.y_m));
      cv::polylines(image_, line, false, kPath, per_m_ > 20.0 ? 2 : 1);
    }
    if (path.stretches().empty()) return;
    const Pose2& start = path.stretches().front().front();
    const double size_m = std::max(0.5, 16.0 / per_m_);
    const auto Corner = [&](double ahead, double left) {
      const Pose2 at = start * Pose2{ahead * size_m, left * size_m, 0.0};
      return At(at.x_m, at.y_m);
    };
    cv::fillConvexPoly(image_, std::vector<cv::Point>{Corner(0.7, 0.0), Corner(-0.5, 0.4), Corner(-0.5, -0.4)}, kStart);
  }

  /// A disc with a number.
  void DrawNumbered(const Point& at, int number, const cv::Scalar& colour) {
    const int radius = std::max(10, static_cast<int>(0.2 * per_m_));
    const cv::Point centre = At(at.x_m, at.y_m);
    cv::circle(image_, centre, radius, colour, cv::FILLED);
    const std::string text = std::to_string(number);
    const double scale = 1.1 * radius / (22.0 * std::max<double>(1.0, 0.7 * static_cast<double>(text.size())));
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 2, nullptr);
    cv::putText(image_, text, {centre.x - size.width / 2, centre.y + size.height / 2}, cv::FONT_HERSHEY_SIMPLEX, scale,
                kWhite, 2);
  }

  void DrawNamed(const PlacedMark& mark) {
    std::vector<cv::Point> corners;
    for (const auto& [x_m, y_m] : mark.points) corners.push_back(At(x_m, y_m));
    if (mark.is_outline()) {
      cv::polylines(image_, corners, true, kInk, 2);
    } else {
      cv::circle(image_, corners.front(), 4, kInk, 2);
    }
    const Point middle = MiddleOf(mark);
    const std::string& text = mark.name.empty() ? mark.kind : mark.name;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kTextSize, 1, nullptr);
    const cv::Point beside = mark.is_outline() ? cv::Point(-size.width / 2, size.height / 2) : cv::Point(6, -6);
    DrawText(text, At(middle.x_m, middle.y_m) + beside, kTextSize);
  }

  void DrawText(const std::string& text, const cv::Point& at, double size) {
    cv::putText(image_, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  }

  /// In the margin: the title, a scale of a metre, and where x and y point.
  void DrawLegend(const std::string& title) {
    const int margin = static_cast<int>(kMargin_m * per_m_);
    const double size = std::clamp(per_m_ / 50.0, 0.4, 1.0);
    DrawText(title, {margin / 4, margin / 2}, size);
    const int metre = static_cast<int>(std::lround(per_m_));
    const cv::Point low(image_.cols - margin / 4, image_.rows - margin / 4);
    const cv::Point ends[]{{low.x - metre, low.y}, low};
    cv::line(image_, ends[0], ends[1], kInk, 2);
    for (const cv::Point& end : ends) cv::line(image_, end - cv::Point(0, 4), end + cv::Point(0, 4), kInk, 2);
    DrawText("1 m", ends[0] - cv::Point(0, 8), 0.8 * size);
    const cv::Point corner(margin / 4, image_.rows - margin / 4);
    cv::arrowedLine(image_, corner, corner + cv::Point(metre, 0), kInk, 2);
    cv::arrowedLine(image_, corner, corner - cv::Point(0, metre), kInk, 2);
    DrawText("x", corner + cv::Point(metre, -6), 0.8 * size);
    DrawText("y", corner + cv::Point(6, -metre), 0.8 * size);
  }

 private:
  cv::Point At(double x_m, double y_m) const {
    static constexpr double kFarthest = 1e6;
    const auto ToPixel = [](double at) {
      return static_cast<int>(std::floor(std::clamp(at, -kFarthest, kFarthest) + 1e-6));
    };
    return {ToPixel((x_m - left_m_) * per_m_), ToPixel((top_m_ - y_m) * per_m_)};
  }

  /// Whether somewhere between two pixels' lower edges there is a line of the grid.
  static bool CrossesGrid(double from_m, double to_m) {
    return std::floor(from_m / kGridStep_m + 1e-6) != std::floor(to_m / kGridStep_m + 1e-6);
  }

  void DrawFloor() {
    const bool has_room = kGridStep_m * per_m_ >= 6.0;  // else lines would be all that is seen
    const double pixel_m = 1.0 / per_m_;
    for (int row = 0; row < image_.rows; ++row) {
      const double y_m = top_m_ - (row + 0.5) * pixel_m;
      const int cell_y = static_cast<int>(std::floor(y_m / grid_.cell_size_m)) - grid_.origin_y_cells;
      const bool is_line = has_room && CrossesGrid(y_m - 0.5 * pixel_m, y_m + 0.5 * pixel_m);
      for (int column = 0; column < image_.cols; ++column) {
        const double x_m = left_m_ + (column + 0.5) * pixel_m;
        const int cell_x = static_cast<int>(std::floor(x_m / grid_.cell_size_m)) - grid_.origin_x_cells;
        const bool is_inside = cell_x >= 0 && cell_y >= 0 && cell_x < grid_.width_cells && cell_y < grid_.height_cells;
        const bool is_explored = is_inside && grid_.cells[grid_.IndexOf(cell_x, cell_y)] != kUnexploredByte;
        Colour& pixel = image_.at<Colour>(row, column);
        if (!is_explored) {
          const auto square = static_cast<std::int64_t>(std::floor(x_m)) + static_cast<std::int64_t>(std::floor(y_m));
          pixel = kUnexplored[square & 1];
        } else {
          const bool on_line = is_line || (has_room && CrossesGrid(x_m - 0.5 * pixel_m, x_m + 0.5 * pixel_m));
          pixel = on_line ? kGridLine : kExplored;
        }
      }
    }
  }

  const DenseGrid& grid_;
  double left_m_;
  double top_m_;
  double per_m_;
  cv::Mat image_;
};

[[noreturn]] void ThrowNotMade() {
  throw std::runtime_error("map.tif cannot be made: libtiff or libgeotiff refuses it");
}

/// In the map's frame, which is no frame of the earth: metres, right-handed.
void AddFrame(TIFF* tiff, const RescuePicture& picture) {
  const double pixel_m = 1.0 / picture.per_m();
  const double scale[]{pixel_m, pixel_m, 0.0};
  const double corner[]{0.0, 0.0, 0.0, picture.left_m(), picture.top_m(), 0.0};
  TIFFSetField(tiff, TIFFTAG_GEOPIXELSCALE, 3, scale);
  TIFFSetField(tiff, TIFFTAG_GEOTIEPOINTS, 6, corner);
  const std::unique_ptr<GTIF, decltype(&GTIFFree)> keys(GTIFNew(tiff), GTIFFree);
  if (!keys) ThrowNotMade();
  GTIFKeySet(keys.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, ModelTypeProjected);
  GTIFKeySet(keys.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  GTIFKeySet(keys.get(), GTCitationGeoKey, TYPE_ASCII, 0, "frame of the map, metres");
  GTIFKeySet(keys.get(), ProjectedCSTypeGeoKey, TYPE_SHORT, 1, KvUserDefined);
  GTIFKeySet(keys.get(), ProjLinearUnitsGeoKey, TYPE_SHORT, 1, Linear_Meter);
  if (GTIFWriteKeys(keys.get()) == 0) ThrowNotMade();
}

std::string EncodeGeoTiff(const RescuePicture& picture) {
  XTIFFInitialize();
  std::ostringstream bytes;
  std::unique_ptr<TIFF, decltype(&XTIFFClose)> tiff(TIFFStreamOpen("map.tif", static_cast<std::ostream*>(&bytes)),
                                                    XTIFFClose);
  if (!tiff) ThrowNotMade();
  const cv::Mat& image = picture.image();
  const auto Set = [&](std::uint32_t tag, auto value) { TIFFSetField(tiff.get(), tag, value); };
  Set(TIFFTAG_IMAGEWIDTH, image.cols);
  Set(TIFFTAG_IMAGELENGTH, image.rows);
  Set(TIFFTAG_BITSPERSAMPLE, 8);
  Set(TIFFTAG_SAMPLESPERPIXEL, 3);
  Set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  Set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  Set(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  Set(TIFFTAG_COMPRESSION, COMPRESSION_LZW);
  Set(TIFFTAG_ROWSPERSTRIP, 64);
  AddFrame(tiff.get(), picture);
  for (int row = 0; row < image.rows; ++row) {
    const std::uint8_t* pixels = image.ptr(row);
    std::vector<std::uint8_t> copy(pixels, pixels + std::size_t{3} * static_cast<std::size_t>(image.cols));
    if (TIFFWriteScanline(tiff.get(), copy.data(), static_cast<std::uint32_t>(row), 0) != 1) ThrowNotMade();
  }
  tiff.reset();
  return std::move(bytes).str();
}

}  // namespace

void RescuePath::Add(const Pose2& T_map_laser) {
  constexpr double kStep_m = 0.05;
  constexpr double kJump_m = 2.0;
  const bool jumps = stretches_.empty() || Distance(stretches_.back().back(), T_map_laser) > kJump_m;
  if (jumps) stretches_.emplace_back();
  if (!jumps && Distance(stretches_.back().back(), T_map_laser) < kStep_m) return;
  stretches_.back().push_back(T_map_laser);
}

std::string EncodeRescueMap(const RescueMap& map) {
  RescuePicture picture(map.grid);
  picture.DrawPath(map.path);
  picture.DrawWalls();
  int num_victims = 0;
  int num_hazards = 0;
  for (const PlacedMark& mark : map.marks) {
    if (mark.floating) continue;
    if (mark.kind == "victim") {
      picture.DrawNumbered(MiddleOf(mark), ++num_victims, kVictim);
    } else if (mark.kind == "hazard") {
      picture.DrawNumbered(MiddleOf(mark), ++num_hazards, kHazard);
    } else {
      picture.DrawNamed(mark);
    }
  }
  picture.DrawLegend(map.title);
  return EncodeGeoTiff(picture);
}

}  // namespace crsm
