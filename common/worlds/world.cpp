#include "common/worlds/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "common/logs/regular_file.hpp"
#include "common/math/nearest_name.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/worlds/built_in_worlds.hpp"
#include "common/worlds/campus.hpp"
#include "common/worlds/read_number.hpp"

namespace crsm {
namespace {

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
      {"corner", {{"x_m", -kReach_m, kReach_m}, {"y_m", -kReach_m, kReach_m}}},
      {"person",
       {{"x1_m", -kReach_m, kReach_m},
        {"y1_m", -kReach_m, kReach_m},
        {"x2_m", -kReach_m, kReach_m},
        {"y2_m", -kReach_m, kReach_m},
        {"speed_m_s", kSmallest, 10.0}}},
      {"companion", {{"ahead_m", -kReach_m, kReach_m}, {"left_m", -kReach_m, kReach_m}}},
      {"laser",
       {{"fov_deg", 1.0, 360.0},
        {"beams", kMinBeams, kMaxBeams},
        {"range_max_m", 0.1, kReach_m},
        {"rate_hz", 0.1, kReach_m},
        {"noise_m", 0.0, 1.0}}},
      {"speed", {{"linear_m_s", kSmallest, 10.0}, {"angular_rad_s", kSmallest, 10.0}}},
      {"wheels",
       {{"way_scale", 0.0, 10.0}, {"turn_scale", 0.0, 10.0}, {"way_noise", 0.0, 10.0}, {"turn_noise", 0.0, 10.0}}},
  };
  return kKeys;
}

/// What may stand after the numbers of a key, each with one number.
const Keys& KnownOptions() {
  constexpr double kLongest_s = 1e6;
  static const Keys kOptions = {
      {"laser", {{"dropout", 0.0, 1.0}, {"quantum_m", 0.0, 1.0}, {"sweep_s", 0.0, 1.0}, {"angle_scale", 0.9, 1.1}}},
      {"wall", {{"from_s", 0.0, kLongest_s}, {"until_s", 0.0, kLongest_s}}},
      {"box", {{"from_s", 0.0, kLongest_s}, {"until_s", 0.0, kLongest_s}}},
      {"person", {{"from_s", 0.0, kLongest_s}, {"until_s", 0.0, kLongest_s}}},
      {"companion", {{"from_s", 0.0, kLongest_s}, {"until_s", 0.0, kLongest_s}}},
      {"wheels", {{"x_m", -10.0, 10.0}, {"y_m", -10.0, 10.0}, {"yaw_deg", -180.0, 180.0}, {"delay_s", 0.0, 10.0}}},
  };
  return kOptions;
}

