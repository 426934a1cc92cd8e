#include "common/marks/mark.hpp"

#include <algorithm>
#include <cmath>

#include "common/math/format_number.hpp"

namespace crsm {
namespace {

bool HasControls(const std::string& text) {
  return std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

bool IsKind(const std::string& text) {
  const auto Fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; };
  return !text.empty() && text.size() <= Mark::kLongestKind && std::ranges::all_of(text, Fits);
}

}  // namespace

bool IsOnMaps(const Point& point) {
  return std::abs(point.x_m) <= Mark::kFarthest_m && std::abs(point.y_m) <= Mark::kFarthest_m;  // false for NaN
}

std::string DescribeFault(const Mark& mark) {
  if (mark.utime < 0) return "the time must be 0 or later";
  if (mark.id.empty() || mark.id.size() > Mark::kLongestText || HasControls(mark.id)) {
    return "the id must have 1 to 63 bytes, without control characters";
  }
  if (mark.action == MarkAction::kRemoved) {
    return mark.points.empty() && mark.kind.empty() && mark.name.empty()
               ? ""
               : "who removes a place gives its id alone, without kind, name and points";
  }
  if (!IsKind(mark.kind)) return "the kind must have 1 to 31 characters of a-z, 0-9 and -";
  if (mark.name.size() > Mark::kLongestText || HasControls(mark.name)) {
    return "the name must have at most 63 bytes, without control characters";
  }
  if (!(mark.radius_m >= Mark::kLeastRadius_m && mark.radius_m <= Mark::kLargestRadius_m)) {  // false for NaN
    return "the radius is " + FormatNumber(mark.radius_m) + " m: it must be 0.001 to 1000";
  }
  if (mark.points.empty() || mark.points.size() == 2 || mark.points.size() > Mark::kMostPoints) {
    return "it has " + std::to_string(mark.points.size()) + " points: a place has 1, an outline 3 to 64";
  }
  if (!std::ranges::all_of(mark.points, IsOnMaps)) return "its points must be finite and within 1e6 m";
  return "";
}

std::string DescribeFault(const PlacedMark& mark) {
  const auto Cut = [](std::string text) {
    if (text.size() <= PlacedMark::kLongestText) text.resize(std::min(text.size(), Mark::kLongestText));
    return text;
  };
  if (HasControls(mark.id) || HasControls(mark.name)) return "an id or a name has control characters";
  return DescribeFault(Mark{mark.utime, Cut(mark.id), mark.kind, Cut(mark.name), MarkAction::kSeen, true,
                            Mark::kLargestRadius_m, mark.points});
}

std::array<double, 3> TurnCovariance(const std::array<double, 3>& covariance, double yaw_rad) {
  const auto& [xx, xy, yy] = covariance;
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  return {c * c * xx - 2.0 * c * s * xy + s * s * yy, c * s * (xx - yy) + (c * c - s * s) * xy,
          s * s * xx + 2.0 * c * s * xy + c * c * yy};
}

Point MiddleOf(const PlacedMark& mark) {
  Point sum;
  for (const auto& [x_m, y_m] : mark.points) sum = {sum.x_m + x_m, sum.y_m + y_m};
  const double num = std::max<double>(1.0, static_cast<double>(mark.points.size()));
  return {sum.x_m / num, sum.y_m / num};
}

}  // namespace crsm
