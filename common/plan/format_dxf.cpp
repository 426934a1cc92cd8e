#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/plan/plan.hpp"

namespace crsm {
namespace {

/// The pairs of lines that a DXF file is made of: a code, and a value.
class DxfText {
 public:
  void Add(int code, const std::string& value) { text_ += fmt::format("{}\n{}\n", code, value); }
  void Add(int code, double value) { text_ += fmt::format("{}\n{:.4f}\n", code, value); }
  void Add(int code, int value) { text_ += fmt::format("{}\n{}\n", code, value); }

  void AddPoint(int number, const Point& at) {
    Add(10 + number, at.x_m);
    Add(20 + number, at.y_m);
  }

  void AddLayer(const std::string& name, int colour) {
    Add(0, "LAYER");
    Add(2, name);
    Add(70, 0);
    Add(62, colour);
    Add(6, "CONTINUOUS");
  }

  void AddLine(const std::string& layer, const Point& from, const Point& to) {
    Add(0, "LINE");
    Add(8, layer);
    AddPoint(0, from);
    AddPoint(1, to);
  }

  /// Bytes that are no letters, digits or signs of ASCII become '?': release 12 knows no others.
  void AddText(const std::string& layer, const Point& at, double height_m, double yaw_rad, const std::string& text) {
    std::string plain = text;
    std::ranges::replace_if(
        plain, [](char c) { return c < ' ' || c > '~'; }, '?');
    Add(0, "TEXT");
    Add(8, layer);
    AddPoint(0, at);
    Add(40, height_m);
    Add(1, plain);
    Add(50, yaw_rad * 180.0 / kPi);
  }

  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace

std::string FormatDxf(const Plan& plan, const std::vector<std::string>& title) {
  constexpr double kText_m = 0.15;
  Point least{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point most{-least.x_m, -least.y_m};
  for (const PlanWall& wall : plan.walls) {
    for (const Point& at : {wall.from, wall.to}) {
      least = {std::min(least.x_m, at.x_m), std::min(least.y_m, at.y_m)};
      most = {std::max(most.x_m, at.x_m), std::max(most.y_m, at.y_m)};
    }
  }
  if (plan.walls.empty()) least = most = {};
  DxfText dxf;
  dxf.Add(0, "SECTION");
  dxf.Add(2, "HEADER");
  dxf.Add(9, "$ACADVER");
  dxf.Add(1, "AC1009");
  for (const auto& [name, at] : {std::pair("$EXTMIN", least), std::pair("$EXTMAX", most)}) {
    dxf.Add(9, name);
    dxf.AddPoint(0, at);
    dxf.Add(30, 0.0);
  }
  dxf.Add(0, "ENDSEC");
  dxf.Add(0, "SECTION");
  dxf.Add(2, "TABLES");
  dxf.Add(0, "TABLE");
  dxf.Add(2, "LAYER");
  dxf.Add(70, 4);
  dxf.AddLayer("WALLS", 7);  // white or black
  dxf.AddLayer("DOORS", 3);  // green
  dxf.AddLayer("ROOMS", 5);  // blue
  dxf.AddLayer("TEXT", 8);   // grey
  dxf.Add(0, "ENDTAB");
  dxf.Add(0, "ENDSEC");
  dxf.Add(0, "SECTION");
  dxf.Add(2, "ENTITIES");
  for (const PlanWall& wall : plan.walls) dxf.AddLine("WALLS", wall.from, wall.to);
  for (const PlanDoor& door : plan.doors) dxf.AddLine("DOORS", door.from, door.to);
  for (const PlanRoom& room : plan.rooms) {
    const std::string area = fmt::format("{:.2f} m2", room.area_m2);
    dxf.AddText("ROOMS", room.middle, kText_m, 0.0, room.name.empty() ? area : room.name + ", " + area);
  }
  for (const PlanWall& wall : plan.walls) {
    const Point middle{0.5 * (wall.from.x_m + wall.to.x_m), 0.5 * (wall.from.y_m + wall.to.y_m)};
    const double yaw = std::atan2(wall.to.y_m - wall.from.y_m, wall.to.x_m - wall.from.x_m);
    dxf.AddText("TEXT", middle, 0.5 * kText_m, yaw,
                fmt::format("{:.2f} +- {:.2f}", wall.length_m, BoundLengthError(plan, wall)));
  }
  double below_m = 4.0 * kText_m;
  for (const std::string& line : title) {
    dxf.AddText("TEXT", {least.x_m, least.y_m - below_m}, kText_m, 0.0, line);
    below_m += 2.0 * kText_m;
  }
  dxf.Add(0, "ENDSEC");
  dxf.Add(0, "EOF");
  return dxf.Take();
}

}  // namespace crsm