std::string Usage(const std::string& key) {
  std::string usage = key == "corner" ? "corner NAME" : key;
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

/// The numbers after `key`, each in its range. `place` is file:line.
std::vector<double> ReadNumbers(const std::string& place, const std::string& key,
                                const std::vector<std::string>& words) {
  const auto known = KnownKeys().find(key);
  if (known == KnownKeys().end()) {
    throw std::runtime_error(fmt::format("{}: '{}' is none of {}", place, key, ListOf(NamesOf(KnownKeys()))));
  }
  if (words.size() != known->second.size()) {
    throw std::runtime_error(fmt::format("{}: {} numbers after '{}', must be {}: {}", place, words.size(), key,
                                         known->second.size(), Usage(key)));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < words.size(); ++i) {
    numbers.push_back(ReadNumber(place, key, known->second[i], words[i]));
  }
  return numbers;
}

struct CampusName {
  double length_m = 3000.0;
  std::uint64_t number = 1;
};

/// Of campus, campus:LENGTH_M or campus:LENGTH_M:NUMBER; nothing of another name.
std::optional<CampusName> ParseCampus(const std::string& name) {
  static const Field kLength{"LENGTH_M", 10.0, 100'000.0};
  static const Field kNumber{"NUMBER", 0.0, 1e9};
  std::istringstream words(name);
  std::string word;
  std::getline(words, word, ':');
  if (word != "campus") return std::nullopt;
  CampusName campus;
  if (std::getline(words, word, ':')) campus.length_m = ReadNumber(name, "campus", kLength, word);
  if (std::getline(words, word)) campus.number = static_cast<std::uint64_t>(ReadNumber(name, "campus", kNumber, word));
  return campus;
}

/// Options of a line, by their names.
class Options {
 public:
  /// Takes `name number` from the end of a line, for as long as there are any and the key may have some.
  Options(const std::string& place, const std::string& key, std::vector<std::string>& words) {
    const auto known = KnownOptions().find(key);
    if (known == KnownOptions().end()) return;
    for (; words.size() > KnownKeys().at(key).size() + 1; words.resize(words.size() - 2)) {
      const std::string& name = words[words.size() - 2];
      const auto option = std::find_if(known->second.begin(), known->second.end(),
                                       [&](const Field& field) { return name == field.name; });
      if (option == known->second.end()) {
        std::vector<std::string> names;
        for (const Field& field : known->second) names.emplace_back(field.name);
        throw std::runtime_error(
            fmt::format("{}: {} option '{}' is none of {}, each with a number", place, key, name, ListOf(names)));
      }
      values_[name] = ReadNumber(place, key, *option, words.back());
    }
  }

  double Get(const std::string& name, double otherwise) const {
    const auto value = values_.find(name);
    return value == values_.end() ? otherwise : value->second;
  }

 private:
  std::map<std::string, double> values_;
};

Stay ReadStay(const std::string& place, const Options& options) {
  const Stay always;
  const Stay stay{options.Get("from_s", always.from_s), options.Get("until_s", always.until_s)};
  if (stay.from_s >= stay.until_s) {
    throw std::runtime_error(
        fmt::format("{}: until_s is {}, must be above from_s, which is {}", place, stay.until_s, stay.from_s));
  }
  return stay;
}

/// Takes the name from the front of a corner's line.
std::string TakeName(const std::string& place, std::vector<std::string>& words, const std::vector<Corner>& known) {
  if (words.empty()) throw std::runtime_error(fmt::format("{}: a corner needs a name: {}", place, Usage("corner")));
  const std::string name = words.front();
  if (std::any_of(known.begin(), known.end(), [&](const Corner& corner) { return corner.name == name; })) {
    throw std::runtime_error(fmt::format("{}: a second corner '{}'; each needs a name of its own", place, name));
  }
  words.erase(words.begin());
  return name;
}

void AddBox(const Point& lower_left, const Point& size, const Stay& stay, std::vector<Wall>& walls) {
  const double right_m = lower_left.x_m + size.x_m;
  const double top_m = lower_left.y_m + size.y_m;
  const Point corners[] = {lower_left, {right_m, lower_left.y_m}, {right_m, top_m}, {lower_left.x_m, top_m}};
  for (std::size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4], stay});
}

/// Throws unless the laser can drive straight from one point to the other.
void CheckLeg(const std::vector<Wall>& walls, const Point& from, const Point& to, const std::string& place) {
  const double dx_m = to.x_m - from.x_m;
  const double dy_m = to.y_m - from.y_m;
  const double length_m = std::sqrt(dx_m * dx_m + dy_m * dy_m);
  if (length_m == 0.0) throw std::runtime_error(fmt::format("{}: this waypoint repeats the one before it", place));
  if (CastRay(walls, from, {dy_m / length_m, dx_m / length_m}) <= length_m) {
    throw std::runtime_error(fmt::format("{}: the way to this waypoint goes through a wall; go around it", place));
  }
}

World::Laser MakeLaser(const std::string& place, const std::vector<double>& numbers, const Options& options) {
  if (numbers[1] != std::floor(numbers[1])) {
    throw std::runtime_error(fmt::format("{}: laser beams is {}, must be a whole number", place, numbers[1]));
  }
  return {numbers[0] * kPi / 180.0,
          static_cast<int>(numbers[1]),
          numbers[2],
          numbers[3],
          numbers[4],
          options.Get("dropout", 0.0),
          options.Get("quantum_m", 0.0),
          options.Get("sweep_s", 0.0),
          options.Get("angle_scale", 1.0)};
}

World::Wheels MakeWheels(const std::vector<double>& numbers, const Options& options) {
  const double yaw_rad = options.Get("yaw_deg", 0.0) * kPi / 180.0;
  return {numbers[0],
          numbers[1],
          numbers[2],
          numbers[3],
          {options.Get("x_m", 0.0), options.Get("y_m", 0.0), yaw_rad},
          options.Get("delay_s", 0.0)};
}

