#include "common/results/map_edits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "common/logs/map_files.hpp"
#include "common/logs/regular_file.hpp"
#include "common/map/tile_grid.hpp"
#include "common/results/json_text.hpp"
#include "common/results/mark_masks.hpp"
#include "common/results/pictures.hpp"

namespace crsm {
namespace {

[[noreturn]] void Fail(const std::string& what) { throw std::runtime_error(what); }

const char* Name(MapEdits::Becomes becomes) { return becomes == MapEdits::Becomes::kFree ? "free" : "unexplored"; }

/// Of what somebody else wrote: a line of letters that a terminal can show.
std::string QuoteKey(const std::string& key) {
  constexpr std::size_t kMostBytes = 40;
  return nlohmann::json(key.substr(0, kMostBytes)).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

void CheckKeys(const nlohmann::json& object, const std::string& where, std::initializer_list<const char*> known) {
  for (const auto& [key, value] : object.items()) {
    if (std::ranges::find(known, key) != known.end()) continue;
    Fail(fmt::format("{}{} is no key: they are {}", where, QuoteKey(key), fmt::join(known, ", ")));
  }
}

double ToNumber(const nlohmann::json& json, double largest, const std::string& key) {
  const double number = json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!(std::abs(number) <= largest)) Fail(fmt::format("{0}: must be a number from -{1:g} to {1:g}", key, largest));
  return number;
}

std::vector<Point> ToPoints(const nlohmann::json& json, std::size_t least, const std::string& key) {
  if (!json.is_array() || json.size() < least || json.size() > MapEdits::kMostPoints) {
    Fail(fmt::format("{}: must be a list of {} to {} points [x, y]{}", key, least, MapEdits::kMostPoints,
                     json.is_array() ? fmt::format(", and has {}", json.size()) : ""));
  }
  std::vector<Point> points;
  for (const nlohmann::json& pair : json) {
    const std::string which = fmt::format("{}[{}]", key, points.size());
    if (!pair.is_array() || pair.size() != 2) Fail(which + ": must be two numbers, [x, y]");
    points.push_back(
        {ToNumber(pair[0], MapEdits::kFarthest_m, which), ToNumber(pair[1], MapEdits::kFarthest_m, which)});
  }
  return points;
}

MapEdits::Erasure ToErasure(const nlohmann::json& json, const std::string& key) {
  using Becomes = MapEdits::Becomes;
  if (!json.is_object()) Fail(key + ": must be an object with becomes and outline_m");
  CheckKeys(json, key + ".", {"becomes", "outline_m"});
  const auto becomes = json.value("becomes", nlohmann::json("free"));
  if (becomes != Name(Becomes::kFree) && becomes != Name(Becomes::kUnexplored)) {
    Fail(key + ".becomes: must be \"free\" or \"unexplored\"");
  }
  constexpr std::size_t kLeastCorners = 3;
  return {becomes == Name(Becomes::kFree) ? Becomes::kFree : Becomes::kUnexplored,
          ToPoints(json.value("outline_m", nlohmann::json()), kLeastCorners, key + ".outline_m")};
}

nlohmann::json ToJson(const std::vector<Point>& points) {
  auto json = nlohmann::json::array();
  for (const auto& [x_m, y_m] : points) json.push_back({x_m, y_m});
  return json;
}

/// Calls visit(first, end) for the columns of each row whose middles are in an outline, by the even-odd rule.
template <class Visit>
void VisitInside(const DenseGrid& grid, const std::vector<Point>& outline, const Visit& visit) {
  std::vector<double> crossings;  // columns
  for (int row = 0; row < grid.height_cells; ++row) {
    const double y_m = (grid.origin_y_cells + row + 0.5) * grid.cell_size_m;
    crossings.clear();
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Point& from = outline[i];
      const Point& to = outline[(i + 1) % outline.size()];
      if ((from.y_m <= y_m) == (to.y_m <= y_m)) continue;
      const double x_m = from.x_m + (y_m - from.y_m) / (to.y_m - from.y_m) * (to.x_m - from.x_m);
      const double first = std::ceil(x_m / grid.cell_size_m - grid.origin_x_cells - 0.5);
      crossings.push_back(std::clamp(first, 0.0, static_cast<double>(grid.width_cells)));
    }
    std::ranges::sort(crossings);
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      visit(grid.IndexOf(static_cast<int>(crossings[i]), row), grid.IndexOf(static_cast<int>(crossings[i + 1]), row));
    }
  }
}

