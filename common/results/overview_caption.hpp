#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/results/overview_style.hpp"

namespace crsm {

/// What explains a sign of the picture.
struct LegendItem {
  enum class Sign : std::int8_t { kSquare, kDisc, kLine, kPair, kDashes, kCross, kRing };
  Sign sign = Sign::kSquare;
  cv::Scalar colour;
  std::string text;
};

/// The words below the overview's map.
struct OverviewCaption {
  std::string badge;        ///< the verdict in a word or two
  cv::Scalar badge_colour;  ///< dark: the letters on it are white
  std::string title;
  std::string headline;
  std::vector<std::string> lines;
  std::vector<std::string> warnings;
  std::vector<LegendItem> legend;
};

/// A picture of that, as high as the words need.
cv::Mat DrawCaption(const OverviewCaption& caption, int width, const OverviewScale& scale);

}  // namespace crsm
