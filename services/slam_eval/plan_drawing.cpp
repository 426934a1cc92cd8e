#include "services/slam_eval/plan_drawing.hpp"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;
constexpr double kMargin_mm = 10.0;
constexpr double kTitle_mm = 26.0;  ///< of the block below the plan
constexpr double kAround_mm = 6.0;  ///< for lengths at the outer walls

struct Size {
  double width = 0.0;
  double height = 0.0;
};

/// What of a page is for the plan.
Size RoomOnPage(const Size& page_mm) {
  return {page_mm.width - 2.0 * (kMargin_mm + kAround_mm),
          page_mm.height - 2.0 * (kMargin_mm + kAround_mm) - kTitle_mm};
}

/// Turned so that its main direction lies along the page.
class TurnedPlan {
 public:
  explicit TurnedPlan(const Plan& plan) {
    const double direction = plan.directions_rad.empty() ? 0.0 : plan.directions_rad.front();
    turn_ = ComputeSinCos(direction > kPi / 4.0 ? kPi / 2.0 - direction : -direction);
    for (const PlanWall& wall : plan.walls) {
      for (const Point& at : {Turned(wall.from), Turned(wall.to)}) {
        least_ = {std::min(least_.x_m, at.x_m), std::min(least_.y_m, at.y_m)};
        most_ = {std::max(most_.x_m, at.x_m), std::max(most_.y_m, at.y_m)};
      }
    }
  }

  Point Turned(const Point& at) const {
    return {turn_.cos * at.x_m - turn_.sin * at.y_m, turn_.sin * at.x_m + turn_.cos * at.y_m};
  }
  Size size_m() const { return {std::max(0.0, most_.x_m - least_.x_m), std::max(0.0, most_.y_m - least_.y_m)}; }
  Point middle() const { return {0.5 * (least_.x_m + most_.x_m), 0.5 * (least_.y_m + most_.y_m)}; }

