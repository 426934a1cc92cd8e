#include "common/world.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "common/laser_scan.hpp"

namespace crsm {
namespace {

constexpr const char* kDemo = R"(# A flat of six rooms around a loop of corridors, 14 x 10 m.
laser 270 270 9.5 10 0.01
speed 0.3 0.5

box 0 0 14 10
box 5.2 4.2 3.6 1.6         # the block inside the loop
wall 4 0 4 3.2              # west side of the loop, doors to bedroom and bathroom
wall 4 4.2 4 5.8
wall 4 6.8 4 10
wall 10 0 10 3.3            # east side, doors to living room and study
wall 10 4.3 10 5.7
wall 10 6.7 10 10
wall 4 3 6.6 3              # south side, door to the kitchen
wall 7.6 3 10 3
wall 4 7 5.6 7              # north side, door to the dining room
wall 6.6 7 10 7
wall 0 4.8 4 4.8            # bedroom | bathroom
wall 10 5.2 14 5.2          # living room | study

box 7.6 5.8 0.6 0.15        # corridor: shelf
box 0.2 0.2 1.4 1           # bedroom: bed, wardrobe, desk
box 3.3 0.3 0.6 1.6
box 0.1 4 1.2 0.7
box 8.6 0.1 1.3 1.4         # kitchen: counter, table, fridge
box 4.2 2.2 0.8 0.6
box 4.1 0.1 0.7 0.7
box 13 2.4 0.9 1.9          # living room: sofa, cupboard, table
box 10.1 0.6 0.4 1.5
box 11 2 0.5 0.5
box 13.1 5.4 0.8 1.6        # study: desk, shelf, cabinet
box 10.1 9.4 2.2 0.5
box 10.1 7.4 0.6 0.9
box 6.9 7.4 0.9 0.5         # dining room: table, cupboard, sideboard
box 4.1 8.8 0.5 1.1
box 8.9 7.2 1 0.5
box 0.1 4.9 1.7 0.7         # bathroom: tub, shower, basin
box 3.1 8.9 0.8 1
box 0.1 6.9 0.4 0.6

waypoint 4.6 5
waypoint 4.6 3.7
waypoint 2.6 3.7            # bedroom
waypoint 1.2 2.2
waypoint 2.6 1.2
waypoint 2.6 3.7
waypoint 4.6 3.7
waypoint 7.1 3.6
waypoint 7.1 1.6            # kitchen
waypoint 5.4 1.4
waypoint 7.1 1.6
waypoint 7.1 3.6
waypoint 9.4 3.7
waypoint 12 3.8             # living room
waypoint 12.4 1.6
waypoint 12 3.8
waypoint 9.4 3.7
waypoint 9.4 6.2
waypoint 11.8 6.2           # study
waypoint 12.2 8.4
waypoint 11.8 6.2
waypoint 9.4 6.2
waypoint 6.1 6.4
waypoint 6.1 8.2            # dining room
waypoint 8.2 8.6
waypoint 6.1 8.2
waypoint 6.1 6.4
waypoint 4.6 6.3
waypoint 2.2 6.3            # bathroom
waypoint 1.4 8.4
waypoint 2.2 6.3
waypoint 4.6 6.3
waypoint 4.6 5
)";

constexpr const char* kCorridor =
    R"(# A corridor of 1.6 m with four bends, niches and pillars: wherever the laser stands, it
# sees walls along the corridor and walls across it.
laser 240 240 5.6 10 0.01
speed 0.3 0.5

wall -0.8 -0.8 -0.8 0.8     # west end
wall -0.8 0.8 1.5 0.8       # left wall
wall 1.5 0.8 1.5 1.3
wall 1.5 1.3 2.4 1.3
wall 2.4 1.3 2.4 0.8
wall 2.4 0.8 5.2 0.8
wall 5.2 0.8 5.2 2.4
wall 5.2 2.4 4.7 2.4
wall 4.7 2.4 4.7 3.3
wall 4.7 3.3 5.2 3.3
wall 5.2 3.3 5.2 5.8
wall 5.2 5.8 8.2 5.8
wall 8.2 5.8 8.2 6.3
wall 8.2 6.3 9.2 6.3
wall 9.2 6.3 9.2 5.8
wall 9.2 5.8 11.8 5.8
wall 11.8 5.8 12.8 4.8
wall 12.8 4.8 12.8 3.4
wall 12.8 3.4 13.3 3.4
wall 13.3 3.4 13.3 2.5
wall 13.3 2.5 12.8 2.5
wall 12.8 2.5 12.8 0.8
wall 12.8 0.8 15 0.8
wall 15 0.8 15 1.3
wall 15 1.3 15.8 1.3
wall 15.8 1.3 15.8 0.8
wall 15.8 0.8 17.8 0.8
wall 17.8 0.8 17.8 -0.8     # east end
wall 17.8 -0.8 11.2 -0.8    # right wall
wall 11.2 -0.8 11.2 4.2
wall 11.2 4.2 6.8 4.2
wall 6.8 4.2 6.8 -0.8
wall 6.8 -0.8 4.4 -0.8
wall 4.4 -0.8 4.4 -1.3
wall 4.4 -1.3 3.4 -1.3
wall 3.4 -1.3 3.4 -0.8
wall 3.4 -0.8 -0.8 -0.8
box 0.4 -0.8 0.3 0.25       # pillars
box 6.4 1.2 0.4 0.4
box 9.9 4.2 0.4 0.3
box 11.2 1.4 0.25 0.4
box 13.9 -0.8 0.3 0.3
box 16.6 0.5 0.3 0.3

waypoint 0 0
waypoint 6 0
waypoint 6 5
waypoint 12 5
waypoint 12 0
waypoint 17 0
)";

