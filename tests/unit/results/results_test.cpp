#include "common/results/results.hpp"

#include <png.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "catch.hpp"
#include "common/logs/map_files.hpp"
#include "common/results/pictures.hpp"
#include "common/results/png.hpp"
#include "common/results/summary.hpp"
#include "scratch.hpp"

using namespace crsm;
namespace fs = std::filesystem;

namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kUnexplored{186, 199, 215};
constexpr Colour kPaper{247, 242, 230};  // below the map

struct Picture {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 0;
  std::vector<std::uint8_t> samples;  // row by row from the top

  Colour At(std::size_t column, std::size_t row) const {
    const std::size_t i = (row * width + column) * channels;
    return {samples.at(i), samples.at(i + channels / 2), samples.at(i + channels - 1)};
  }
};

Picture ReadPng(const fs::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, path.c_str()));
  REQUIRE((image.format == PNG_FORMAT_GRAY || image.format == PNG_FORMAT_RGB));
  Picture picture{image.width, image.height, PNG_IMAGE_SAMPLE_CHANNELS(image.format), {}};
  picture.samples.resize(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, picture.samples.data(), 0, nullptr));
  return picture;
}

// The colours of the overview. Thin lines are mixed with what is below.
bool IsGreen(const Colour& c) { return c[1] > c[0] + 50 && c[1] > c[2] + 50; }
bool IsRed(const Colour& c) { return c[0] > c[1] + 60 && c[0] > c[2] + 60; }
bool IsBlue(const Colour& c) { return c[2] > c[0] + 80; }
bool IsOrange(const Colour& c) { return c[0] > c[1] + 50 && c[1] > c[2] + 50; }
bool IsMagenta(const Colour& c) { return c[0] > c[1] + 50 && c[2] > c[1] + 50; }
bool IsTurquoise(const Colour& c) { return c[1] > c[0] + 40 && c[2] > c[0] + 40 && std::abs(c[1] - c[2]) < 30; }
bool IsBrown(const Colour& c) { return c[0] > c[1] + 20 && c[1] > c[2] + 5; }
bool IsViolet(const Colour& c) { return c[2] > c[0] + 40 && c[0] > c[1] + 20; }
bool IsDark(const Colour& c) { return c[0] < 60 && c[1] < 60 && c[2] < 60; }

/// Of white: 1. Source: WCAG 2.1, relative luminance.
double LuminanceOf(const Colour& colour) {
  const auto Linear = [](std::uint8_t byte) {
    const double share = byte / 255.0;
    return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * Linear(colour[0]) + 0.7152 * Linear(colour[1]) + 0.0722 * Linear(colour[2]);
}

double ContrastOf(const Colour& light, const Colour& dark) {
  return (LuminanceOf(light) + 0.05) / (LuminanceOf(dark) + 0.05);
}

Results MakeResults(int width, int height) {
  Results results;
  results.grid = {width, height, -2, 3, 0.05, {}};
  for (int i = 0; i < width * height; ++i) results.grid.cells.push_back(static_cast<std::uint8_t>(i * 37 % 256));
  return results;
}

ScanMatch MakeMatch(std::int64_t utime, Pose2 pose, double fitness, MatchState state) {
  return {utime, pose, fitness, 100, 60, 1, state};
}

/// Nothing but 100 x 100 unexplored cells of 0.1 m from (-5, -5) m on.
Results Unexplored() {
  Results results;
  results.grid = {100, 100, -50, -50, 0.1, std::vector<std::uint8_t>(10000, kUnexploredByte)};
  return results;
}

/// A picture that was made.
class Overview {
 public:
  explicit Overview(const Results& results) {
    WriteResults(folder_.path(), results);
    picture_ = ReadPng(folder_ / "overview.png");
  }
  const Picture& picture() const { return picture_; }

  // Of Unexplored(): 16 pixels a cell, so a metre is 160 pixels, behind margins of 76 pixels on the left and 24 above.
  static constexpr std::size_t kMapBottom = 1624;
  static constexpr std::size_t kCaptionTop = 1664;

  Colour At(double x_m, double y_m) const { return picture_.At(ColumnOf(x_m), RowOf(y_m)); }

  /// Whether such a colour is within a pixel of a place: a line of one pixel may lie between two.
  template <class IsColour>
  bool HasNear(double x_m, double y_m, IsColour&& is_colour) const {
    for (std::size_t row = RowOf(y_m) - 1; row <= RowOf(y_m) + 1; ++row) {
      for (std::size_t column = ColumnOf(x_m) - 1; column <= ColumnOf(x_m) + 1; ++column) {
        if (is_colour(picture_.At(column, row))) return true;
      }
    }
    return false;
  }

  /// Along how much of a way from (-2.5, y) to (2.5, y) there is such a colour.
  template <class IsColour>
  double ShareAlong(double y_m, IsColour&& is_colour) const {
    int num = 0;
    for (int i = 0; i < 500; ++i) num += HasNear(-2.5 + 0.01 * i, y_m, is_colour) ? 1 : 0;
    return num / 500.0;
  }

  /// Whether there is such a colour in the caption.
  template <class IsColour>
  bool CaptionHas(IsColour&& is_colour) const {
    for (std::size_t y = kCaptionTop; y < picture_.height; ++y) {
      for (std::size_t x = 0; x < picture_.width; ++x) {
        if (is_colour(picture_.At(x, y))) return true;
      }
    }
    return false;
  }

  /// Where the verdict stands, left of its letters.
  Colour Badge() const { return picture_.At(22, kCaptionTop + 32); }

  std::size_t caption_height() const { return picture_.height - kCaptionTop; }

 private:
  static std::size_t ColumnOf(double x_m) { return static_cast<std::size_t>(76 + (x_m + 5.0) * 160); }
  static std::size_t RowOf(double y_m) { return static_cast<std::size_t>(24 + (5.0 - y_m) * 160); }

  ScratchFolder folder_;
  Picture picture_;
};

/// As of a run that was judged.
Summary Judged(Trust trust, std::vector<std::string> warnings = {}) {
  Summary summary;
  Verdict& verdict = summary.verdict.emplace();
  verdict.trust = trust;
  verdict.values.counts.on_map = 3;
  verdict.warnings = std::move(warnings);
  return summary;
}

std::string ErrorOfWriting(const fs::path& dir, const Results& results) {
  return ErrorOf([&] { WriteResults(dir, results); });
}

std::map<std::string, std::string> FilesOf(const fs::path& dir) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(dir)) files[entry.path().filename()] = BytesOf(entry.path());
  return files;
}

}  // namespace

