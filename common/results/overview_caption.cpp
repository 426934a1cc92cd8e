#include "common/results/overview_caption.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace crsm {
namespace {

// Pixels, to be enlarged.
constexpr int kMargin = 18;
constexpr int kTitleHeight = 46;
constexpr int kLineHeight = 25;
constexpr int kSignWidth = 26;
constexpr int kSignRadius = 6;

/// How letters look.
struct Letters {
  int face = cv::FONT_HERSHEY_SIMPLEX;
  double size = 0.53;  ///< times OpenCV's, to be enlarged
  cv::Scalar colour = overview_colour::kInk;
};

const Letters kBody;
const Letters kHeadline{cv::FONT_HERSHEY_DUPLEX, 0.6};
const Letters kTitle{cv::FONT_HERSHEY_DUPLEX, 0.85};
const Letters kBadge{cv::FONT_HERSHEY_DUPLEX, 0.7, overview_colour::kFree};
const Letters kWarning{cv::FONT_HERSHEY_SIMPLEX, 0.53, {150, 30, 20}};

/// The caption while it is written, line by line.
class Sheet {
 public:
  Sheet(int width, const OverviewScale& scale) : width_(width), scale_(scale) { AddGap(kMargin / 2); }

  const cv::Mat& image() const { return image_; }

  void AddGap(int height) {
    image_.push_back(cv::Mat(scale_.Enlarge(height), width_, CV_8UC3, overview_colour::kPaper));
  }

  void AddTitle(const OverviewCaption& caption) {
    BeginLine(kTitleHeight);
    const int left = x_;
    const int right = left + WidthOf(caption.badge, kBadge) + scale_.Enlarge(2 * 12);
    const int half_height = scale_.Enlarge(16);
    cv::rectangle(image_, cv::Rect(left, middle_ - half_height, right - left, 2 * half_height), caption.badge_colour,
                  cv::FILLED);
    x_ += scale_.Enlarge(12);
    Write(caption.badge, kBadge);
    x_ = right + scale_.Enlarge(kMargin);
    std::string title = caption.title;
    while (!title.empty() && x_ + WidthOf(title, kTitle) > width_ - scale_.Enlarge(kMargin)) title.pop_back();
    Write(title, kTitle);
  }

  /// Words, on as many lines as they need.
  void AddParagraph(std::string_view text, const Letters& letters) {
    BeginLine(kLineHeight);
    const int indent = x_ + scale_.Enlarge(kMargin);
    while (!text.empty()) {
      const std::string word(text.substr(0, text.find(' ')));
      text.remove_prefix(std::min(text.size(), word.size() + 1));
      if (!HasRoom(WidthOf(word, letters)) && x_ > indent) {
        BeginLine(kLineHeight);
        x_ = indent;
      }
      Write(word, letters);
      x_ += scale_.Enlarge(10 * letters.size);
    }
  }

  /// A bar of so many metres.
  void BeginLegend() {
    BeginLine(kLineHeight);
    const double length_m = scale_.StepM();
    const int right = x_ + static_cast<int>(std::lround(length_m * scale_.pixels_per_m));
    const int half_tick = scale_.Enlarge(6);
    const int thickness = scale_.Enlarge(2);
    cv::line(image_, {x_, middle_}, {right, middle_}, overview_colour::kInk, thickness);
    for (const int x : {x_, right})
      cv::line(image_, {x, middle_ - half_tick}, {x, middle_ + half_tick}, overview_colour::kInk, thickness);
    x_ = right + scale_.Enlarge(8);
    Write(fmt::format("{:g} m", length_m), kBody);
    x_ += scale_.Enlarge(kMargin);
  }

  void AddLegendItem(const LegendItem& item) {
    if (!HasRoom(scale_.Enlarge(kSignWidth + 8) + WidthOf(item.text, kBody))) BeginLine(kLineHeight);
    DrawSign(item);
    x_ += scale_.Enlarge(kSignWidth + 8);
    Write(item.text, kBody);
    x_ += scale_.Enlarge(kMargin);
  }