std::vector<Point> ToOutline(const std::vector<Point>& crop) {
  if (crop.size() != 2) return crop;
  return {crop[0], {crop[1].x_m, crop[0].y_m}, crop[1], {crop[0].x_m, crop[1].y_m}};
}

/// Erased and cropped, with the cells of the map.
DenseGrid CutOut(const DenseGrid& map, const MapEdits& edits) {
  DenseGrid grid = map;
  for (const auto& [becomes, outline] : edits.erase) {
    VisitInside(map, outline, [&, is_free = becomes == MapEdits::Becomes::kFree](std::size_t first, std::size_t end) {
      for (; first < end; ++first) {
        std::uint8_t& cell = grid.cells[first];
        if (!is_free) cell = kUnexploredByte;
        if (IsOccupied(cell)) cell = kFreeByte;
      }
    });
  }
  if (edits.crop.empty()) return grid;
  DenseGrid cropped = map;
  std::ranges::fill(cropped.cells, kUnexploredByte);
  VisitInside(map, ToOutline(edits.crop), [&](std::size_t first, std::size_t end) {
    std::copy(grid.cells.begin() + static_cast<std::ptrdiff_t>(first),
              grid.cells.begin() + static_cast<std::ptrdiff_t>(end),
              cropped.cells.begin() + static_cast<std::ptrdiff_t>(first));
  });
  return cropped;
}

/// A place in cells, turned about the map's origin.
class Turn {
 public:
  explicit Turn(double yaw_rad) : cos_(ComputeSinCos(yaw_rad).cos), sin_(ComputeSinCos(yaw_rad).sin) {}
  double X(double x, double y) const { return cos_ * x - sin_ * y; }
  double Y(double x, double y) const { return sin_ * x + cos_ * y; }

 private:
  double cos_;
  double sin_;
};

/// Around all that is explored, as it lies when it is turned; without cells.
DenseGrid FindFrame(const DenseGrid& grid, const Turn& turn) {
  constexpr double kNearBorder = 0.49;  // from the middle of a cell: its corners would touch those beside it
  constexpr double kMostCells = static_cast<double>(kMostTilesInRectangle) * kTileCells;
  double x0 = std::numeric_limits<double>::infinity();
  double y0 = x0;
  double x1 = -x0;
  double y1 = -x0;
  const auto Cover = [&](int column, int row) {
    for (const double dx : {-kNearBorder, kNearBorder}) {
      for (const double dy : {-kNearBorder, kNearBorder}) {
        const double x = grid.origin_x_cells + column + 0.5 + dx;
        const double y = grid.origin_y_cells + row + 0.5 + dy;
        x0 = std::min(x0, std::floor(turn.X(x, y)));
        x1 = std::max(x1, std::floor(turn.X(x, y)));
        y0 = std::min(y0, std::floor(turn.Y(x, y)));
        y1 = std::max(y1, std::floor(turn.Y(x, y)));
      }
    }
  };
  for (int row = 0; row < grid.height_cells; ++row) {  // what lies furthest out is at an end of its row
    int first = 0;
    int last = grid.width_cells - 1;
    while (first <= last && grid.cells[grid.IndexOf(first, row)] == kUnexploredByte) ++first;
    if (first > last) continue;
    while (grid.cells[grid.IndexOf(last, row)] == kUnexploredByte) --last;
    Cover(first, row);
    Cover(last, row);
  }
  if (!(x0 <= x1)) Fail("crop_m, erase: nothing is left of the map");
  const double width = x1 - x0 + 1;
  const double height = y1 - y0 + 1;
  if (width * height > kMostCells) {
    Fail(fmt::format("turn_deg: the turned map has {} x {} cells, more than {}: crop it", width, height, kMostCells));
  }
  return {static_cast<int>(width), static_cast<int>(height), static_cast<int>(x0),
          static_cast<int>(y0),    grid.cell_size_m,         {}};
}

/// What the map is at a place in cells.
std::uint8_t Look(const DenseGrid& grid, double x, double y) {
  const double column = std::floor(x) - grid.origin_x_cells;
  const double row = std::floor(y) - grid.origin_y_cells;
  if (!(column >= 0 && column < grid.width_cells && row >= 0 && row < grid.height_cells)) return kUnexploredByte;
  return grid.cells[grid.IndexOf(static_cast<int>(column), static_cast<int>(row))];
}

}  // namespace