TEST_CASE("map.png and map.pgm hold each cell's byte, with the highest y on top") {
  const ScratchFolder folder;
  const Results results = MakeResults(7, 5);
  WriteResults(folder.path(), results);
  const Picture png = ReadPng(folder / "map.png");
  REQUIRE((png.width == 7 && png.height == 5 && png.channels == 1));
  const std::string pgm = BytesOf(folder / "map.pgm");
  const std::string header = "P5\n7 5\n255\n";
  REQUIRE(pgm.size() == header.size() + 35);
  CHECK(pgm.starts_with(header));
  for (std::size_t i = 0; i < 35; ++i) {
    const std::size_t from_top = (4 - i / 7) * 7 + i % 7;
    CHECK(png.samples[from_top] == results.grid.cells[i]);
    CHECK(static_cast<std::uint8_t>(pgm[header.size() + from_top]) == results.grid.cells[i]);
  }
}

TEST_CASE("a picture that cannot be a PNG file is an error, no crash") {
  const std::uint8_t one = 0;
  CHECK_THROWS_AS(EncodePng({0, 1, 1, &one}), std::invalid_argument);
  CHECK_THROWS_AS(EncodePng({1, -1, 1, &one}), std::invalid_argument);
}

TEST_CASE("a picture that is made again has the bytes that it has alone, whatever has changed, and its pixels") {
  const ScratchFolder folder;
  for (const int channels : {1, 3}) {
    PngEncoder encoder;
    std::vector<std::uint8_t> bytes;
    const auto Check = [&](int width, int height) {
      CAPTURE(channels, width, height);
      bytes.resize(static_cast<std::size_t>(width * height * channels), 9);
      const Pixels pixels{width, height, channels, bytes.data()};
      const std::string png = encoder.Encode(pixels);
      CHECK((png == EncodePng(pixels)));
      std::ofstream(folder / "picture.png", std::ios::binary) << png;
      const Picture picture = ReadPng(folder / "picture.png");
      REQUIRE((picture.width == static_cast<std::size_t>(width) && picture.height == static_cast<std::size_t>(height) &&
               picture.channels == static_cast<std::size_t>(channels)));
      CHECK((picture.samples == bytes));
    };
    for (int i = 0; i < 300 * 150 * channels; ++i) bytes.push_back(static_cast<std::uint8_t>(i / 3 * 37 % 251));
    Check(300, 150);
    bytes[static_cast<std::size_t>(300 * 70 * channels + 5)] ^= 0x55;  // of the second strip of rows alone
    Check(300, 150);
    Check(300, 200);
    Check(300, 64);
    Check(200, 64);
    Check(1, 1);
  }
}

TEST_CASE("the folder is made, holds the six files and no others, and a second run gives the same bytes") {
  const ScratchFolder folder;
  const fs::path dir = folder / "a" / "b";
  Results results = MakeResults(7, 5);
  results.matches = {MakeMatch(5000000, {0.25, 0.5, 0.0}, 0.9, MatchState::kFirst)};
  WriteResults(dir, results);
  auto files = FilesOf(dir);
  WriteResults(dir, results);
  CHECK(FilesOf(dir) == files);
  CHECK(files.size() == 6);
  CHECK(files["trajectory.tum"] == "5.000000 0.250000000 0.500000000 0 0 0 0.000000000 1.000000000\n");
  CHECK(files["summary.json"] == "{}\n");
  // The lower left corner in metres, and map_server's thresholds.
  CHECK(files["map.yaml"] ==
        "image: map.png\nresolution: 0.05\norigin: [-0.100000, 0.150000, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.504\nfree_thresh: 0.5\n");
}