/// Throws unless there is something to see, and a way that can be driven. counts: of lines by their keys.
/// waypoint_places: where the points of the path stand in the file.
void Check(const World& world, const std::map<std::string, int>& counts,
           const std::vector<std::string>& waypoint_places, const std::string& name) {
  for (const char* key : {"laser", "speed"}) {
    if (counts.count(key) == 0) throw std::runtime_error(fmt::format("{}: no line '{}'", name, Usage(key)));
  }
  if (world.walls.empty())
    throw std::runtime_error(fmt::format("{}: no wall and no box; there is nothing to see", name));
  if (world.path.size() < 2) {
    throw std::runtime_error(fmt::format("{}: {} waypoints, must be two or more", name, world.path.size()));
  }
  std::vector<Wall> lasting;
  std::copy_if(world.walls.begin(), world.walls.end(), std::back_inserter(lasting),
               [](const Wall& wall) { return wall.stay.IsAlways(); });
  for (std::size_t i = 1; i < world.path.size(); ++i) {
    CheckLeg(lasting, world.path[i - 1], world.path[i], waypoint_places[i]);
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
    std::vector<std::string> rest{std::istream_iterator<std::string>(words), {}};
    const Options options(place, key, rest);
    const std::string corner_name = key == "corner" ? TakeName(place, rest, world.corners) : "";
    const std::vector<double> numbers = ReadNumbers(place, key, rest);
    ++counts[key];
    const Stay stay = ReadStay(place, options);
    if (key == "wall") {
      world.walls.push_back({{numbers[0], numbers[1]}, {numbers[2], numbers[3]}, stay});
    } else if (key == "box") {
      AddBox({numbers[0], numbers[1]}, {numbers[2], numbers[3]}, stay, world.walls);
    } else if (key == "waypoint") {
      world.path.push_back({numbers[0], numbers[1]});
      waypoint_places.push_back(place);
    } else if (key == "corner") {
      world.corners.push_back({corner_name, {numbers[0], numbers[1]}});
    } else if (key == "person") {
      world.people.push_back({{numbers[0], numbers[1]}, {numbers[2], numbers[3]}, numbers[4], stay});
    } else if (key == "companion") {
      world.companions.push_back({numbers[0], numbers[1], stay});
    } else if (counts[key] > 1) {
      throw std::runtime_error(fmt::format("{}: a second '{}' line; there must be one", place, key));
    } else if (key == "laser") {
      world.laser = MakeLaser(place, numbers, options);
    } else if (key == "wheels") {
      world.wheels = MakeWheels(numbers, options);
    } else {
      world.linear_m_s = numbers[0];
      world.angular_rad_s = numbers[1];
    }
  }
  Check(world, counts, waypoint_places, name);
  return world;
}

std::vector<std::string> ListBuiltInWorlds() {
  std::vector<std::string> names;
  for (const BuiltInWorld& world : kBuiltInWorlds) names.emplace_back(world.name);
  return names;
}

std::string DescribeBuiltInWorlds() {
  std::vector<std::string> names = ListBuiltInWorlds();
  names.push_back("campus[:LENGTH_M[:NUMBER]]");
  return ListOf(names);
}

std::string LoadWorldText(const std::string& name) {
  if (const auto campus = ParseCampus(name)) return DrawCampus(campus->length_m, campus->number);
  for (const BuiltInWorld& world : kBuiltInWorlds) {
    if (world.name == name) return std::string(world.text);
  }
  if (std::error_code error; !std::filesystem::exists(name, error)) {
    std::vector<std::string> names = ListBuiltInWorlds();
    names.emplace_back("campus");
    throw std::runtime_error(
        fmt::format("there is no world file {} and no built-in world of that name; the built-in worlds are {}{}", name,
                    DescribeBuiltInWorlds(), SuggestName(name, names, "sim:")));
  }
  return ReadWholeFile(name);
}

World LoadWorld(const std::string& name) { return ParseWorld(LoadWorldText(name), name); }

}  // namespace crsm