MapEdits ParseMapEdits(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) Fail("must be a JSON object with crop_m, erase and turn_deg");
  CheckKeys(json, "", {"crop_m", "erase", "turn_deg", "T_edited_map"});
  MapEdits edits;
  constexpr std::size_t kLeastCorners = 2;
  if (json.contains("crop_m")) edits.crop = ToPoints(json["crop_m"], kLeastCorners, "crop_m");
  if (json.contains("turn_deg")) edits.turn_deg = ToNumber(json["turn_deg"], MapEdits::kLargestTurn_deg, "turn_deg");
  const auto erase = json.value("erase", nlohmann::json::array());
  if (!erase.is_array() || erase.size() > MapEdits::kMostErasures) {
    Fail(fmt::format("erase: must be a list of at most {} outlines", MapEdits::kMostErasures));
  }
  for (const nlohmann::json& erasure : erase) {
    edits.erase.push_back(ToErasure(erasure, fmt::format("erase[{}]", edits.erase.size())));
  }
  return edits;
}

MapEdits ReadMapEdits(const std::filesystem::path& path) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  const std::string text = ReadWholeFile(path, kMostBytes);
  try {
    return ParseMapEdits(text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

std::string FormatMapEdits(const MapEdits& edits) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  if (!edits.crop.empty()) json["crop_m"] = ToJson(edits.crop);
  json["erase"] = nlohmann::ordered_json::array();
  for (const auto& [becomes, outline] : edits.erase) {
    json["erase"].push_back({{"becomes", Name(becomes)}, {"outline_m", ToJson(outline)}});
  }
  json["turn_deg"] = edits.turn_deg;
  const Pose2 T_edited_map = TransformOf(edits);
  json["T_edited_map"] = {{"x_m", T_edited_map.x_m}, {"y_m", T_edited_map.y_m}, {"yaw_rad", T_edited_map.yaw_rad}};
  return ToText(json) + "\n";
}

Pose2 TransformOf(const MapEdits& edits) { return {0.0, 0.0, WrapAngle(edits.turn_deg * std::numbers::pi / 180.0)}; }

DenseGrid ApplyEdits(const DenseGrid& map, const MapEdits& edits) {
  constexpr double kQuarter = 0.25;  // from the middle of a cell to that of its quarters
  const DenseGrid cut = CutOut(map, edits);
  const double yaw_rad = TransformOf(edits).yaw_rad;
  DenseGrid edited = FindFrame(cut, Turn(yaw_rad));
  edited.cells.reserve(static_cast<std::size_t>(edited.width_cells) * static_cast<std::size_t>(edited.height_cells));
  const Turn back(-yaw_rad);
  for (int row = 0; row < edited.height_cells; ++row) {
    for (int column = 0; column < edited.width_cells; ++column) {
      const double x = edited.origin_x_cells + column + 0.5;
      const double y = edited.origin_y_cells + row + 0.5;
      std::uint8_t least = kUnexploredByte;
      for (const double dx : {-kQuarter, kQuarter}) {
        for (const double dy : {-kQuarter, kQuarter}) {
          least = std::min(least, Look(cut, back.X(x + dx, y + dy), back.Y(x + dx, y + dy)));
        }
      }
      edited.cells.push_back(IsOccupied(least) ? least : Look(cut, back.X(x, y), back.Y(x, y)));
    }
  }
  return edited;
}

void AddEditedMap(const DenseGrid& map, const std::vector<PlacedMark>& marks, const MapEdits& edits,
                  Replacement& files) {
  const DenseGrid edited = ApplyEdits(map, edits);
  const Pose2 T_edited_map = TransformOf(edits);
  files.Write("map_edited.png", EncodeMap(edited));
  files.Write(
      "map_edited.yaml",
      fmt::format("# Made of map.png and edits.json. A point of map.png is turned about (0, 0) to be one of this map.\n"
                  "# T_edited_map: [{:.6f}, {:.6f}, {:.9f}]  # x [m], y [m], yaw [rad], counter-clockwise\n",
                  T_edited_map.x_m, T_edited_map.y_m, T_edited_map.yaw_rad) +
          FormatMapYaml(edited, "map_edited.png"));
  std::vector<PlacedMark> turned = marks;
  for (PlacedMark& mark : turned) {
    for (Point& point : mark.points) point = Apply(T_edited_map, point);
  }
  AddMasks(edited, turned, files, "_edited");
  files.Write(kEditsFile, FormatMapEdits(edits));
}

}  // namespace crsm