TEST_CASE("map_server reads every byte of a map as this project does") {
  const std::string yaml = FormatMapYaml(MakeUnexploredCell(0.05));
  const auto ReadNumber = [&](const std::string& key) { return std::stod(yaml.substr(yaml.find(key) + key.size())); };
  const double occupied_thresh = ReadNumber("occupied_thresh: ");
  const double free_thresh = ReadNumber("free_thresh: ");
  for (int byte = 0; byte < 256; ++byte) {
    CAPTURE(byte);
    const double occupied = (255 - byte) / 255.0;  // image_loader.cpp of map_server, and map_io.cpp of nav2_map_server
    CHECK((occupied > occupied_thresh) == IsOccupied(static_cast<std::uint8_t>(byte)));
    CHECK((occupied < free_thresh) == IsFree(static_cast<std::uint8_t>(byte)));
    CHECK((static_cast<float>(occupied) > occupied_thresh) == IsOccupied(static_cast<std::uint8_t>(byte)));
    CHECK((static_cast<float>(occupied) < free_thresh) == IsFree(static_cast<std::uint8_t>(byte)));
  }
}

TEST_CASE("a reader that has a file open keeps the whole old one") {
  const ScratchFolder folder;
  Results results = MakeResults(4, 4);
  WriteResults(folder.path(), results);
  std::ifstream reader(folder / "summary.json");
  results.summary.emplace().values.counts.on_map = 1;
  WriteResults(folder.path(), results);
  std::string text;
  std::getline(reader, text);
  CHECK(text == "{}");
  CHECK(BytesOf(folder / "summary.json") == FormatSummary(*results.summary));
}

TEST_CASE("an empty map is written as one unexplored cell") {
  const ScratchFolder folder;
  for (const auto& [cell_size_m, resolution] : {std::pair(0.0, "resolution: 1\n"), {0.05, "resolution: 0.05\n"}}) {
    Results results;
    results.grid.cell_size_m = cell_size_m;
    WriteResults(folder.path(), results);
    CHECK(ReadPng(folder / "map.png").samples == std::vector{kUnexploredByte});
    CHECK(BytesOf(folder / "map.yaml").find(resolution) != std::string::npos);
    CHECK(BytesOf(folder / "trajectory.tum").empty());
    CHECK(ReadPng(folder / "overview.png").channels == 3);
  }
}

TEST_CASE("the overview shows start, path, end, lost scans and hits where they are") {
  Results results = Unexplored();
  results.matches = {MakeMatch(1, {-3.0, 0.0, 0.0}, 0.0, MatchState::kFirst),
                     MakeMatch(2, {2.0, 4.0, 0.0}, 0.1, MatchState::kLost),
                     MakeMatch(3, {3.0, 0.0, kPi / 2}, 0.9, MatchState::kOk)};
  results.last_scan = {3, {{0.0f}, {2.0f}}, {}};  // looks up from (3, 0): a hit 2 m ahead
  const Overview overview(results);
  REQUIRE(overview.picture().width == 1700);
  REQUIRE(overview.picture().height > Overview::kCaptionTop);
  CHECK(IsGreen(overview.At(-3.0, 0.0)));
  CHECK(overview.HasNear(-1.0, 0.0, IsBlue));
  CHECK(IsOrange(overview.At(3.0, 0.0)));
  CHECK(IsRed(overview.At(2.0, 4.0)));
  CHECK(IsTurquoise(overview.At(3.0, 2.0)));
  CHECK(overview.At(-2.0, 3.0) == kUnexplored);
  CHECK(overview.At(3.0, 3.0) == kUnexplored);
  CHECK(overview.At(-1.0, 0.02) == kUnexplored);  // the path is thin
}

