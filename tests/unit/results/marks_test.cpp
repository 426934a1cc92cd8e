#include <geotiff/geotiffio.h>
#include <geotiff/xtiffio.h>
#include <png.h>
#include <tiffio.h>

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "common/results/mark_files.hpp"
#include "common/results/mark_masks.hpp"
#include "common/results/rescue_map.hpp"
#include "common/results/results.hpp"
#include "scratch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

PlacedMark Victim(const std::string& id, const Point& at) {
  return {5, id, "victim", "in the hall", 3, {0.04, 0.0, 0.01}, false, {at}};
}

PlacedMark Zone(const std::string& kind, std::vector<Point> corners) {
  return {7, kind, kind, "say \"no\", please", 1, {0.25, 0.0, 0.25}, false, std::move(corners)};
}

/// Free, 8 m x 6 m in cells of 0.05 m, from -2 m and -1 m on, with a wall of one cell around it; its left half is
/// unexplored.
DenseGrid Hall() {
  DenseGrid grid{160, 120, -40, -20, 0.05, std::vector<std::uint8_t>(160 * 120, kFreeByte)};
  for (int row = 0; row < 120; ++row) {
    for (int column = 0; column < 160; ++column) {
      const bool is_wall = row == 0 || row == 119 || column == 159 || column == 80;
      if (is_wall) grid.cells[grid.IndexOf(column, row)] = kOccupiedByte;
      if (column < 80) grid.cells[grid.IndexOf(column, row)] = kUnexploredByte;
    }
  }
  return grid;
}

std::vector<ListedMark> ReadList(const fs::path& path, const std::string& text) {
  std::ofstream(path) << text;
  return ReadMarkList(path.string());
}

struct Mask {
  unsigned width = 0;
  unsigned height = 0;
  std::vector<std::uint8_t> bytes;
  /// At a place of the map.
  int At(const DenseGrid& grid, double x_m, double y_m) const {
    const int column = static_cast<int>(std::floor(x_m / grid.cell_size_m)) - grid.origin_x_cells;
    const int row = static_cast<int>(std::floor(y_m / grid.cell_size_m)) - grid.origin_y_cells;
    return bytes.at((height - 1 - static_cast<unsigned>(row)) * width + static_cast<unsigned>(column));
  }
};

Mask ReadMask(const fs::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, path.c_str()));
  REQUIRE(image.format == PNG_FORMAT_GRAY);
  Mask mask{image.width, image.height, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  REQUIRE(png_image_finish_read(&image, nullptr, mask.bytes.data(), 0, nullptr));
  return mask;
}

using Colour = std::array<std::uint8_t, 3>;

/// A GeoTIFF as libtiff and libgeotiff read it.
struct Picture {
  explicit Picture(const fs::path& path) {
    TIFF* tiff = XTIFFOpen(path.c_str(), "r");
    REQUIRE(tiff);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    std::uint16_t num = 0;
    double* values = nullptr;
    REQUIRE(TIFFGetField(tiff, TIFFTAG_GEOPIXELSCALE, &num, &values));
    pixel_m = values[0];
    CHECK(values[1] == pixel_m);
    REQUIRE(TIFFGetField(tiff, TIFFTAG_GEOTIEPOINTS, &num, &values));
    left_m = values[3];
    top_m = values[4];
    GTIF* keys = GTIFNew(tiff);
    GTIFKeyGet(keys, GTRasterTypeGeoKey, &raster_type, 0, 1);
    GTIFKeyGet(keys, ProjLinearUnitsGeoKey, &units, 0, 1);
    GTIFFree(keys);
    for (std::uint32_t row = 0; row < height; ++row) {
      std::vector<std::uint8_t> line(std::size_t{3} * width);
      REQUIRE(TIFFReadScanline(tiff, line.data(), row, 0) == 1);
      pixels.insert(pixels.end(), line.begin(), line.end());
    }
    XTIFFClose(tiff);
    for (std::size_t i = 0; i < pixels.size(); i += 3) ++counts[{pixels[i], pixels[i + 1], pixels[i + 2]}];
  }