const std::map<std::string, const char*>& BuiltInWorlds() {
  static const std::map<std::string, const char*> kWorlds = {{"demo", kDemo}, {"corridor", kCorridor}};
  return kWorlds;
}

struct Field {
  const char* name;
  double min;
  double max;
};

using Keys = std::map<std::string, std::vector<Field>>;

const Keys& KnownKeys() {
  constexpr double kReach_m = 1000.0;
  constexpr double kSmallest = 0.001;
  static const Keys kKeys = {
      {"wall",
       {{"x1_m", -kReach_m, kReach_m},
        {"y1_m", -kReach_m, kReach_m},
        {"x2_m", -kReach_m, kReach_m},
        {"y2_m", -kReach_m, kReach_m}}},
      {"box",
       {{"x_m", -kReach_m, kReach_m},
        {"y_m", -kReach_m, kReach_m},
        {"width_m", kSmallest, kReach_m},
        {"height_m", kSmallest, kReach_m}}},
      {"waypoint", {{"x_m", -kReach_m, kReach_m}, {"y_m", -kReach_m, kReach_m}}},
      {"laser",
       {{"fov_deg", 1.0, 360.0},
        {"beams", kMinBeams, kMaxBeams},
        {"range_max_m", 0.1, kReach_m},
        {"rate_hz", 0.1, kReach_m},
        {"noise_m", 0.0, 1.0}}},
      {"speed", {{"linear_m_s", kSmallest, 10.0}, {"angular_rad_s", kSmallest, 10.0}}},
  };
  return kKeys;
}

std::string Usage(const std::string& key) {
  std::string usage = key;
  for (const Field& field : KnownKeys().at(key)) usage += fmt::format(" {}", field.name);
  return usage;
}