TEST_CASE("no path, loop, lost scan or hit hides a wall, at any size of the map") {
  for (const int width_cells : {100, 2000, 9000}) {  // enlarged, as it is, shrunk
    CAPTURE(width_cells);
    const int wall_row = 50;
    Results results;
    results.grid = {width_cells, 100, 0, 0, 0.1, {}};
    results.grid.cells.assign(static_cast<std::size_t>(width_cells) * 100, kFreeByte);
    std::fill_n(results.grid.cells.begin() + wall_row * width_cells, width_cells, kOccupiedByte);
    // All of it lies on the wall.
    const double wall_m = 0.1 * (wall_row + 0.5);
    const Pose2 from{0.0, wall_m, 0.0};
    const Pose2 to{0.1 * width_cells, wall_m, kPi};
    results.matches = {MakeMatch(1, from, 0.0, MatchState::kFirst),
                       MakeMatch(2, {0.05 * width_cells, wall_m, 0.0}, 0.1, MatchState::kLost),
                       MakeMatch(3, to, 0.9, MatchState::kOk)};
    results.last_scan = {3, {{0.0f, 0.0f}, {3.0f, 5.0f}}, {}};
    for (const auto& [rejected, joins] : {std::pair(false, false), {true, false}, {false, true}}) {
      results.loops.push_back({from, to, rejected, joins});
    }
    const Picture picture = Overview(results).picture();
    std::size_t most_dark = 0;
    for (std::size_t y = 0; y < picture.height; ++y) {
      std::size_t dark = 0;
      for (std::size_t x = 0; x < picture.width; ++x) dark += IsDark(picture.At(x, y)) ? 1 : 0;
      most_dark = std::max(most_dark, dark);
    }
    const int map_pixels = width_cells == 100 ? 1600 : std::min(width_cells, 4000);
    CHECK(std::cmp_greater_equal(most_dark, map_pixels));
  }
}

TEST_CASE("the overview joins both ends of each loop: closed ones by a line, rejected ones by dashes") {
  Results results = Unexplored();
  CHECK_FALSE(Overview(results).CaptionHas(IsMagenta));
  results.loops = {{{-3.0, 1.0, 0.0}, {3.0, 1.0, 0.0}, false}};
  CHECK(Overview(results).CaptionHas(IsMagenta));
  CHECK_FALSE(Overview(results).CaptionHas(IsBrown));
  results.loops.push_back({{-3.0, -1.0, 0.0}, {3.0, -1.0, 0.0}, true});
  results.loops.push_back({{4.0, -4.0, 0.0}, {4.0, -4.0, 0.0}, false});
  const Overview overview(results);
  CHECK(overview.ShareAlong(1.0, IsMagenta) == 1.0);
  CHECK(overview.ShareAlong(-1.0, IsBrown) == Approx(0.5).margin(0.25));  // round ends are longer than half
  for (const double x_m : {-3.0, 3.0}) {
    CHECK(IsMagenta(overview.At(x_m, 1.0)));
    CHECK(IsBrown(overview.At(x_m, -1.0)));
  }
  CHECK(IsMagenta(overview.At(4.0, -4.0)));  // one whose ends are one place
  CHECK(overview.At(-1.0, 0.0) == kUnexplored);
  CHECK(overview.CaptionHas(IsMagenta));
  CHECK(overview.CaptionHas(IsBrown));
}

TEST_CASE("thousands of loops leave the map to be seen") {
  Results results = Unexplored();
  for (int i = 0; i < 5000; ++i) {
    results.loops.push_back({{-3.0, -4.0 + 0.0016 * i, 0.0}, {3.0, -4.0 + 0.0016 * i, 0.0}, false});
  }
  std::fill(results.grid.cells.begin(), results.grid.cells.begin() + 5000, kFreeByte);  // the lower half
  const Overview overview(results);
  const Colour free = overview.At(1.0, -2.0);
  const Colour unexplored = overview.At(1.0, 2.0);
  CHECK((unexplored[0] > unexplored[1] + 20 && unexplored[2] > unexplored[1] + 20));  // pale, and magenta
  CHECK(free[0] > 150);                                                               // of 255
  CHECK(ContrastOf(free, unexplored) > 1.3);
}

TEST_CASE("the overview shows where the path breaks and where it is joined, and no scan of another piece") {
  Results results = Unexplored();
  results.loops = {{{-3.0, 1.0, 0.0}, {3.0, 1.0, 0.0}, false, true}};
  std::vector<ScanMatch> matches{MakeMatch(1, {-4.0, -4.0, 0.0}, 0.9, MatchState::kFirst),
                                 MakeMatch(2, {-3.0, -4.0, 0.0}, 0.9, MatchState::kOk),
                                 MakeMatch(3, {2.0, 3.0, 0.0}, 0.9, MatchState::kLost)};
  results.matches = matches;
  const Overview whole(results);
  CHECK(whole.At(2.0, 3.0) != kUnexplored);
  matches.back().floating = true;
  results.matches = matches;
  results.pieces.num_pieces = 2;
  results.pieces.num_breaks = 1;
  results.pieces.breaks = {{3, 2, BreakReason::kGap, 9.0, {0.0, -2.0, 0.0}, 1, 2}};
  const Overview overview(results);
  CHECK(overview.ShareAlong(1.0, IsViolet) == 1.0);
  CHECK(IsRed(overview.At(0.0, -2.0)));
  CHECK(overview.At(0.04, -2.0) == kUnexplored);  // a cross
  CHECK(overview.At(2.0, 3.0) == kUnexplored);
  CHECK(overview.caption_height() > whole.caption_height());  // it says so
  // Beside the cross stands which piece goes on there, unless that is this one.
  const auto HasLabel = [](const Overview& picture) {
    for (double x_m = 0.15; x_m < 0.4; x_m += 0.01) {
      if (picture.HasNear(x_m, -1.92, IsRed)) return true;
    }
    return false;
  };
  CHECK(HasLabel(overview));
  results.pieces.num_pieces = 1;
  results.pieces.breaks.front().piece = 1;
  CHECK_FALSE(HasLabel(Overview(results)));
}