  Colour At(double x_m, double y_m) const {
    const auto column = static_cast<std::size_t>((x_m - left_m) / pixel_m);
    const auto row = static_cast<std::size_t>((top_m - y_m) / pixel_m);
    const std::size_t i = 3 * (row * width + column);
    return {pixels.at(i), pixels.at(i + 1), pixels.at(i + 2)};
  }
  /// So much of the ground has a colour [m^2].
  double Area(const Colour& colour) const {
    const auto found = counts.find(colour);
    return found == counts.end() ? 0.0 : found->second * pixel_m * pixel_m;
  }

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  double pixel_m = 0.0;
  double left_m = 0.0;
  double top_m = 0.0;
  std::uint16_t raster_type = 0;
  std::uint16_t units = 0;
  std::vector<std::uint8_t> pixels;
  std::map<Colour, double> counts;
};

}  // namespace

TEST_CASE("what marks.csv says is read as a list again; marks.geojson gives back the same marks") {
  const ScratchFolder folder;
  CHECK(ReadList(folder / "marks.csv", FormatMarksCsv({Victim("#1", {1.5, -2.25})})).size() == 1);
  const std::vector<PlacedMark> marks{Victim("v,1", {1.5, -2.25}),
                                      Zone(kKeepOutKind, {{0.0, 0.0}, {2.0, 0.0}, {1.0, 1.5}})};
  const std::string csv = FormatMarksCsv(marks);
  CHECK(csv ==
        "id,kind,name,x_m,y_m,radius_m,sightings,floating\n"
        "\"v,1\",victim,in the hall,1.500,-2.250,0.200,3,0\n"
        "keep-out,keep-out,\"say \"\"no\"\", please\",0.000;2.000;1.000,0.000;0.000;1.500,0.500,1,0\n");
  const auto listed = ReadList(folder / "marks.csv", csv);
  REQUIRE(listed.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(listed[i].mark.id == marks[i].id);
    CHECK(listed[i].mark.name == marks[i].name);
    CHECK(listed[i].mark.points == marks[i].points);
    CHECK(listed[i].mark.in_map_frame);
    CHECK(listed[i].line == static_cast<int>(i) + 2);
  }
  std::ofstream(folder / "marks.geojson") << FormatMarksGeoJson(marks);
  CHECK(ReadMarks(folder / ".") == marks);
  const auto json = nlohmann::json::parse(FormatMarksGeoJson(marks));
  CHECK(json["features"][1]["geometry"]["coordinates"][0].size() == 4);  // closed
  CHECK(ReadMarks(folder / "nowhere").empty());
}