 private:
  void BeginLine(int height) {
    middle_ = image_.rows + scale_.Enlarge(height) / 2;
    AddGap(height);
    x_ = scale_.Enlarge(kMargin);
  }

  bool HasRoom(int width) const { return x_ + width <= width_ - scale_.Enlarge(kMargin); }

  int Thickness() const { return scale_.Enlarge(1); }

  int WidthOf(const std::string& text, const Letters& letters) const {
    return cv::getTextSize(text, letters.face, letters.size * scale_.enlargement, Thickness(), nullptr).width;
  }

  void Write(const std::string& text, const Letters& letters) {
    const int half_height = scale_.Enlarge(10.5 * letters.size);  // of a capital letter
    cv::putText(image_, text, {x_, middle_ + half_height}, letters.face, letters.size * scale_.enlargement,
                letters.colour, Thickness(), cv::LINE_AA);
    x_ += WidthOf(text, letters);
  }

  void DrawSign(const LegendItem& item) {
    using enum LegendItem::Sign;
    const int radius = scale_.Enlarge(kSignRadius);
    const cv::Point left(x_ + 2, middle_);
    const cv::Point right(x_ + scale_.Enlarge(kSignWidth) - 2, middle_);
    const cv::Point centre = (left + right) / 2;
    const cv::Point arm(radius, radius);
    const cv::Point other_arm(radius, -radius);
    const int thickness = scale_.Enlarge(2);
    switch (item.sign) {
      case kSquare: {
        const cv::Rect square(centre - arm, centre + arm);
        cv::rectangle(image_, square, item.colour, cv::FILLED);
        cv::rectangle(image_, square, overview_colour::kRuler, scale_.Enlarge(1));
        return;
      }
      case kDisc:
        return cv::circle(image_, centre, radius, item.colour, cv::FILLED, cv::LINE_AA);
      case kRing:
        return cv::circle(image_, centre, radius, item.colour, thickness, cv::LINE_AA);
      case kCross:
        cv::line(image_, centre - arm, centre + arm, item.colour, thickness, cv::LINE_AA);
        return cv::line(image_, centre - other_arm, centre + other_arm, item.colour, thickness, cv::LINE_AA);
      case kDashes:
        cv::line(image_, left, left + (right - left) * (1.0 / 3), item.colour, thickness, cv::LINE_AA);
        return cv::line(image_, right, right - (right - left) * (1.0 / 3), item.colour, thickness, cv::LINE_AA);
      case kPair:
        for (const cv::Point& end : {left, right})
          cv::circle(image_, end, scale_.Enlarge(4), item.colour, cv::FILLED, cv::LINE_AA);
        return cv::line(image_, left, right, item.colour, thickness, cv::LINE_AA);
      case kLine:
        return cv::line(image_, left, right, item.colour, thickness, cv::LINE_AA);
    }
  }

  int width_;
  OverviewScale scale_;
  cv::Mat image_;
  int x_ = 0;       ///< where the line goes on
  int middle_ = 0;  ///< of the line
};

}  // namespace

cv::Mat DrawCaption(const OverviewCaption& caption, int width, const OverviewScale& scale) {
  Sheet sheet(width, scale);
  sheet.AddTitle(caption);
  if (!caption.headline.empty()) sheet.AddParagraph(caption.headline, kHeadline);
  for (const std::string& line : caption.lines) sheet.AddParagraph(line, kBody);
  for (const std::string& warning : caption.warnings) sheet.AddParagraph(warning, kWarning);
  sheet.AddGap(kMargin / 2);
  sheet.BeginLegend();
  for (const LegendItem& item : caption.legend) sheet.AddLegendItem(item);
  sheet.AddGap(kMargin / 2);
  return sheet.image();
}

}  // namespace crsm