TEST_CASE("the overview draws no path over a break: how the robot came there is not known") {
  Results results = Unexplored();
  std::vector<ScanMatch> matches{MakeMatch(1, {-3.0, 3.0, 0.0}, 0.9, MatchState::kFirst),
                                 MakeMatch(2, {3.0, 3.0, 0.0}, 0.9, MatchState::kOk)};
  results.matches = matches;
  CHECK(Overview(results).HasNear(0.0, 3.0, IsBlue));
  matches.back().state = MatchState::kFirst;
  results.matches = matches;
  CHECK_FALSE(Overview(results).HasNear(0.0, 3.0, IsBlue));
}

TEST_CASE("the overview tells free, unexplored, walls and the caption apart, around the map too") {
  Results results = Unexplored();
  results.grid.cells[results.grid.IndexOf(20, 20)] = kFreeByte;
  results.grid.cells[results.grid.IndexOf(30, 20)] = kOccupiedByte;
  const Overview overview(results);
  const Colour free = overview.At(-2.95, -2.95);
  const Colour unexplored = overview.At(-1.0, 1.0);
  CHECK(free == Colour{255, 255, 255});
  CHECK(unexplored == kUnexplored);
  CHECK(ContrastOf(free, unexplored) >= 1.6);
  CHECK(ContrastOf(unexplored, overview.At(-1.95, -2.95)) >= 7.0);
  const Picture& picture = overview.picture();
  CHECK(picture.At(2, 2) == kUnexplored);
  CHECK(picture.At(picture.width - 2, Overview::kMapBottom + 2) == kUnexplored);
  CHECK(picture.At(picture.width - 2, picture.height - 2) == kPaper);
  const Picture narrow = Overview(MakeResults(2, 3)).picture();
  CHECK(narrow.At(100, 100) == kUnexplored);
  CHECK(narrow.At(narrow.width - 100, 100) == kUnexplored);
}

TEST_CASE("the overview says the verdict where there is one, and else that there is none") {
  Results results = Unexplored();
  const Overview of_no_run(results);
  results.summary.emplace();
  const Overview unjudged(results);
  for (const Overview* overview : {&of_no_run, &unjudged}) {
    CHECK_FALSE((IsGreen(overview->Badge()) || IsRed(overview->Badge()) || IsOrange(overview->Badge())));
  }
  results.summary = Judged(Trust::kGood);
  const Overview good(results);
  CHECK(IsGreen(good.Badge()));
  results.summary = Judged(Trust::kDoubtful);
  CHECK(IsOrange(Overview(results).Badge()));
  results.summary = Judged(Trust::kBad);
  const Overview bad(results);
  CHECK(IsRed(bad.Badge()));
  results.summary = Judged(Trust::kBad, {"one room is drawn over another"});
  const Overview warned(results);
  CHECK(warned.caption_height() > bad.caption_height());
  results.summary = Judged(Trust::kBad, {"one room is drawn over another one"});
  CHECK((Overview(results).picture().samples != warned.picture().samples));
  std::string words;
  for (int i = 0; i < 100; ++i) words += "words ";
  results.summary = Judged(Trust::kBad, {words});
  CHECK(Overview(results).caption_height() > warned.caption_height());  // on several lines

  results.summary = Judged(Trust::kGood);
  results.summary->ended = false;
  const Overview so_far(results);
  CHECK(IsGreen(so_far.Badge()));
  CHECK((so_far.picture().samples != good.picture().samples));
  results.name = "killian";
  const Overview named(results);
  CHECK((named.picture().samples != so_far.picture().samples));
  results.summary->origin.made_from = "killian.clf.gz --preset sick";
  const Overview with_log(results);
  CHECK(with_log.caption_height() > named.caption_height());
  results.summary->origin.mapped = "2026-11-28T03:00:00Z";  // two runs of one log give the same picture
  CHECK((Overview(results).picture().samples == with_log.picture().samples));
  results.summary->values.first_utime = 1'059'646'830'000'000;
  CHECK((Overview(results).picture().samples != with_log.picture().samples));
}

