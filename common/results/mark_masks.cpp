#include "common/results/mark_masks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/results/png.hpp"

namespace crsm {
namespace {

struct Mask {
  const char* name;  ///< of its files
  const char* kind;
  const char* mode;
  std::uint8_t outside;
  std::uint8_t inside;
};

// map_server makes of a pixel v: in the mode scale, 100 (255 - v) / 255 between its two thresholds; in the mode raw, v.
constexpr Mask kMasks[]{{"keepout", kKeepOutKind, "scale", 255, 0}, {"slow", kSlowKind, "raw", 0, kSlowPercent}};

cv::Mat DrawMask(const DenseGrid& grid, const std::vector<const PlacedMark*>& zones, const Mask& mask) {
  constexpr int kShift = 4;  // bits below a pixel
  static constexpr double kFarthest_cells = 1e6;
  cv::Mat picture(grid.height_cells, grid.width_cells, CV_8UC1, cv::Scalar(mask.outside));
  for (const PlacedMark* zone : zones) {
    std::vector<cv::Point> corners;
    for (const auto& [x_m, y_m] : zone->points) {
      const double column = x_m / grid.cell_size_m - grid.origin_x_cells - 0.5;
      const double row = grid.height_cells - 1 - (y_m / grid.cell_size_m - grid.origin_y_cells - 0.5);
      const auto ToSubpixels = [](double at) {
        return static_cast<int>(std::lround(std::clamp(at, -kFarthest_cells, kFarthest_cells) * (1 << kShift)));
      };
      corners.emplace_back(ToSubpixels(column), ToSubpixels(row));
    }
    cv::fillPoly(picture, std::vector<std::vector<cv::Point>>{corners}, cv::Scalar(mask.inside), cv::LINE_8, kShift);
  }
  return picture;
}

}  // namespace

void AddMasks(const DenseGrid& grid, const std::vector<PlacedMark>& marks, Replacement& files,
              const std::string& suffix) {
  for (const Mask& mask : kMasks) {
    std::vector<const PlacedMark*> zones;
    for (const PlacedMark& mark : marks) {
      if (mark.kind == mask.kind && mark.is_outline() && !mark.floating) zones.push_back(&mark);
    }
    if (zones.empty()) continue;
    const cv::Mat picture = DrawMask(grid, zones, mask);
    const std::string name = mask.name + suffix;
    files.Write(name + ".png", EncodePng({picture.cols, picture.rows, 1, picture.data}));
    files.Write(name + ".yaml", fmt::format("image: {}.png\n"
                                            "mode: {}\n"
                                            "resolution: {}\n"
                                            "origin: [{:.6f}, {:.6f}, 0.0]\n"
                                            "negate: 0\n"
                                            "occupied_thresh: 0.65\n"
                                            "free_thresh: 0.196\n",
                                            name, mask.mode, grid.cell_size_m, grid.origin_x_cells * grid.cell_size_m,
                                            grid.origin_y_cells * grid.cell_size_m));
  }
}

}  // namespace crsm
