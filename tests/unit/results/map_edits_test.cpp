#include "common/results/map_edits.hpp"

#include <cmath>
#include <deque>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "catch.hpp"
#include "common/logs/read_map.hpp"
#include "scratch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr double kCell_m = 0.05;

/// Unexplored, from -3 m and -2 m on, 8 m x 6 m.
DenseGrid Unexplored() { return {160, 120, -60, -40, kCell_m, std::vector<std::uint8_t>(160 * 120, kUnexploredByte)}; }

void Fill(DenseGrid& grid, double x0_m, double y0_m, double x1_m, double y1_m, std::uint8_t byte) {
  for (int row = 0; row < grid.height_cells; ++row) {
    for (int column = 0; column < grid.width_cells; ++column) {
      const double x_m = (grid.origin_x_cells + column + 0.5) * grid.cell_size_m;
      const double y_m = (grid.origin_y_cells + row + 0.5) * grid.cell_size_m;
      if (x_m > x0_m && x_m < x1_m && y_m > y0_m && y_m < y1_m) grid.cells[grid.IndexOf(column, row)] = byte;
    }
  }
}

/// A free room from (0, 0) to (4, 3) with walls of two cells, and a pillar of 0.2 m at (1, 2).
DenseGrid Room() {
  DenseGrid grid = Unexplored();
  Fill(grid, -0.1, -0.1, 4.1, 3.1, kOccupiedByte);
  Fill(grid, 0.0, 0.0, 4.0, 3.0, kFreeByte);
  Fill(grid, 0.9, 1.9, 1.1, 2.1, kOccupiedByte);
  return grid;
}

std::uint8_t At(const DenseGrid& grid, const Point& point) {
  const auto column = static_cast<int>(std::floor(point.x_m / grid.cell_size_m)) - grid.origin_x_cells;
  const auto row = static_cast<int>(std::floor(point.y_m / grid.cell_size_m)) - grid.origin_y_cells;
  if (column < 0 || row < 0 || column >= grid.width_cells || row >= grid.height_cells) return kUnexploredByte;
  return grid.cells[grid.IndexOf(column, row)];
}

/// A folder in which the edited map is read as any map is: by its yaml alone.
DenseGrid ReadEdited(const fs::path& dir) {
  const fs::path alone = dir / "alone";
  fs::create_directories(alone);
  std::ifstream yaml(dir / "map_edited.yaml");
  std::ofstream out(alone / "map.yaml");
  for (std::string line; std::getline(yaml, line);)
    out << (line.starts_with("image:") ? "image: map.png" : line) << "\n";
  out.close();
  fs::copy_file(dir / "map_edited.png", alone / "map.png", fs::copy_options::overwrite_existing);
  return ReadMap(alone);
}

/// Where the yaml says that points of the map lie in the edited one.
Pose2 ReadTransform(const fs::path& yaml) {
  std::ifstream lines(yaml);
  Pose2 T_edited_map{NAN, NAN, NAN};
  for (std::string line; std::getline(lines, line);) {
    std::sscanf(line.c_str(), "# T_edited_map: [%lf, %lf, %lf]", &T_edited_map.x_m, &T_edited_map.y_m,
                &T_edited_map.yaw_rad);
  }
  return T_edited_map;
}

struct Exported {
  DenseGrid grid;
  Pose2 T_edited_map;
};

Exported Export(const DenseGrid& map, const MapEdits& edits, const std::vector<PlacedMark>& marks = {}) {
  const ScratchFolder scratch;
  Replacement files(scratch.path());
  AddEditedMap(map, marks, edits, files);
  files.Rename();
  const Exported exported{ReadEdited(scratch.path()), ReadTransform(scratch.path() / "map_edited.yaml")};
  std::ifstream stream(scratch.path() / kEditsFile);
  const auto json = nlohmann::json::parse(stream).at("T_edited_map");
  CHECK(json.at("x_m") == exported.T_edited_map.x_m);
  CHECK(json.at("y_m") == exported.T_edited_map.y_m);
  CHECK(std::abs(json.at("yaw_rad").get<double>() - exported.T_edited_map.yaw_rad) < 1e-8);  // nine digits in the yaml
  CHECK(FormatMapEdits(ReadMapEdits(scratch.path() / kEditsFile)) == FormatMapEdits(edits));
  return exported;
}