TEST_CASE("the overview marks past which place the map may be off, and not over walls") {
  Results results = Unexplored();
  results.grid.cells.assign(10000, kOccupiedByte);
  std::fill(results.grid.cells.begin(), results.grid.cells.begin() + 5000, kFreeByte);  // the lower half
  results.summary = Judged(Trust::kDoubtful);
  results.summary->verdict->off_m = 2.0;
  const auto IsRing = [](const Colour& colour) {
    return std::abs(colour[0] - 148) < 12 && std::abs(colour[1] - 88) < 12;
  };
  CHECK_FALSE(Overview(results).CaptionHas(IsRing));
  results.summary->verdict->off_at = {1.0, 0.0};
  const Overview overview(results);
  CHECK(overview.CaptionHas(IsRing));
  CHECK(overview.HasNear(1.0, -22.0 / 160, IsRing));
  CHECK(IsDark(overview.At(1.0, 22.0 / 160)));
}

TEST_CASE("the overview colours the floor by how far off it may be, and draws the drive that would tell most") {
  Results results = Unexplored();
  std::fill(results.grid.cells.begin(), results.grid.cells.begin() + 5000, kFreeByte);  // the lower half
  results.summary = Judged(Trust::kDoubtful);
  Verdict& verdict = *results.summary->verdict;
  verdict.off_m = 2.0;
  verdict.off_at = {40.0, 40.0};  // beside the picture
  const double x_m = results.grid.origin_x_cells * 0.05;
  const double y_m = results.grid.origin_y_cells * 0.05 + 1.0;
  verdict.doubts = {{{x_m + 0.5, y_m}, 0.0}, {{x_m + 4.5, y_m}, 2.0}, {{1e6, 0.0}, 9.0}};
  const Overview overview(results);
  const auto Blue = [&](double at_x_m, double at_y_m) { return static_cast<int>(overview.At(at_x_m, at_y_m)[2]); };
  CHECK(Blue(x_m + 0.7, y_m) == 255);
  CHECK(Blue(x_m + 4.3, y_m) < 130);
  CHECK(Blue(x_m + 4.3, y_m + 2.0) == 215);
  verdict.way_back = WayBack{{x_m + 0.5, y_m}, {x_m + 4.5, y_m}, 0.25};
  const auto IsLine = [](const Colour& colour) { return std::abs(colour[0] - 148) < 12 && colour[2] < 12; };
  CHECK_FALSE(overview.HasNear(x_m + 0.5, y_m, IsLine));
  CHECK(Overview(results).HasNear(x_m + 0.5, y_m, IsLine));
}

TEST_CASE("the scale bar is as long as it says") {
  // 160 pixels a metre: 100 pixels are less than a metre, and more than half a one.
  const Picture picture = Overview(Unexplored()).picture();
  int longest = 0;
  for (std::size_t y = Overview::kCaptionTop; y < picture.height; ++y) {
    int length = 0;
    for (std::size_t x = 0; x < picture.width; ++x) {
      length = IsDark(picture.At(x, y)) ? length + 1 : 0;
      longest = std::max(longest, length);
    }
  }
  CHECK(longest == Approx(160).margin(3));  // and the ticks at its ends
}

TEST_CASE("an overview that is made again has the bytes of one that is made at once") {
  Results results = Unexplored();
  PngEncoder encoder;
  std::vector<ScanMatch> matches;
  for (int i = 0; i < 3; ++i) {
    matches.push_back(MakeMatch(i, {-3.0 + i, 0.5 * i, 0.0}, 0.9, MatchState::kOk));
    results.matches = matches;
    results.summary = Judged(i == 1 ? Trust::kDoubtful : Trust::kGood);
    CHECK((EncodeOverview(results, encoder) == EncodeOverview(results)));
  }
}

TEST_CASE("a run is named as the folder of its results") {
  CHECK(NameOfRun("out/demo") == "demo");
  CHECK(NameOfRun("out/demo/") == "demo");
  CHECK(NameOfRun("out/./demo/../twins") == "twins");
  CHECK(NameOfRun(".") == fs::current_path().filename().string());
  CHECK(NameOfRun("/").empty());
}

TEST_CASE("pieces have maps of their own, and none of an earlier writing stays, but for what is the user's") {
  const ScratchFolder folder;
  const fs::path pieces = folder / "pieces";
  const Results piece = MakeResults(7, 5);
  const MatchSequence matches{MakeMatch(5, {1.0, 2.0, 0.0}, 0.9, MatchState::kOk)};
  for (const int number : {2, 3}) WritePiece(folder.path(), number, piece.grid, matches);
  WriteResults(folder.path(), piece);
  for (const char* file : {"map.png", "map.pgm", "map.yaml"}) {
    CHECK(BytesOf(pieces / "3" / file) == BytesOf(folder / file));
  }
  CHECK(BytesOf(pieces / "2/trajectory.tum").find("1.000000000 2.000000000") != std::string::npos);
  WritePiece(folder.path(), 4, {}, {});  // nothing was seen
  CHECK(ReadPng(pieces / "4/map.png").width == 1);
  RemovePieces(folder.path());
  CHECK_FALSE(fs::exists(pieces));
  RemovePieces(folder.path());  // there are none

  WritePiece(folder.path(), 2, piece.grid, matches);
  fs::create_directories(pieces / "mine");
  folder.Write("pieces/2/notes.txt", "of the user");
  RemovePieces(folder.path());
  CHECK(fs::exists(pieces / "mine"));
  CHECK(fs::exists(pieces / "2/notes.txt"));
  CHECK_FALSE(fs::exists(pieces / "2/map.png"));
}

