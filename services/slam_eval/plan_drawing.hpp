#pragma once

#include <string>
#include <vector>

#include "common/plan/plan.hpp"

namespace crsm {

enum class DrawingKind { kSvg, kPdf };

/// How a plan lies on paper.
struct PaperLayout {
  double width_mm = 0.0;
  double height_mm = 0.0;
  int scale = 0;  ///< 1:scale
};

/// A sheet, upright.
struct Paper {
  std::string name;
  double width_mm = 0.0;
  double height_mm = 0.0;
};

/// "a4" or "a3". Throws UsageError if it is neither.
Paper ParsePaper(const std::string& name);

/// Upright or lying, at the largest usual scale that fits. scale: 0 for that, or the one that is wanted. Throws
/// UsageError if that does not fit.
PaperLayout LayOut(const Plan& plan, const Paper& paper, int scale);

/// The plan as a page: walls with their lengths, doors, rooms with their areas, a bar of the scale, and a block with
/// the lines of `title`. Returns the bytes of the file. Throws std::runtime_error if it cannot be drawn.
std::string DrawPlan(const Plan& plan, const PaperLayout& layout, const std::vector<std::string>& title,
                     DrawingKind kind);

}  // namespace crsm