std::string ListOf(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

template <class Map>
std::vector<std::string> NamesOf(const Map& map) {
  std::vector<std::string> names;
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

std::optional<double> ToNumber(const std::string& word) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return number;
}

/// The numbers after `key`, each in its range. `place` is file:line.
std::vector<double> ReadNumbers(const std::string& place, const std::string& key, std::istringstream& words) {
  const auto known = KnownKeys().find(key);
  if (known == KnownKeys().end()) {
    throw std::runtime_error(fmt::format("{}: '{}' is none of {}", place, key, ListOf(NamesOf(KnownKeys()))));
  }
  const std::vector<std::string> found{std::istream_iterator<std::string>(words), {}};
  if (found.size() != known->second.size()) {
    throw std::runtime_error(fmt::format("{}: {} numbers after '{}', must be {}: {}", place, found.size(), key,
                                         known->second.size(), Usage(key)));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Field& field = known->second[i];
    const std::optional<double> number = ToNumber(found[i]);
    if (!number || !(*number >= field.min && *number <= field.max)) {
      throw std::runtime_error(fmt::format("{}: {} {} is '{}', must be a number from {} to {}", place, key, field.name,
                                           found[i], field.min, field.max));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

void AddBox(const Point& lower_left, const Point& size, std::vector<Wall>& walls) {
  const double right_m = lower_left.x_m + size.x_m;
  const double top_m = lower_left.y_m + size.y_m;
  const Point corners[] = {lower_left, {right_m, lower_left.y_m}, {right_m, top_m}, {lower_left.x_m, top_m}};
  for (std::size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
}

/// Throws unless the laser can drive straight from one point to the other.
void CheckLeg(const std::vector<Wall>& walls, const Point& from, const Point& to, const std::string& place) {
  const double dx_m = to.x_m - from.x_m;
  const double dy_m = to.y_m - from.y_m;
  const double length_m = std::sqrt(dx_m * dx_m + dy_m * dy_m);
  if (length_m == 0.0) throw std::runtime_error(fmt::format("{}: the waypoint is the one before it again", place));
  if (CastRay(walls, from, {dy_m / length_m, dx_m / length_m}) <= length_m) {
    throw std::runtime_error(fmt::format("{}: the way to this waypoint goes through a wall; go around it", place));
  }
}

}  // namespace

World ParseWorld(const std::string& text, const std::string& name) {
  World world;
  std::vector<std::string> waypoint_places;
  std::map<std::string, int> counts;
  std::istringstream lines(text);
  std::string line;
  for (int line_number = 1; std::getline(lines, line); ++line_number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string key;
    if (!(words >> key)) continue;
    const std::string place = fmt::format("{}:{}", name, line_number);
    const std::vector<double> numbers = ReadNumbers(place, key, words);
    ++counts[key];
    if (key == "wall") {
      world.walls.push_back({{numbers[0], numbers[1]}, {numbers[2], numbers[3]}});
    } else if (key == "box") {
      AddBox({numbers[0], numbers[1]}, {numbers[2], numbers[3]}, world.walls);
    } else if (key == "waypoint") {
      world.path.push_back({numbers[0], numbers[1]});
      waypoint_places.push_back(place);
    } else if (counts[key] > 1) {
      throw std::runtime_error(fmt::format("{}: a second '{}' line; there must be one", place, key));
    } else if (key == "laser") {
      if (numbers[1] != std::floor(numbers[1])) {
        throw std::runtime_error(fmt::format("{}: laser beams is {}, must be a whole number", place, numbers[1]));
      }
      world.laser = {numbers[0] * kPi / 180.0, static_cast<int>(numbers[1]), numbers[2], numbers[3], numbers[4]};
    } else {
      world.linear_m_s = numbers[0];
      world.angular_rad_s = numbers[1];
    }
  }
  for (const char* key : {"laser", "speed"}) {
    if (counts[key] == 0) throw std::runtime_error(fmt::format("{}: no line '{}'", name, Usage(key)));
  }
  if (world.walls.empty())
    throw std::runtime_error(fmt::format("{}: no wall and no box; there is nothing to see", name));
  if (world.path.size() < 2) {
    throw std::runtime_error(fmt::format("{}: {} waypoints, must be two or more", name, world.path.size()));
  }
  for (std::size_t i = 1; i < world.path.size(); ++i) {
    CheckLeg(world.walls, world.path[i - 1], world.path[i], waypoint_places[i]);
  }
  return world;
}

World LoadWorld(const std::string& name) {
  const auto built_in = BuiltInWorlds().find(name);
  if (built_in != BuiltInWorlds().end()) return ParseWorld(built_in->second, name);
  if (!std::filesystem::is_regular_file(name)) {
    throw std::runtime_error(
        fmt::format("there is no world file {} and no built-in world of that name; built in are {}", name,
                    ListOf(NamesOf(BuiltInWorlds()))));
  }
  std::ifstream file(name, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("cannot read {}", name));
  return ParseWorld({std::istreambuf_iterator<char>(file), {}}, name);
}

double CastRay(const std::vector<Wall>& walls, const Point& origin, const SinCos& direction) {
  // Walls are a hair longer than they are, so that no ray slips through where two of them meet.
  constexpr double kHair = 1e-9;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls) {
    const double wall_x_m = wall.to.x_m - wall.from.x_m;
    const double wall_y_m = wall.to.y_m - wall.from.y_m;
    const double denominator = direction.cos * wall_y_m - direction.sin * wall_x_m;
    if (denominator == 0.0) continue;  // the ray runs along the wall
    const double to_x_m = wall.from.x_m - origin.x_m;
    const double to_y_m = wall.from.y_m - origin.y_m;
    const double along_wall = (to_x_m * direction.sin - to_y_m * direction.cos) / denominator;
    const double distance_m = (to_x_m * wall_y_m - to_y_m * wall_x_m) / denominator;
    if (along_wall < -kHair || along_wall > 1.0 + kHair || distance_m < 0.0) continue;
    if (distance_m < nearest_m) nearest_m = distance_m;
  }
  return nearest_m;
}

}  // namespace crsm