TEST_CASE("the overview shows the last scan's hits on walls too, beside the wall's cell") {
  Results results = Unexplored();
  results.grid.cells[results.grid.IndexOf(60, 50)] = kOccupiedByte;  // around (1.05, 0.05)
  results.last_scan = {1, {{0.0f}, {1.0f}}, {}};
  results.matches = {MakeMatch(1, {0.05, 0.05, 0.0}, 0.9, MatchState::kOk)};
  const Overview overview(results);
  CHECK(IsDark(overview.At(1.05, 0.05)));
  CHECK(IsTurquoise(overview.At(1.05, 0.11)));
}

TEST_CASE("the overview shows the last scan deskewed by its match") {
  // The laser drives ahead at 2 m/s; 0.5 s before the scan's time it was 1 m further back and saw a wall 2 m ahead.
  Results results = Unexplored();
  results.last_scan = {1, {{0.0f}, {2.0f}, {-0.5f}}, {}};
  ScanMatch match = MakeMatch(1, {}, 0.9, MatchState::kOk);
  match.twist.x_m_s = 2.0;
  results.matches = {match};
  CHECK(IsTurquoise(Overview(results).At(1.0, 0.0)));
  CHECK_FALSE(IsTurquoise(Overview(results).At(2.0, 0.0)));
}

TEST_CASE("the map is enlarged to about 1600 pixels and shrunk only above 4000") {
  // 1000 is the least width. Margins take 100 pixels for 1600 of the map.
  for (const auto& [width_cells, pixels] :
       {std::pair(2, 1000), {700, 1500}, {1600, 1700}, {3999, 4249}, {9000, 4250}}) {
    CHECK(Overview(MakeResults(width_cells, 3)).picture().width == static_cast<std::size_t>(pixels));
  }
}

TEST_CASE("words below a large picture are as large in it as below a small one") {
  // The height of the verdict's badge over the picture's width.
  const auto BadgeShare = [](int width_cells) {
    Results results = MakeResults(width_cells, 3);
    results.summary = Judged(Trust::kGood);
    const Picture picture = Overview(results).picture();
    const std::size_t column = 22 * picture.width / 1700;
    std::size_t num = 0;
    for (std::size_t y = 0; y < picture.height; ++y) num += IsGreen(picture.At(column, y)) ? 1 : 0;
    return static_cast<double>(num) / static_cast<double>(picture.width);
  };
  const double small = BadgeShare(1600);
  CHECK(small > 0.015);  // 26 pixels
  CHECK(BadgeShare(3999) == Approx(small).epsilon(0.05));
  CHECK(BadgeShare(9000) == Approx(small).epsilon(0.05));
}

TEST_CASE("poses far outside the map are drawn nowhere and harm nothing") {
  Results results = MakeResults(50, 50);
  std::vector<ScanMatch> matches;
  for (const double far_m : {1e300, -1e300, 1e9}) {
    matches.push_back(MakeMatch(1, {far_m, far_m, 1.0}, 0.5, MatchState::kOk));
    matches.push_back(MakeMatch(2, {far_m, -far_m, 1.0}, 0.5, MatchState::kLost));
  }
  results.matches = matches;
  results.last_scan = {2, {std::vector<float>(360, 0.01f), std::vector<float>(360, 5.0f)}, {}};
  CHECK_NOTHROW(Overview(results));
}

TEST_CASE("a grid that is not the size of its cells and a pose that is not finite are refused") {
  const ScratchFolder folder;
  const auto Refuses = [&](auto&& spoil) {
    Results results = MakeResults(7, 5);
    spoil(results);
    CHECK_THROWS_AS(WriteResults(folder.path(), results), std::invalid_argument);
  };
  Refuses([](Results& results) { results.grid.width_cells = 8; });
  Refuses([](Results& results) { results.grid.width_cells = -7, results.grid.height_cells = -5; });
  Refuses([](Results& results) { results.grid.cell_size_m = 0.0; });
  Refuses([](Results& results) { results.matches = {MakeMatch(1, {std::nan(""), 0.0, 0.0}, 0.5, MatchState::kOk)}; });
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("what cannot be written is named with the reason, and leaves no temporary file") {
  const ScratchFolder folder;
  const Results results = MakeResults(4, 4);
  folder.Write("file", "x");
  const fs::path below_file = folder / "file/out";
  CHECK(ErrorOfWriting(below_file, results) == "cannot make the folder " + below_file.string() + ": Not a directory");
  CHECK(ErrorOfWriting("/proc/self", results).starts_with("cannot write /proc/self/map.png: "));
  const fs::path dir = folder / "dir";
  fs::create_directories(dir / "map.png");
  CHECK(ErrorOfWriting(dir, results) == "cannot write " + (dir / "map.png").string() + ": Is a directory");
  CHECK(std::distance(fs::directory_iterator(dir), {}) == 1);
}

TEST_CASE("a disk that fills up at the last file leaves all the old ones") {
  const ScratchFolder folder;
  WriteResults(folder.path(), MakeResults(4, 4));
  const auto old_files = FilesOf(folder.path());

  // A limit on the size of files stands in for the full disk.
  rlimit unlimited{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &unlimited) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limited{100000, unlimited.rlim_max};
  REQUIRE(setrlimit(RLIMIT_FSIZE, &limited) == 0);
  Results results = MakeResults(5, 7);
  results.summary.emplace().version = std::string(200000, 'x');
  const std::string error = ErrorOfWriting(folder.path(), results);
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, old_handler);

  CHECK(error == "cannot write " + (folder / "summary.json").string() + ": File too large");
  CHECK(FilesOf(folder.path()) == old_files);
}

