#pragma once

#include <cmath>
#include <opencv2/core.hpp>

namespace crsm {

/// Red, green, blue; of the path and what lies on it, as on the page of map_viewer. Floor, walls and what is unexplored
/// differ in grey too, for those who print or see no colours.
namespace overview_colour {
inline const cv::Scalar kFree(255, 255, 255);
inline const cv::Scalar kUnexplored(186, 199, 215);  // contrast to kFree 1.7 (WCAG 2.1)
inline const cv::Scalar kWall(22, 26, 34);
inline const cv::Scalar kPath(0, 102, 204);
inline const cv::Scalar kStart(0, 140, 60);
inline const cv::Scalar kEnd(224, 142, 0);
inline const cv::Scalar kLost(192, 27, 48);
inline const cv::Scalar kHit(0, 150, 129);
inline const cv::Scalar kLoop(192, 27, 148);
inline const cv::Scalar kRejected(165, 80, 20);
inline const cv::Scalar kJoin(110, 40, 190);
inline const cv::Scalar kBreak(192, 27, 48);
inline const cv::Scalar kMark(200, 10, 110);
inline const cv::Scalar kDoubt(148, 88, 0);  // where the map may be off
inline const cv::Scalar kNew(0, 150, 50);
inline const cv::Scalar kGone(215, 25, 40);
inline const cv::Scalar kGood(20, 115, 60);
inline const cv::Scalar kDoubtful(165, 95, 0);
inline const cv::Scalar kBad(175, 25, 30);
inline const cv::Scalar kRuler(70, 84, 104);
inline const cv::Scalar kInk(30, 34, 44);
inline const cv::Scalar kPaper(247, 242, 230);  // of the caption: nothing of the map has it
}  // namespace overview_colour

/// How large things are in the overview. Lines and letters of a large picture are as large in it as those of a smaller
/// one: both are seen on one screen.
struct OverviewScale {
  double enlargement = 1.0;   ///< at least 1
  double pixels_per_m = 1.0;  ///< of the map

  int Enlarge(double pixels) const { return static_cast<int>(std::lround(pixels * enlargement)); }
  /// Of the path and of loops, in pixels: as little as is still seen where a large picture is shrunk to a screen.
  int ThinLine() const { return enlargement > 1.5 ? 2 : 1; }
  /// 1, 2 or 5 times a power of ten metres, and at least 100 pixels, to be enlarged.
  double StepM() const;
};

/// How pairs of places are drawn.
struct PairStyle {
  cv::Scalar colour;
  double opacity = 1.0;     ///< (0, 1]
  double dot_radius = 2.5;  ///< pixels, to be enlarged
  bool dashed = false;
};

}  // namespace crsm