TEST_CASE("a list of marks has a header, and times or places; what is wrong is named with its file and line") {
  const ScratchFolder folder;
  const fs::path path = folder / "list.csv";
  const auto listed = ReadList(path,
                               "\xef\xbb\xbftime_s,kind,name,x_m,y_m,id\r\n"
                               "# two lines are no marks\r\n\r\n"
                               "12.5,victim,,,,v1\r\n"
                               "13.25,victim,,0.5,-1,v1\r\n"
                               ",door,front,3,4,\r\n");
  REQUIRE(listed.size() == 3);
  CHECK(listed[0].mark.utime == 12'500'000);
  CHECK(listed[0].mark.points == std::vector<Point>{{0.0, 0.0}});
  CHECK_FALSE(listed[1].mark.in_map_frame);
  CHECK(listed[1].mark.points == std::vector<Point>{{0.5, -1.0}});
  CHECK(listed[2].mark.in_map_frame);
  CHECK(listed[2].mark.id == "door of line 6");
  const auto ErrorFor = [&](const std::string& text) { return ErrorOf([&] { ReadList(path, text); }); };
  const auto Says = [&](const std::string& text, int line, const std::string& what) {
    const std::string error = ErrorFor(text);
    CAPTURE(error);
    return error.starts_with(path.string() + ":" + std::to_string(line) + ": ") &&
           error.find(what) != std::string::npos;
  };
  CHECK(Says("", 1, "no header"));
  CHECK(Says("kind,colour\n", 1, "'colour' is no column"));
  CHECK(Says("kind,kind,time_s\n", 1, "twice"));
  CHECK(Says("name,time_s\n", 1, "kind is missing"));
  CHECK(Says("kind,x_m\n", 1, "come together"));
  CHECK(Says("kind,name\n", 1, "or time_s"));
  CHECK(Says("kind,time_s\nvictim\n", 2, "1 columns, and the header 2"));
  CHECK(Says("kind,time_s\nvictim,x\n", 2, "'x' is no number"));
  CHECK(Says("kind,time_s\nvictim,nan\n", 2, "no number"));
  CHECK(Says("kind,time_s\nvictim,-1\n", 2, "must be 0 to"));
  CHECK(Says("kind,time_s\nvictim,\n", 2, "neither a place"));
  CHECK(Says("kind,x_m,y_m\ndoor,1;2,1\n", 2, "2 x_m and 1 y_m"));
  CHECK(Says("kind,x_m,y_m\ndoor,1;2,1;2\n", 2, "an outline 3 to 64"));
  CHECK(Says("kind,x_m,y_m\ndoor,1e7,1\n", 2, "within 1e6 m"));
  CHECK(Says("kind,x_m,y_m\n\nA Door,1,1\n", 3, "a-z, 0-9 and -"));
  CHECK(Says("kind,x_m,y_m,radius_m\ndoor,1,1,0\n", 2, "0.001 to 1000"));
  CHECK(Says("kind,x_m,y_m\n\"door,1,1\n", 2, "not closed"));
  CHECK(Says("kind,x_m,y_m\n\"door\"x,1,1\n", 2, "not closed"));
  CHECK_FALSE(ErrorOf([&] { ReadMarkList((folder / "nowhere").string()); }).empty());
}

TEST_CASE("a marks.geojson of somebody else is refused by its name") {
  const ScratchFolder folder;
  for (const std::string text : {"", "[]", "{\"features\": [1]}", "{\"features\": {\"a\": 1}}",
                                 R"({"features": [{"id": "a", "properties": {}, "geometry": {"type": "Point"}}]})"}) {
    std::ofstream(folder / "marks.geojson") << text;
    const std::string error = ErrorOf([&] { ReadMarks(folder / "."); });
    CAPTURE(text, error);
    CHECK(error.find("marks.geojson: feature 1 is not as") != std::string::npos);
  }
  PlacedMark far = Victim("v", {2e6, 0.0});
  std::ofstream(folder / "marks.geojson") << FormatMarksGeoJson({far});
  CHECK(ErrorOf([&] { ReadMarks(folder / "."); }).find("within 1e6 m") != std::string::npos);
}