TEST_CASE("trajectory.tum has the poses of the piece that is shown, and none of another frame") {
  const ScratchFolder folder;
  Results results = MakeResults(4, 4);
  std::vector<ScanMatch> matches;
  for (int i = 0; i < 4; ++i) matches.push_back(MakeMatch(1000000 * i, {0.5 * i, 0.0, 0.0}, 0.9, MatchState::kOk));
  matches[1].floating = true;
  matches[2].floating = true;
  matches[2].state = MatchState::kLost;
  results.matches = matches;
  WriteResults(folder.path(), results);
  WritePiece(folder.path(), 2, results.grid, {matches[1], matches[2]});
  const auto TimesIn = [&](const std::string& file) {
    std::vector<std::int64_t> utimes;
    for (const StampedPose& pose : ReadTrajectory((folder / file).string())) utimes.push_back(pose.utime);
    return utimes;
  };
  CHECK(TimesIn("trajectory.tum") == std::vector<std::int64_t>{0, 3000000});
  CHECK(TimesIn("pieces/2/trajectory.tum") == std::vector<std::int64_t>{1000000, 2000000});
}

TEST_CASE("the explored area is that of the cells that are not unexplored") {
  CHECK(ComputeExploredArea({3, 2, 0, 0, 0.5, {127, 0, 255, 128, 126, 127}}) == Approx(1.0));  // four of 0.25 m2
  CHECK(ComputeExploredArea({}) == 0.0);
}

TEST_CASE("a summary becomes JSON with everything in it, parameters in their order") {
  Summary summary;
  summary.version = "1.2.3";
  summary.values.counts = {4, 3, 2, 1};
  summary.left_out = 5;
  summary.map_version = 9;
  summary.values.path_m = 2.5;
  summary.values.mean_fitness = std::numeric_limits<double>::quiet_NaN();
  summary.parameters["one"] = {{"z_first", 40},
                               {"a_second", true},
                               {"size_m", 0.05},
                               {"seed", ~std::uint64_t{0}},
                               {"log", "not \xff UTF-8 \"quoted\""}};
  summary.parameters["other"] = {{"z_first", 41}};
  summary.counts = {{"dropped", 3}};
  summary.timings = {{"match", {1.5, 2.0, 2.5, 3.5}}};
  const std::string text = FormatSummary(summary);
  CHECK(text.back() == '\n');
  CHECK(text.find("z_first") < text.find("a_second"));
  const auto json = nlohmann::json::parse(text);
  CHECK(json["version"] == "1.2.3");
  const std::map<std::string, int> numbers{{"scans", 10},   {"on_map", 4},       {"floating", 3},   {"lost", 2},
                                           {"left_out", 5}, {"without_rays", 1}, {"map_version", 9}};
  for (const auto& [key, number] : numbers) CHECK(json[key] == number);
  CHECK(json["path_length_m"] == 2.5);
  CHECK(json["mean_fitness"].is_null());
  CHECK(json["verdict"].is_null());  // nothing has judged it
  CHECK(json["parameters"] == nlohmann::json{{"one",
                                              {{"z_first", 40},
                                               {"a_second", true},
                                               {"size_m", 0.05},
                                               {"seed", ~std::uint64_t{0}},
                                               {"log", "not \xEF\xBF\xBD UTF-8 \"quoted\""}}},
                                             {"other", {{"z_first", 41}}}});
  CHECK(json["counts"]["dropped"] == 3);
  CHECK(json["timings"]["match"] == nlohmann::json{{"p50_ms", 1.5}, {"p95_ms", 2.0}, {"p99_ms", 2.5}, {"max_ms", 3.5}});
  CHECK(nlohmann::json::parse(FormatSummary({}))["counts"] == nlohmann::json::object());
}
