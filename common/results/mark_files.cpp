#include "common/results/mark_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "common/logs/regular_file.hpp"
#include "common/math/parse_number.hpp"
#include "common/results/json_text.hpp"

namespace crsm {
namespace {

constexpr const char* kCsv = "marks.csv";
constexpr const char* kGeoJson = "marks.geojson";

std::string Quote(const std::string& text) {
  if (text.find_first_of(",\"") == std::string::npos && !text.starts_with('#')) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// The root of the larger eigenvalue.
double LargestSigma(const std::array<double, 3>& covariance) {
  const auto& [xx, xy, yy] = covariance;
  const double half = 0.5 * (xx - yy);
  return std::sqrt(0.5 * (xx + yy) + std::sqrt(half * half + xy * xy));
}

std::string Join(const std::vector<Point>& points, double Point::*coordinate) {
  std::string text;
  for (const Point& point : points) {
    const double rounded = std::round(point.*coordinate * 1e3) / 1e3 + 0.0;  // never -0
    text += fmt::format("{}{:.3f}", text.empty() ? "" : ";", rounded);
  }
  return text;
}

nlohmann::ordered_json ToJson(const PlacedMark& mark) {
  nlohmann::ordered_json coordinates;
  for (const auto& [x_m, y_m] : mark.points) coordinates.push_back({x_m, y_m});
  if (mark.is_outline()) {
    coordinates.push_back(coordinates.front());
    coordinates = nlohmann::ordered_json::array({coordinates});
  } else {
    coordinates = coordinates.front();
  }
  return {{"type", "Feature"},
          {"id", mark.id},
          {"properties",
           {{"kind", mark.kind},
            {"name", mark.name},
            {"utime", mark.utime},
            {"sightings", mark.num_sightings},
            {"covariance_m2", mark.covariance},
            {"floating", mark.floating}}},
          {"geometry", {{"type", mark.is_outline() ? "Polygon" : "Point"}, {"coordinates", coordinates}}}};
}

PlacedMark FromJson(const nlohmann::json& feature) {
  PlacedMark mark;
  const nlohmann::json& properties = feature.at("properties");
  feature.at("id").get_to(mark.id);
  properties.at("kind").get_to(mark.kind);
  properties.at("name").get_to(mark.name);
  properties.at("utime").get_to(mark.utime);
  properties.at("sightings").get_to(mark.num_sightings);
  properties.at("covariance_m2").get_to(mark.covariance);
  properties.at("floating").get_to(mark.floating);
  const nlohmann::json& coordinates = feature.at("geometry").at("coordinates");
  const auto ToPoint = [](const nlohmann::json& pair) {
    return Point{pair.at(0).get<double>(), pair.at(1).get<double>()};
  };
  if (feature.at("geometry").at("type") == "Point") {
    mark.points = {ToPoint(coordinates)};
  } else {
    for (const nlohmann::json& pair : coordinates.at(0)) mark.points.push_back(ToPoint(pair));
    if (mark.points.size() > 1) mark.points.pop_back();
  }
  return mark;
}

/// The cells of a line, of which some may be in quotes. Nothing where a quote is not closed, or is followed by text.
std::optional<std::vector<std::string>> SplitLine(const std::string& line) {
  std::vector<std::string> cells(1);
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && cells.back().empty()) {
      for (++i;; ++i) {
        if (i >= line.size()) return std::nullopt;
        if (line[i] != '"') {
          cells.back() += line[i];
        } else if (i + 1 < line.size() && line[i + 1] == '"') {
          cells.back() += line[i++];
        } else {
          break;
        }
      }
      if (i + 1 < line.size() && line[i + 1] != ',') return std::nullopt;
    } else if (line[i] == ',') {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  return cells;
}

constexpr std::array kColumns{"time_s", "x_m", "y_m", "kind", "name", "id", "radius_m", "sightings", "floating"};

/// A list of marks, line by line.
class MarkList {
 public:
  explicit MarkList(const std::string& path) : path_(path) {}

  std::vector<ListedMark> Read() {
    constexpr std::size_t kMostBytes = std::size_t{1} << 22;
    std::istringstream lines(ReadWholeFile(path_, kMostBytes));
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      if (line_ == 1 && line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // spreadsheets begin files with it
      if (line.ends_with('\r')) line.pop_back();
      if (line.empty() || line.starts_with('#')) continue;
      const auto cells = SplitLine(line);
      if (!cells) Fail("has a quote that is not closed");
      columns_.empty() ? TakeHeader(*cells) : TakeLine(*cells);
    }
    if (columns_.empty()) Fail("has no header: the first line must name the columns, as in time_s,kind,name");
    return std::move(marks_);
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw std::runtime_error(fmt::format("{}:{}: {}", path_, std::max(1, line_), what));
  }

  void TakeHeader(const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::ranges::find(kColumns, names[i]) == kColumns.end()) {
        Fail(fmt::format("'{}' is no column: they are {}", names[i], fmt::join(kColumns, ", ")));
      }
      if (!columns_.emplace(names[i], i).second) Fail(fmt::format("the column {} is there twice", names[i]));
    }
    if (!columns_.contains("kind")) Fail("the column kind is missing");
    const bool has_place = columns_.contains("x_m") && columns_.contains("y_m");
    if (columns_.contains("x_m") != columns_.contains("y_m")) Fail("x_m and y_m come together");
    if (!has_place && !columns_.contains("time_s")) Fail("the columns x_m and y_m, or time_s, are missing");
  }