TEST_CASE("zones become masks of the map's size: 100 in the mode scale to keep out, a percentage in the mode raw") {
  const ScratchFolder folder;
  const DenseGrid grid = Hall();
  Results results;
  results.grid = grid;
  results.marks = {Zone(kKeepOutKind, {{2.5, 0.0}, {4.5, 0.0}, {4.5, 2.0}, {2.5, 2.0}}),
                   Zone(kSlowKind, {{-100.0, 3.0}, {100.0, 3.0}, {100.0, 100.0}, {-100.0, 100.0}}),
                   Victim("v", {3.0, 1.0})};
  PlacedMark floating = Zone(kKeepOutKind, {{-2.0, -1.0}, {0.0, -1.0}, {0.0, 0.0}});
  floating.floating = true;
  results.marks.push_back(floating);
  WriteResults(folder / "out", results);
  const Mask keepout = ReadMask(folder / "out/keepout.png");
  CHECK(keepout.width == 160);
  CHECK(keepout.height == 120);
  for (const auto& [x_m, y_m, byte] : {std::tuple(3.5, 1.0, 0), std::tuple(2.52, 0.02, 0), std::tuple(4.48, 1.98, 0),
                                       std::tuple(2.3, 1.0, 255), std::tuple(4.7, 1.0, 255), std::tuple(3.5, 2.2, 255),
                                       std::tuple(3.5, -0.2, 255), std::tuple(-1.5, -0.8, 255)}) {
    CAPTURE(x_m, y_m);
    CHECK(keepout.At(grid, x_m, y_m) == byte);
  }
  const auto num_inside = std::ranges::count(keepout.bytes, 0);
  CHECK(std::abs(static_cast<double>(num_inside) - 1600.0) <= 2 * 160);  // 40 x 40 cells, and those it touches
  const Mask slow = ReadMask(folder / "out/slow.png");
  CHECK(slow.At(grid, 0.0, 3.5) == kSlowPercent);
  CHECK(slow.At(grid, -1.9, 4.9) == kSlowPercent);
  CHECK(slow.At(grid, 0.0, 2.5) == 0);
  const std::string yaml = BytesOf(folder / "out/keepout.yaml");
  CHECK(yaml.find("image: keepout.png\nmode: scale\nresolution: 0.05\norigin: [-2.000000, -1.000000, 0.0]\n") == 0);
  CHECK(BytesOf(folder / "out/slow.yaml").find("mode: raw\n") != std::string::npos);
  results.marks.pop_back();
  results.marks.erase(results.marks.begin());
  WriteResults(folder / "out", results);  // what is no zone any more leaves no mask
  CHECK_FALSE(fs::exists(folder / "out/keepout.png"));
  CHECK(fs::exists(folder / "out/slow.yaml"));
  CHECK(fs::exists(folder / "out/marks.csv"));
  CHECK_FALSE(fs::exists(folder / "out/map.tif"));
}

TEST_CASE(
    "map.tif is a GeoTIFF in the map's frame with the league's colours: checker, grid, walls, path, arrow, discs") {
  const ScratchFolder folder;
  Results results;
  results.grid = Hall();
  results.team = "Pandora";
  results.name = "final";
  std::vector<ScanMatch> matches;
  for (int i = 0; i <= 100; ++i) {
    matches.push_back({100 + i, {2.5 + 0.02 * i, 0.5, 0.0}, 0.9, 1, 1, 0, MatchState::kOk});
    matches.back().num_critical = 50;
  }
  results.matches = MatchSequence([&](const MatchSequence::Visit& visit) { std::ranges::for_each(matches, visit); });
  PlacedMark hazard = Victim("h", {5.0, 4.0});
  hazard.kind = "hazard";
  PlacedMark floating = Victim("f", {-1.0, 0.0});
  floating.floating = true;
  results.marks = {Victim("a", {3.0, 3.0}), Victim("b", {4.5, 1.5}), Victim("c", {3.0, 4.25}), hazard, floating};
  WriteResults(folder / "out", results);
  const Picture picture(folder / "out/map.tif");
  CHECK(picture.raster_type == RasterPixelIsArea);
  CHECK(picture.units == Linear_Meter);
  CHECK(picture.pixel_m == 0.02);
  CHECK(picture.left_m == -4.0);  // two metres around the hall
  CHECK(picture.top_m == 7.0);
  CHECK(picture.width == 600);
  CHECK(picture.height == 500);
  CHECK(picture.At(-1.5, 0.25) == Colour{226, 226, 227});
  CHECK(picture.At(-0.5, 0.25) == Colour{237, 237, 238});
  CHECK(picture.At(-0.5, 1.25) == Colour{226, 226, 227});
  CHECK(picture.At(2.02, 2.25) == Colour{0, 40, 120});  // the wall at x 2 m
  CHECK(picture.At(5.98, 2.25) == Colour{0, 40, 120});
  CHECK(picture.At(3.25, 2.25) == Colour{255, 255, 255});
  CHECK(picture.At(4.0, 0.5) == Colour{120, 0, 140});
  CHECK(picture.At(2.5, 0.5) == Colour{255, 200, 0});
  CHECK(picture.At(2.85, 3.0) == Colour{240, 10, 10});
  CHECK(picture.At(4.85, 4.0) == Colour{255, 100, 30});
  // Areas: 3.95 m x 5.9 m were explored, of which every 25th row and column is a line; discs have a radius of 0.2 m.
  const double explored_m2 = 3.95 * 5.9;
  CHECK(std::abs(picture.Area({255, 255, 255}) - explored_m2 * 24.0 / 25.0 * 24.0 / 25.0) < 1.0);
  CHECK(std::abs(picture.Area({190, 190, 191}) - explored_m2 * (1.0 - 24.0 / 25.0 * 24.0 / 25.0)) < 0.3);
  const double disc_m2 = 3.14159 * 0.2 * 0.2;
  CHECK(picture.Area({240, 10, 10}) > 3 * 0.6 * disc_m2);  // less the numbers
  CHECK(picture.Area({240, 10, 10}) < 3 * 1.05 * disc_m2);
  CHECK(picture.Area({255, 100, 30}) > 0.6 * disc_m2);
  const double walls_m2 = 0.05 * (6.0 + 6.0 + 3.9 + 3.9);
  CHECK(std::abs(picture.Area({0, 40, 120}) - walls_m2) < 0.25 * walls_m2);
  CHECK(picture.Area({0, 50, 140}) > 0.03);  // scale, axes, and the title
}