/// Whether one who goes up, down, left and right over what is not occupied comes from a place to the edge.
bool LeadsOut(const DenseGrid& grid, const Point& from) {
  const auto column = static_cast<int>(std::floor(from.x_m / grid.cell_size_m)) - grid.origin_x_cells;
  const auto row = static_cast<int>(std::floor(from.y_m / grid.cell_size_m)) - grid.origin_y_cells;
  std::vector<bool> seen(grid.cells.size());
  std::deque<std::pair<int, int>> waiting{{column, row}};
  while (!waiting.empty()) {
    const auto [x, y] = waiting.front();
    waiting.pop_front();
    if (x < 0 || y < 0 || x >= grid.width_cells || y >= grid.height_cells) return true;
    const std::size_t index = grid.IndexOf(x, y);
    if (seen[index] || IsOccupied(grid.cells[index])) continue;
    seen[index] = true;
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) waiting.emplace_back(x + dx, y + dy);
  }
  return false;
}

std::string FaultOf(const std::string& json) {
  try {
    ParseMapEdits(json);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("a map without edits is the same, in the smallest rectangle around what is explored") {
  const DenseGrid room = Room();
  const Exported exported = Export(room, {});
  CHECK(exported.T_edited_map == Pose2{});
  const DenseGrid& grid = exported.grid;
  CHECK(grid.width_cells == 84);  // 4.2 m and 3.2 m with the walls
  CHECK(grid.height_cells == 64);
  CHECK(grid.origin_x_cells == -2);
  CHECK(grid.origin_y_cells == -2);
  for (double x_m = -0.975; x_m < 5; x_m += kCell_m) {
    for (double y_m = -0.975; y_m < 4; y_m += kCell_m) REQUIRE(At(grid, {x_m, y_m}) == At(room, {x_m, y_m}));
  }
}

TEST_CASE(
    "a wall has the coordinates that it had, by the transform in the yaml, however the map is cropped and turned") {
  const DenseGrid room = Room();
  for (const double turn_deg : {0.0, 90.0, 180.0, -90.0, 360.0, 12.5, -33.0, 71.3}) {
    for (const bool is_cropped : {false, true}) {
      INFO(turn_deg << (is_cropped ? ", cropped" : ""));
      MapEdits edits;
      edits.turn_deg = turn_deg;
      if (is_cropped) edits.crop = {{-0.5, -0.5}, {2.0, 3.5}};  // without the right wall
      const auto [grid, T_edited_map] = Export(room, edits);
      const auto Seen = [&](double x_m, double y_m) { return At(grid, Apply(T_edited_map, {x_m, y_m})); };
      CHECK(IsOccupied(Seen(-0.05, 1.5)));  // in the middle of the left wall
      CHECK(IsOccupied(Seen(1.0, 3.05)));   // and of the upper one
      CHECK(IsOccupied(Seen(1.0, 2.0)));    // the pillar
      CHECK(IsFree(Seen(0.1, 1.5)));        // two cells off a wall: a turn thickens it by less than one
      CHECK(IsFree(Seen(1.0, 2.2)));
      CHECK(Seen(-0.3, 1.5) == kUnexploredByte);
      CHECK(Seen(4.05, 1.5) == (is_cropped ? kUnexploredByte : kOccupiedByte));
      CHECK(Seen(1.9, 1.5) == kFreeByte);
      CHECK(Seen(2.1, 1.5) == (is_cropped ? kUnexploredByte : kFreeByte));
    }
  }
}

TEST_CASE("a quarter turn moves cells and changes none") {
  const DenseGrid room = Room();
  MapEdits edits;
  edits.turn_deg = 90.0;
  const DenseGrid turned = ApplyEdits(room, edits);
  CHECK(turned.width_cells == 64);
  CHECK(turned.height_cells == 84);
  CHECK(turned.origin_x_cells == -62);  // what was up to y = 3.1 m is left of the origin now
  CHECK(turned.origin_y_cells == -2);
  CHECK(std::ranges::count(turned.cells, kOccupiedByte) == std::ranges::count(room.cells, kOccupiedByte));
  CHECK(std::ranges::count(turned.cells, kFreeByte) == std::ranges::count(room.cells, kFreeByte));
}

TEST_CASE("walls that are closed stay closed when they are turned, also walls of one cell") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> degrees(-360.0, 360.0);
  for (int round = 0; round < 200; ++round) {
    DenseGrid grid = Unexplored();
    // An outline of four corners around (0.5, 0.5), drawn as a line of cells that touch by corners.
    const double tilt = degrees(random) / 57.3;
    for (int side = 0; side < 4; ++side) {
      const double from = tilt + side * 1.5708;
      const double x0 = 10 + 30 * std::cos(from);
      const double y0 = 10 + 30 * std::sin(from);
      const double x1 = 10 + 30 * std::cos(from + 1.5708);
      const double y1 = 10 + 30 * std::sin(from + 1.5708);
      const int steps = static_cast<int>(std::ceil(std::max(std::abs(x1 - x0), std::abs(y1 - y0))));
      for (int i = 0; i <= steps; ++i) {
        const double share = static_cast<double>(i) / steps;
        const int column = static_cast<int>(std::round(x0 + share * (x1 - x0))) - grid.origin_x_cells;
        const int row = static_cast<int>(std::round(y0 + share * (y1 - y0))) - grid.origin_y_cells;
        grid.cells[grid.IndexOf(column, row)] = kOccupiedByte;
      }
    }
    REQUIRE_FALSE(LeadsOut(grid, {0.525, 0.525}));
    MapEdits edits;
    edits.turn_deg = degrees(random);
    INFO("tilt " << tilt << ", turn " << edits.turn_deg);
    CHECK_FALSE(LeadsOut(ApplyEdits(grid, edits), Apply(TransformOf(edits), {0.525, 0.525})));
  }
}

TEST_CASE("what is erased becomes free where it was seen, or unexplored as a whole; the map itself stays") {
  const DenseGrid room = Room();
  const std::vector<std::uint8_t> before = room.cells;
  MapEdits edits;
  edits.erase = {{MapEdits::Becomes::kFree, {{0.8, 1.8}, {1.2, 1.8}, {1.2, 2.2}, {0.8, 2.2}}},  // the pillar
                 {MapEdits::Becomes::kFree, {{3.5, 1.0}, {5.0, 1.0}, {5.0, 2.0}, {3.5, 2.0}}},  // through the wall
                 {MapEdits::Becomes::kUnexplored, {{-1.0, -1.0}, {5.0, -1.0}, {5.0, 0.5}, {-1.0, 0.5}}}};
  const DenseGrid edited = ApplyEdits(room, edits);
  CHECK(At(edited, {1.0, 2.0}) == kFreeByte);
  CHECK(At(edited, {4.05, 1.5}) == kFreeByte);
  CHECK(At(edited, {4.05, 2.5}) == kOccupiedByte);
  CHECK(At(edited, {4.3, 1.5}) == kUnexploredByte);  // nobody has seen it
  CHECK(At(edited, {1.0, 0.3}) == kUnexploredByte);
  CHECK(At(edited, {-0.05, 0.3}) == kUnexploredByte);
  CHECK(At(edited, {-0.05, 0.7}) == kOccupiedByte);
  CHECK(edited.origin_y_cells == 10);  // the rows below are gone
  CHECK(room.cells == before);
}

TEST_CASE("a map is cropped to an outline, also to one that is not convex") {
  MapEdits edits;
  edits.crop = {{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}, {3.0, 1.0}, {0.0, 1.0}};
  const DenseGrid edited = ApplyEdits(Room(), edits);
  CHECK(At(edited, {2.0, 0.5}) == kFreeByte);
  CHECK(At(edited, {3.9, 2.0}) == kFreeByte);
  CHECK(At(edited, {1.0, 2.0}) == kUnexploredByte);
  CHECK(At(edited, {3.0, 2.0}) == kUnexploredByte);
  CHECK(edited.width_cells == 80);
}

TEST_CASE("masks lie on the edited map as zones do on the map") {
  PlacedMark zone;
  zone.id = "z";
  zone.kind = kKeepOutKind;
  zone.points = {{2.0, 1.0}, {3.0, 1.0}, {3.0, 2.0}, {2.0, 2.0}};
  const ScratchFolder scratch;
  MapEdits edits;
  edits.turn_deg = 30.0;
  Replacement files(scratch.path());
  AddEditedMap(Room(), {zone}, edits, files);
  files.Rename();
  CHECK_FALSE(fs::exists(scratch.path() / "slow_edited.png"));
  fs::rename(scratch.path() / "keepout_edited.png", scratch.path() / "map_edited.png");
  const DenseGrid mask = ReadEdited(scratch.path());  // by the yaml of the map: it has the same cells
  const auto Seen = [&](double x_m, double y_m) { return At(mask, Apply(TransformOf(edits), {x_m, y_m})); };
  CHECK(Seen(2.5, 1.5) == 0);
  CHECK(Seen(2.1, 1.9) == 0);
  CHECK(Seen(1.8, 1.5) == 255);
  CHECK(Seen(2.5, 2.2) == 255);
}

TEST_CASE("edits that leave nothing, or far too much, are refused by their key") {
  MapEdits nowhere;
  nowhere.crop = {{50.0, 50.0}, {60.0, 60.0}};
  CHECK_THROWS_WITH(ApplyEdits(Room(), nowhere), "crop_m, erase: nothing is left of the map");
  DenseGrid tiny = Unexplored();
  CHECK_THROWS_WITH(ApplyEdits(tiny, {}), "crop_m, erase: nothing is left of the map");
  DenseGrid stripe{40000, 1, 0, 0, kCell_m, std::vector<std::uint8_t>(40000, kFreeByte)};
  MapEdits turned;
  turned.turn_deg = 45.0;
  CHECK_THROWS_WITH(ApplyEdits(stripe, turned), Catch::Matchers::StartsWith("turn_deg: the turned map has 2828"));
  turned.crop = {{0.0, -1.0}, {10.0, 1.0}};
  CHECK(ApplyEdits(stripe, turned).width_cells < 150);
}

TEST_CASE("what is no file of edits is refused in one line that names the key") {
  const auto Points = [](int num) {
    std::string text = "[";
    for (int i = 0; i < num; ++i) text += (i > 0 ? ",[0," : "[0,") + std::to_string(i) + "]";
    return text + "]";
  };
  std::string many = "[";
  for (int i = 0; i < 101; ++i) many += (i > 0 ? "," : "") + ("{\"outline_m\": " + Points(3) + "}");
  many += "]";
  const auto Erasure = [](const std::string& inner) {
    return "{\"erase\": [{\"outline_m\": [[0,0],[1,0],[0,1]]}, " + inner + "]}";
  };
  for (const auto& [json, expected] : std::vector<std::pair<std::string, std::string>>{
           {"", "must be a JSON object"},
           {"[]", "must be a JSON object"},
           {"{\"turn_deg\": NaN}", "must be a JSON object"},
           {"{\"turn_deg\": 1e999}", "must be a JSON object"},
           {std::string(100000, '['), "must be a JSON object"},
           {"{\"colour\": 1}", "\"colour\" is no key: they are crop_m, erase, turn_deg"},
           {"{\"a\\nb\\u001b\": 1}", "\"a\\nb\\u001b\" is no key"},
           {"{\"" + std::string(9000, 'x') + "\": 1}", "\"xxxxxxxx"},
           {"{\"turn_deg\": \"NaN\"}", "turn_deg: must be a number from -360 to 360"},
           {"{\"turn_deg\": 361}", "turn_deg: must be a number from -360 to 360"},
           {"{\"turn_deg\": null}", "turn_deg: "},
           {"{\"crop_m\": 5}", "crop_m: must be a list of 2 to 64 points [x, y]"},
           {"{\"crop_m\": [[0, 0]]}", "crop_m: must be a list of 2 to 64 points [x, y], and has 1"},
           {"{\"crop_m\": " + Points(65) + "}", "and has 65"},
           {"{\"crop_m\": " + Points(50000) + "}", "and has 50000"},
           {"{\"crop_m\": [[0, 0], [1, 2, 3]]}", "crop_m[1]: must be two numbers"},
           {"{\"crop_m\": [[0, 0], [1, 1e7]]}", "crop_m[1]: must be a number from -1e+06 to 1e+06"},
           {"{\"crop_m\": [[0, 0], [1, true]]}", "crop_m[1]: must be a number"},
           {"{\"crop_m\": {\"0\": [0, 0]}}", "crop_m: must be a list"},
           {"{\"erase\": {}}", "erase: must be a list of at most 100 outlines"},
           {"{\"erase\": " + many + "}", "erase: must be a list of at most 100 outlines"},
           {Erasure("7"), "erase[1]: must be an object"},
           {Erasure("{}"), "erase[1].outline_m: must be a list of 3 to 64 points"},
           {Erasure("{\"outline_m\": [[0,0],[1,1]]}"),
            "erase[1].outline_m: must be a list of 3 to 64 points [x, y], and has 2"},
           {Erasure("{\"becomes\": \"wall\", \"outline_m\": [[0,0],[1,1],[1,0]]}"),
            "erase[1].becomes: must be \"free\""},
           {Erasure("{\"becomes\": 1, \"outline_m\": [[0,0],[1,1],[1,0]]}"), "erase[1].becomes: "},
           {Erasure("{\"to\": 1}"), "erase[1].\"to\" is no key"}}) {
    INFO(json.substr(0, 80));
    const std::string fault = FaultOf(json);
    CHECK(fault.find(expected) != std::string::npos);
    CHECK(fault.size() < 150);
    CHECK(std::ranges::all_of(fault, [](char c) { return c >= 0x20 && c < 0x7f; }));
  }
  CHECK(FaultOf("{}").empty());
  const ScratchFolder scratch;
  const fs::path path = scratch.path() / "edits.json";
  std::ofstream(path) << "{\"crop_m\": 5}";
  CHECK_THROWS_WITH(ReadMapEdits(path), Catch::Matchers::StartsWith(path.string() + ": crop_m: "));
  std::ofstream(path) << "{\"crop_m\": [" << std::string(2'000'000, ' ') << "]}";
  CHECK_THROWS_WITH(ReadMapEdits(path), Catch::Matchers::StartsWith("cannot read " + path.string()));
  CHECK_THROWS_WITH(ReadMapEdits("/dev/zero"), Catch::Matchers::StartsWith("cannot read /dev/zero"));
}

}  // namespace crsm
