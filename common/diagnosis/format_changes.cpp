#include <fmt/format.h>

#include <algorithm>

#include "common/diagnosis/changes.hpp"

namespace crsm {

const char* Name(ChangeKind kind) { return kind == ChangeKind::kNew ? "new" : "gone"; }

double LargestArea(const std::vector<MapChange>& changes) {
  double largest_m2 = 0.0;
  for (const MapChange& change : changes) largest_m2 = std::max(largest_m2, change.area_m2());
  return largest_m2;
}

std::vector<std::string> FormatChanges(const std::vector<MapChange>& changes) {
  std::vector<std::string> lines;
  for (const MapChange& change : changes) {
    lines.push_back(fmt::format("{}: {:.1f} x {:.1f} m at {:.1f}, {:.1f}, seen from {} places", Name(change.kind),
                                change.length_m, change.width_m, change.middle.x_m, change.middle.y_m,
                                change.num_places));
  }
  if (lines.empty()) lines.emplace_back("nothing has changed since the map was made, as far as it was seen");
  return lines;
}

std::string FormatChangesCsv(const std::vector<MapChange>& changes) {
  std::string text = "kind,x_m,y_m,length_m,width_m,yaw_rad,area_m2,first_utime,places\n";
  for (const MapChange& change : changes) {
    text += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{:.4f},{},{}\n", Name(change.kind), change.middle.x_m,
                        change.middle.y_m, change.length_m, change.width_m, change.yaw_rad, change.area_m2(),
                        change.first_utime, change.num_places);
  }
  return text;
}

}  // namespace crsm