TEST_CASE("the overview shows places where they are, but none that floats, or that is far beyond all pictures") {
  const ScratchFolder folder;
  Results results;
  results.grid = Hall();
  WriteResults(folder / "without", results);
  PlacedMark floating = Victim("f", {3.0, 3.0});
  floating.floating = true;
  results.marks = {floating, Victim("far", {9e5, 9e5})};
  WriteResults(folder / "unseen", results);
  CHECK(BytesOf(folder / "without/overview.png") == BytesOf(folder / "unseen/overview.png"));
  results.marks.push_back(Victim("v", {3.0, 3.0}));
  results.marks.push_back(Zone("room", {{2.5, 0.0}, {4.5, 0.0}, {4.5, 2.0}}));
  WriteResults(folder / "seen", results);
  CHECK(BytesOf(folder / "without/overview.png") != BytesOf(folder / "seen/overview.png"));
}

TEST_CASE("a building of a kilometre makes a map.tif that can be opened, whose walls are seen") {
  const ScratchFolder folder;
  Results results;
  results.team = "far";
  results.grid = {2, 20001, 0, 0, 0.05, std::vector<std::uint8_t>(40002, kFreeByte)};
  results.grid.cells[20000] = results.grid.cells[20001] = kOccupiedByte;
  WriteResults(folder / "out", results);
  const Picture picture(folder / "out/map.tif");
  CHECK(std::max(picture.width, picture.height) <= 5000);
  CHECK(picture.counts.contains({0, 40, 120}));
  results.grid = {};
  WriteResults(folder / "out", results);  // of no map
  CHECK(Picture(folder / "out/map.tif").width > 0);
}

TEST_CASE("a path ends where it jumps, and does not grow where the robot stands") {
  RescuePath path;
  for (int i = 0; i < 1000; ++i) path.Add({0.00001 * i, 0.0, 0.0});
  for (int i = 0; i < 10; ++i) path.Add({1.0, 0.1 * i, 0.0});
  path.Add({9.0, 0.0, 0.0});
  REQUIRE(path.stretches().size() == 2);
  CHECK(path.stretches()[0].size() == 11);
}

}  // namespace crsm
