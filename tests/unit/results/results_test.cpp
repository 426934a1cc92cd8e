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
#include "common/results/png.hpp"
#include "common/results/summary.hpp"
#include "scratch.hpp"

using namespace crsm;
namespace fs = std::filesystem;

namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kUnexplored{127, 127, 127};

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

// The colours of the overview.
bool IsGreen(const Colour& c) { return c[1] > c[0] && c[1] > c[2]; }
bool IsRed(const Colour& c) { return c[0] > c[1] && c[0] > c[2]; }
bool IsBlue(const Colour& c) { return c[2] > c[0]; }
bool IsOrange(const Colour& c) { return c[0] > c[1] && c[1] > c[2]; }
bool IsMagenta(const Colour& c) { return c[0] > c[1] && c[2] > c[1]; }
bool IsTurquoise(const Colour& c) { return c[1] > 2 * c[0] && c[2] > 2 * c[0]; }
bool IsBrown(const Colour& c) { return c[0] > c[1] + 30 && c[1] > c[2] + 30; }
bool IsViolet(const Colour& c) { return c[2] > c[0] + 50 && c[0] > c[1] + 30; }
bool IsCrimson(const Colour& c) { return c[0] > c[2] + 50 && c[2] > c[1] + 50; }

Results MakeResults(int width, int height) {
  Results results;
  results.grid = {width, height, -2, 3, 0.05, {}};
  for (int i = 0; i < width * height; ++i) results.grid.cells.push_back(static_cast<std::uint8_t>(i * 37 % 256));
  results.summary_json = "{}\n";
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

/// The overview of that: 16 pixels a cell, so a metre is 160 pixels.
class Overview {
 public:
  explicit Overview(const Results& results) {
    WriteResults(folder_.path(), results);
    picture_ = ReadPng(folder_ / "overview.png");
  }
  const Picture& picture() const { return picture_; }
  Colour At(double x_m, double y_m) const {
    return picture_.At(static_cast<std::size_t>((x_m + 5.0) * 160), static_cast<std::size_t>((5.0 - y_m) * 160));
  }
  /// Whether the strip below the map, which explains the colours, has one. Letters are thin: their colours are mixed
  /// with its white.
  template <class IsColour>
  bool StripHas(IsColour&& is_colour) const {
    for (std::size_t y = picture_.height - 44; y < picture_.height; ++y) {
      for (std::size_t x = 0; x < picture_.width; ++x) {
        const auto [red, green, blue] = picture_.At(x, y);
        if (is_colour(red, green, blue)) return true;
      }
    }
    return false;
  }

 private:
  ScratchFolder folder_;
  Picture picture_;
};

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
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST_CASE("a reader that has a file open keeps the whole old one") {
  const ScratchFolder folder;
  Results results = MakeResults(4, 4);
  WriteResults(folder.path(), results);
  std::ifstream reader(folder / "summary.json");
  results.summary_json = "{\"scans\": 1}\n";
  WriteResults(folder.path(), results);
  std::string text;
  std::getline(reader, text);
  CHECK(text == "{}");
  CHECK(BytesOf(folder / "summary.json") == results.summary_json);
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
  REQUIRE(overview.picture().width == 1600);
  REQUIRE(overview.picture().height > 1600);
  CHECK(IsGreen(overview.At(-3.0, 0.0)));
  CHECK(IsBlue(overview.At(0.0, 0.0)));
  CHECK(IsRed(overview.At(3.0, 0.0)));
  CHECK(IsOrange(overview.At(2.0, 4.0)));
  CHECK(IsMagenta(overview.At(3.0, 2.0)));
  CHECK(overview.At(-2.0, 3.0) == kUnexplored);
  CHECK(overview.At(3.0, 3.0) == kUnexplored);
}

TEST_CASE("the overview shows loops that hold and loops that were rejected in colours that its strip explains") {
  const auto IsTurquoiseLetter = [](int red, int green, int blue) {
    return green > red + 60 && std::abs(green - blue) < 20;
  };
  const auto IsBrownLetter = [](int red, int green, int blue) {
    return red < 200 && red > green + 25 && green > blue + 25;
  };
  Results results = Unexplored();
  CHECK_FALSE(Overview(results).StripHas(IsTurquoiseLetter));
  results.loops = {{{-3.0, 1.0, 0.0}, {3.0, 1.0, 0.0}, false}};
  CHECK(Overview(results).StripHas(IsTurquoiseLetter));
  CHECK_FALSE(Overview(results).StripHas(IsBrownLetter));
  results.loops.push_back({{-3.0, -1.0, 0.0}, {3.0, -1.0, 0.0}, true});
  const Overview overview(results);
  CHECK(IsTurquoise(overview.At(0.0, 1.0)));
  CHECK(IsBrown(overview.At(0.0, -1.0)));
  CHECK(overview.At(0.0, 0.0) == kUnexplored);
  CHECK(overview.StripHas(IsTurquoiseLetter));
  CHECK(overview.StripHas(IsBrownLetter));
  results.grid = {2, 100, -1, -50, 0.1, std::vector<std::uint8_t>(200, kUnexploredByte)};
  CHECK(Overview(results).StripHas(IsBrownLetter));  // the last words have room in a narrow picture too
}

TEST_CASE("the overview shows where the path breaks and where it is joined, and no scan of another piece") {
  Results results = Unexplored();
  results.loops = {{{-3.0, 1.0, 0.0}, {3.0, 1.0, 0.0}, false, true}};
  std::vector<ScanMatch> matches{MakeMatch(1, {-4.0, -4.0, 0.0}, 0.9, MatchState::kFirst),
                                 MakeMatch(2, {-3.0, -4.0, 0.0}, 0.9, MatchState::kOk),
                                 MakeMatch(3, {2.0, 3.0, 0.0}, 0.9, MatchState::kLost)};
  results.matches = matches;
  CHECK(Overview(results).At(2.0, 3.0) != kUnexplored);
  matches.back().floating = true;  // as one of another piece comes
  results.matches = matches;
  results.pieces.num_pieces = 2;
  results.pieces.num_breaks = 1;
  results.pieces.breaks = {{3, 2, BreakReason::kGap, 9.0, {0.0, -2.0, 0.0}, 1, 2}};
  const Overview overview(results);
  CHECK(IsViolet(overview.At(0.0, 1.0)));
  CHECK(IsCrimson(overview.At(0.0, -2.0)));
  CHECK(overview.At(0.04, -2.0) == kUnexplored);  // a cross
  CHECK(overview.At(2.0, 3.0) == kUnexplored);
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

TEST_CASE("the overview shows the last scan deskewed by its match") {
  // The laser drives ahead at 2 m/s; 0.5 s before the scan's time it was 1 m further back and saw a wall 2 m ahead.
  Results results = Unexplored();
  results.last_scan = {1, {{0.0f}, {2.0f}, {-0.5f}}, {}};
  ScanMatch match = MakeMatch(1, {}, 0.9, MatchState::kOk);
  match.twist.x_m_s = 2.0;
  results.matches = {match};
  CHECK(IsMagenta(Overview(results).At(1.0, 0.0)));
  CHECK_FALSE(IsMagenta(Overview(results).At(2.0, 0.0)));
}

TEST_CASE("the overview is enlarged to about 1600 pixels and shrunk only above 4000") {
  // 640 is the strip's least width.
  for (const auto& [width_cells, pixels] : {std::pair(2, 640), {700, 1400}, {1600, 1600}, {3999, 3999}, {9000, 4000}}) {
    CHECK(Overview(MakeResults(width_cells, 3)).picture().width == static_cast<std::size_t>(pixels));
  }
}

TEST_CASE("the letters below a large picture are as large in it as below a small one") {
  // The height of the strip's letters, which is where it is neither white nor the scale bar, over the picture's width.
  const auto LetterShare = [](int width_cells) {
    Results results = MakeResults(width_cells, 3);
    results.matches = {MakeMatch(1, {0.0, 0.0, 0.0}, 0.0, MatchState::kFirst)};
    const Picture picture = Overview(results).picture();
    std::size_t first = picture.height;
    std::size_t last = 0;
    for (std::size_t y = 10; y < picture.height; ++y) {
      for (std::size_t x = 0; x < picture.width; ++x) {
        const auto colour = picture.At(x, y);
        if (colour[2] < colour[0] + 150 || colour[2] < colour[1] + 50) continue;  // the word "path", in its blue
        first = std::min(first, y);
        last = std::max(last, y);
      }
    }
    REQUIRE(first < last);
    return static_cast<double>(last - first + 1) / static_cast<double>(picture.width);
  };
  const double small = LetterShare(1600);
  CHECK(small > 0.006);  // 10 pixels
  // The faint edges of small letters miss a row or two; letters that do not grow have 0.4 of the share.
  CHECK(LetterShare(3999) == Approx(small).epsilon(0.3));
  CHECK(LetterShare(9000) == Approx(small).epsilon(0.3));
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
  results.summary_json = std::string(200000, 'x');
  const std::string error = ErrorOfWriting(folder.path(), results);
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, old_handler);

  CHECK(error == "cannot write " + (folder / "summary.json").string() + ": File too large");
  CHECK(FilesOf(folder.path()) == old_files);
}

TEST_CASE("a summary adds up path, fitness and explored area from poses and map") {
  const DenseGrid grid{3, 2, 0, 0, 0.5, {127, 0, 255, 128, 126, 127}};  // four cells of 0.25 m2
  // Lost scans are guesses: the path runs past them, 3-4-5 and then 1 m.
  const std::vector<ScanMatch> matches{
      MakeMatch(1, {0.0, 0.0, 0.0}, 0.0, MatchState::kFirst), MakeMatch(2, {90.0, 0.0, 0.0}, 0.1, MatchState::kLost),
      MakeMatch(3, {3.0, 4.0, 0.0}, 0.5, MatchState::kOk), MakeMatch(4, {3.0, 5.0, 0.0}, 0.7, MatchState::kOk)};
  const Summary summary = Summarize(matches, grid);
  CHECK(summary.scans == 4);
  CHECK(summary.lost == 1);
  CHECK(summary.path_length_m == Approx(6.0));
  CHECK(summary.mean_fitness == Approx(0.6));
  CHECK(summary.explored_area_m2 == Approx(1.0));

  const Summary empty = Summarize({}, {});
  CHECK(empty.scans == 0);
  CHECK(empty.mean_fitness == 0.0);
  CHECK(empty.explored_area_m2 == 0.0);
}

TEST_CASE("a summary becomes JSON with everything in it, parameters in their order") {
  Summary summary;
  summary.version = "1.2.3";
  summary.scans = 10;
  summary.map_version = 9;
  summary.path_length_m = 2.5;
  summary.mean_fitness = std::numeric_limits<double>::quiet_NaN();
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
  CHECK(json["scans"] == 10);
  CHECK(json["lost"] == 0);
  CHECK(json["map_version"] == 9);
  CHECK(json["path_length_m"] == 2.5);
  CHECK(json["mean_fitness"].is_null());
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