 private:
  SinCos turn_{};
  Point least_{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point most_{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

class Page {
 public:
  Page(const PaperLayout& layout, DrawingKind kind) {
    const auto Write = [](void* bytes, const unsigned char* data, unsigned int length) {
      static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
      return CAIRO_STATUS_SUCCESS;
    };
    const double width = layout.width_mm * kPointsPerMm;
    const double height = layout.height_mm * kPointsPerMm;
    surface_.reset(kind == DrawingKind::kSvg ? cairo_svg_surface_create_for_stream(Write, &bytes_, width, height)
                                             : cairo_pdf_surface_create_for_stream(Write, &bytes_, width, height));
    if (kind == DrawingKind::kSvg) cairo_svg_surface_set_document_unit(surface_.get(), CAIRO_SVG_UNIT_PT);
    cairo_.reset(cairo_create(surface_.get()));
    cairo_scale(cairo_.get(), kPointsPerMm, kPointsPerMm);
    SetGrey(1.0);
    cairo_paint(cairo_.get());
    cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  }

  void SetGrey(double grey) { cairo_set_source_rgb(cairo_.get(), grey, grey, grey); }
  void SetColour(double red, double green, double blue) { cairo_set_source_rgb(cairo_.get(), red, green, blue); }

  void Line(const Point& from, const Point& to, double width_mm) {
    cairo_set_line_width(cairo_.get(), width_mm);
    cairo_move_to(cairo_.get(), from.x_m, from.y_m);
    cairo_line_to(cairo_.get(), to.x_m, to.y_m);
    cairo_stroke(cairo_.get());
  }

  void Box(const Point& corner, const Size& size) {
    cairo_set_line_width(cairo_.get(), 0.25);
    cairo_rectangle(cairo_.get(), corner.x_m, corner.y_m, size.width, size.height);
    cairo_stroke(cairo_.get());
  }

  double WidthOf(const std::string& text, double height_mm) {
    cairo_set_font_size(cairo_.get(), height_mm);
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_.get(), text.c_str(), &extents);
    return extents.x_advance;
  }

  /// at: the middle of its base line.
  void CentredText(const Point& at, double height_mm, double yaw_rad, const std::string& text) {
    const double width = WidthOf(text, height_mm);
    cairo_save(cairo_.get());
    cairo_translate(cairo_.get(), at.x_m, at.y_m);
    cairo_rotate(cairo_.get(), yaw_rad);
    cairo_move_to(cairo_.get(), -0.5 * width, 0.0);
    cairo_show_text(cairo_.get(), text.c_str());
    cairo_restore(cairo_.get());
  }

  /// Made smaller where it would be wider than that.
  void Text(const Point& at, double height_mm, double most_mm, const std::string& text) {
    const double width = WidthOf(text, height_mm);
    cairo_set_font_size(cairo_.get(), width > most_mm ? height_mm * most_mm / width : height_mm);
    cairo_move_to(cairo_.get(), at.x_m, at.y_m);
    cairo_show_text(cairo_.get(), text.c_str());
  }

  std::string Finish() {
    cairo_show_page(cairo_.get());
    const cairo_status_t drawn = cairo_status(cairo_.get());
    cairo_surface_finish(surface_.get());
    const cairo_status_t written = cairo_surface_status(surface_.get());
    for (const cairo_status_t status : {drawn, written}) {
      if (status != CAIRO_STATUS_SUCCESS) {
        throw std::runtime_error(fmt::format("the plan cannot be drawn: {}", cairo_status_to_string(status)));
      }
    }
    return std::move(bytes_);
  }

 private:
  template <auto destroy>
  struct Destroy {
    void operator()(auto* made) const { destroy(made); }
  };
  std::string bytes_;
  std::unique_ptr<cairo_surface_t, Destroy<cairo_surface_destroy>> surface_;
  std::unique_ptr<cairo_t, Destroy<cairo_destroy>> cairo_;
};

void DrawTitle(const PaperLayout& layout, const std::vector<std::string>& title, Page& page) {
  const double top = layout.height_mm - kMargin_mm - kTitle_mm;
  const Size size{layout.width_mm - 2.0 * kMargin_mm, kTitle_mm};
  page.SetGrey(0.0);
  page.Box({kMargin_mm, top}, size);
  constexpr double kBar_mm = 50.0;
  double y = top + 6.0;
  for (std::size_t i = 0; i < title.size(); ++i) {
    page.Text({kMargin_mm + 3.0, y}, i == 0 ? 4.0 : 3.0, size.width - kBar_mm - 16.0, title[i]);
    y += 4.6;
  }
  // The longest round length that is no longer than the bar may be.
  double bar_m = 0.1;
  for (const double step : {0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    if (step * 1000.0 / layout.scale <= kBar_mm) bar_m = step;
  }
  const double bar_mm = bar_m * 1000.0 / layout.scale;
  const Point right{layout.width_mm - kMargin_mm - 4.0, top + 0.6 * kTitle_mm};
  page.Line({right.x_m - bar_mm, right.y_m}, right, 0.5);
  for (const double x : {right.x_m - bar_mm, right.x_m}) page.Line({x, right.y_m - 1.5}, {x, right.y_m + 1.5}, 0.3);
  page.CentredText({right.x_m - 0.5 * bar_mm, right.y_m - 2.5}, 3.0, 0.0, fmt::format("{:g} m", bar_m));
  page.CentredText({right.x_m - 0.5 * bar_mm, right.y_m + 5.0}, 3.0, 0.0, fmt::format("1:{}", layout.scale));
}

}  // namespace

Paper ParsePaper(const std::string& name) {
  if (name == "a4") return {name, 210.0, 297.0};
  if (name == "a3") return {name, 297.0, 420.0};
  throw UsageError(fmt::format("--paper {}: must be a4 or a3", name));
}

PaperLayout LayOut(const Plan& plan, const Paper& paper, int scale) {
  const Size upright{paper.width_mm, paper.height_mm};
  const Size lying{upright.height, upright.width};
  const Size size_m = TurnedPlan(plan).size_m();
  const auto LeastScale = [&](const Size& page) {
    const Size room = RoomOnPage(page);
    return std::max({1.0, 1000.0 * size_m.width / room.width, 1000.0 * size_m.height / room.height});
  };
  const Size& page = LeastScale(upright) < LeastScale(lying) ? upright : lying;
  const double least = LeastScale(page);
  if (scale == 0) {
    double usual = 1.0;  // 20, 25, 50, 100, 200, 250, 500 and so on
    for (double power = 10.0; usual < least || usual < 20.0; power *= 10.0) {
      for (const double step : {1.0, 2.0, 2.5, 5.0}) {
        if (usual < least || usual < 20.0) usual = step * power;
      }
    }
    return {page.width, page.height, static_cast<int>(usual)};
  }
  if (scale < least) {
    throw UsageError(fmt::format("--scale {}: on {} the plan of {:.1f} x {:.1f} m takes 1:{:.0f} or smaller", scale,
                                 paper.name, size_m.width, size_m.height, std::ceil(least)));
  }
  return {page.width, page.height, scale};
}

std::string DrawPlan(const Plan& plan, const PaperLayout& layout, const std::vector<std::string>& title,
                     DrawingKind kind) {
  const TurnedPlan turned(plan);
  const double mm_per_m = 1000.0 / layout.scale;
  const Point middle = turned.middle();
  const Point page_middle{0.5 * layout.width_mm, 0.5 * (layout.height_mm - kTitle_mm)};
  const auto OnPage = [&](const Point& at) -> Point {
    const Point there = turned.Turned(at);
    return {page_middle.x_m + (there.x_m - middle.x_m) * mm_per_m,
            page_middle.y_m - (there.y_m - middle.y_m) * mm_per_m};
  };
  Page page(layout, kind);
  for (const PlanDoor& door : plan.doors) {
    page.SetColour(0.1, 0.5, 0.2);
    page.Line(OnPage(door.from), OnPage(door.to), 0.2);
  }
  for (const PlanWall& wall : plan.walls) {
    const Point from = OnPage(wall.from);
    const Point to = OnPage(wall.to);
    page.SetGrey(0.0);
    page.Line(from, to, 0.4);
    constexpr double kText_mm = 1.8;
    const std::string text = fmt::format("{:.2f} ± {:.2f}", wall.length_m, BoundLengthError(plan, wall));
    const double length_mm = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
    if (length_mm < page.WidthOf(text, kText_mm) + 2.0) continue;
    double yaw = std::atan2(to.y_m - from.y_m, to.x_m - from.x_m);  // down the page is positive
    const double to_laser = yaw - kPi / 2.0;
    if (yaw > kPi / 2.0 - 0.01 || yaw <= -kPi / 2.0 - 0.01) yaw += kPi;  // to be read from below, or from the right
    const bool is_above = std::cos(to_laser - (yaw - kPi / 2.0)) > 0.0;
    const double off_mm = is_above ? 0.7 : -0.7 - 0.75 * kText_mm;
    page.SetGrey(0.35);
    page.CentredText(
        {0.5 * (from.x_m + to.x_m) + off_mm * std::sin(yaw), 0.5 * (from.y_m + to.y_m) - off_mm * std::cos(yaw)},
        kText_mm, yaw, text);
  }
  for (const PlanRoom& room : plan.rooms) {
    const Point at = OnPage(room.middle);
    const double side_mm = std::sqrt(room.area_m2) * mm_per_m;
    const double height_mm = std::clamp(0.2 * side_mm, 1.5, 3.5);
    page.SetColour(0.1, 0.25, 0.6);
    if (!room.name.empty()) page.CentredText({at.x_m, at.y_m - 0.2 * height_mm}, height_mm, 0.0, room.name);
    page.CentredText({at.x_m, at.y_m + height_mm}, height_mm, 0.0, fmt::format("{:.1f} m²", room.area_m2));
  }
  DrawTitle(layout, title, page);
  return page.Finish();
}

}  // namespace crsm