  std::string Cell(const std::vector<std::string>& cells, const std::string& column) const {
    const auto found = columns_.find(column);
    return found == columns_.end() ? "" : cells[found->second];
  }

  double ToNumber(const std::string& text, const char* column) const {
    const auto number = ParseNumber<double>(text);
    if (!number || !std::isfinite(*number)) Fail(fmt::format("{}: '{}' is no number", column, text));
    return *number;
  }

  std::vector<double> ToNumbers(const std::string& text, const char* column) const {
    std::vector<double> numbers;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ';');) numbers.push_back(ToNumber(part, column));
    return numbers;
  }

  void TakeLine(const std::vector<std::string>& cells) {
    constexpr double kLatest_s = 4.5e9;
    if (cells.size() != columns_.size()) {
      Fail(fmt::format("has {} columns, and the header {}", cells.size(), columns_.size()));
    }
    if (Cell(cells, "floating") == "1") return;  // it has no place on the map
    Mark mark;
    mark.kind = Cell(cells, "kind");
    mark.name = Cell(cells, "name");
    mark.id = Cell(cells, "id");
    if (mark.id.empty()) mark.id = fmt::format("{} of line {}", mark.kind, line_);
    if (const std::string text = Cell(cells, "radius_m"); !text.empty()) mark.radius_m = ToNumber(text, "radius_m");
    const std::string time = Cell(cells, "time_s");
    mark.in_map_frame = time.empty();
    mark.utime = line_;
    if (!time.empty()) {
      const double time_s = ToNumber(time, "time_s");
      if (!(time_s >= 0.0 && time_s <= kLatest_s)) Fail(fmt::format("time_s: {} must be 0 to {:g}", time, kLatest_s));
      mark.utime = std::llround(time_s * 1e6);
    }
    std::vector<double> x_m = ToNumbers(Cell(cells, "x_m"), "x_m");
    std::vector<double> y_m = ToNumbers(Cell(cells, "y_m"), "y_m");
    if (x_m.size() != y_m.size()) Fail(fmt::format("has {} x_m and {} y_m", x_m.size(), y_m.size()));
    if (x_m.empty() && mark.in_map_frame) Fail("has neither a place, x_m and y_m, nor a time_s");
    if (x_m.empty()) x_m = y_m = {0.0};
    for (std::size_t i = 0; i < x_m.size(); ++i) mark.points.push_back({x_m[i], y_m[i]});
    if (const std::string fault = DescribeFault(mark); !fault.empty()) Fail(fault);
    marks_.push_back({std::move(mark), line_});
  }

  std::string path_;
  int line_ = 0;
  std::map<std::string, std::size_t> columns_;
  std::vector<ListedMark> marks_;
};

}  // namespace

std::string FormatMarksCsv(const std::vector<PlacedMark>& marks) {
  std::string text = "id,kind,name,x_m,y_m,radius_m,sightings,floating\n";
  for (const PlacedMark& mark : marks) {
    text += fmt::format("{},{},{},{},{},{:.3f},{},{}\n", Quote(mark.id), mark.kind, Quote(mark.name),
                        Join(mark.points, &Point::x_m), Join(mark.points, &Point::y_m), LargestSigma(mark.covariance),
                        mark.num_sightings, mark.floating ? 1 : 0);
  }
  return text;
}

std::string FormatMarksGeoJson(const std::vector<PlacedMark>& marks) {
  nlohmann::ordered_json json{{"type", "FeatureCollection"},
                              {"coordinates_are", "metres in the frame of the map"},
                              {"features", nlohmann::ordered_json::array()}};
  for (const PlacedMark& mark : marks) json["features"].push_back(ToJson(mark));
  return ToText(json, 1) + "\n";
}

void AddMarks(const std::vector<PlacedMark>& marks, Replacement& files) {
  if (marks.empty()) return;
  files.Write(kCsv, FormatMarksCsv(marks));
  files.Write(kGeoJson, FormatMarksGeoJson(marks));
}

std::vector<PlacedMark> ReadMarks(const std::filesystem::path& dir) {
  const std::filesystem::path path = dir / kGeoJson;
  constexpr std::size_t kMostBytes = std::size_t{1} << 22;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return {};
  std::vector<PlacedMark> marks;
  try {
    const auto json = nlohmann::json::parse(ReadWholeFile(path, kMostBytes));
    for (const nlohmann::json& feature : json.at("features")) {
      marks.push_back(FromJson(feature));
      const std::string fault = DescribeFault(marks.back());
      if (!fault.empty())
        throw std::runtime_error(fmt::format("{}: feature {}: {}", path.string(), marks.size(), fault));
    }
  } catch (const nlohmann::json::exception&) {
    throw std::runtime_error(
        fmt::format("{}: feature {} is not as slam_offline writes it: a point or a polygon with id, "
                    "kind, name, utime, sightings, covariance_m2 and floating",
                    path.string(), marks.size() + 1));
  }
  return marks;
}

std::vector<ListedMark> ReadMarkList(const std::string& path) { return MarkList(path).Read(); }

}  // namespace crsm
