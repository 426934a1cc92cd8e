#include "common/results/results.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "catch.hpp"
#include "common/results/summary.hpp"

using namespace crsm;
namespace fs = std::filesystem;

namespace {

struct TemporaryFolder {
  const fs::path path = Make();
  ~TemporaryFolder() { fs::remove_all(path); }

  static fs::path Make() {
    std::string name = fs::temp_directory_path() / "crsm_results_test_XXXXXX";
    REQUIRE(mkdtemp(name.data()));
    return name;
  }
};

std::string ReadBytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

struct Picture {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 0;
  std::vector<int> samples;  // row by row from the top

  int At(std::size_t column, std::size_t row) const { return samples.at((row * width + column) * channels); }
  std::array<int, 3> ColourAt(std::size_t column, std::size_t row) const {
    const std::size_t i = (row * width + column) * channels;
    return {samples.at(i), samples.at(i + 1), samples.at(i + 2)};
  }
};

/// Decodes 8-bit grey or RGB by the PNG specification, sections 5, 9 and 10, without the library that wrote it.
Picture DecodePng(const std::string& bytes) {
  const auto Number = [&](std::size_t at) {
    std::size_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
    return value;
  };
  REQUIRE(bytes.substr(0, 8) == "\x89PNG\r\n\x1a\n");
  Picture picture;
  std::string packed;
  for (std::size_t at = 8; at < bytes.size(); at += Number(at) + 12) {
    const std::string type = bytes.substr(at + 4, 4);
    if (type == "IHDR") {
      picture.width = Number(at + 8);
      picture.height = Number(at + 12);
      REQUIRE(bytes.at(at + 16) == 8);
      const char colour_type = bytes.at(at + 17);
      REQUIRE((colour_type == 0 || colour_type == 2));
      picture.channels = colour_type == 0 ? 1 : 3;
    }
    if (type == "IDAT") packed += bytes.substr(at + 8, Number(at));
  }
  const std::size_t stride = picture.width * picture.channels;
  std::vector<unsigned char> raw((stride + 1) * picture.height);
  uLongf size = raw.size();
  REQUIRE(uncompress(raw.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) == Z_OK);
  REQUIRE(size == raw.size());
  const auto Sample = [&](std::size_t row, std::size_t i) { return picture.samples[row * stride + i]; };
  for (std::size_t row = 0; row < picture.height; ++row) {
    const unsigned char filter = raw[row * (stride + 1)];
    for (std::size_t i = 0; i < stride; ++i) {
      const int left = i >= picture.channels ? Sample(row, i - picture.channels) : 0;
      const int up = row > 0 ? Sample(row - 1, i) : 0;
      const int corner = row > 0 && i >= picture.channels ? Sample(row - 1, i - picture.channels) : 0;
      const int estimate = left + up - corner;
      const int to_left = std::abs(estimate - left);
      const int to_up = std::abs(estimate - up);
      const int to_corner = std::abs(estimate - corner);
      const int paeth = to_left <= to_up && to_left <= to_corner ? left : to_up <= to_corner ? up : corner;
      const std::array<int, 5> predictions{0, left, up, (left + up) / 2, paeth};
      picture.samples.push_back((raw[row * (stride + 1) + 1 + i] + predictions.at(filter)) & 255);
    }
  }
  return picture;
}

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

std::string ErrorOf(const fs::path& dir, const Results& results) {
  try {
    WriteResults(dir, results);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("map.png holds each cell's byte, with the highest y on top") {
  const TemporaryFolder folder;
  const Results results = MakeResults(7, 5);
  WriteResults(folder.path, results);
  const Picture picture = DecodePng(ReadBytes(folder.path / "map.png"));
  REQUIRE(picture.width == 7);
  REQUIRE(picture.height == 5);
  REQUIRE(picture.channels == 1);
  for (std::size_t y = 0; y < 5; ++y) {
    for (std::size_t x = 0; x < 7; ++x) CHECK(picture.At(x, 4 - y) == results.grid.cells[y * 7 + x]);
  }
}

TEST_CASE("map.pgm is the picture of map.png, a byte a pixel behind a header") {
  const TemporaryFolder folder;
  const Results results = MakeResults(7, 5);
  WriteResults(folder.path, results);
  const std::string pgm = ReadBytes(folder.path / "map.pgm");
  const std::string header = "P5\n7 5\n255\n";
  REQUIRE(pgm.size() == header.size() + 35);
  CHECK(pgm.starts_with(header));
  for (std::size_t y = 0; y < 5; ++y) {
    for (std::size_t x = 0; x < 7; ++x) {
      CHECK(static_cast<std::uint8_t>(pgm[header.size() + (4 - y) * 7 + x]) == results.grid.cells[y * 7 + x]);
    }
  }
}

TEST_CASE("map.yaml places the lower left corner in metres and keeps map_server's thresholds") {
  const TemporaryFolder folder;
  WriteResults(folder.path, MakeResults(7, 5));
  CHECK(ReadBytes(folder.path / "map.yaml") ==
        "image: map.png\nresolution: 0.05\norigin: [-0.100000, 0.150000, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST_CASE("the folder is made, holds the six files and no others, and a second run gives the same bytes") {
  const TemporaryFolder folder;
  const fs::path dir = folder.path / "a" / "b";
  Results results = MakeResults(40, 30);
  results.matches = {MakeMatch(5000000, {0.25, 0.5, 0.0}, 0.9, MatchState::kFirst)};
  std::array<std::string, 2> bytes;
  for (std::string& run : bytes) {
    WriteResults(dir, results);
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(dir)) names.insert(entry.path().filename());
    CHECK(names ==
          std::set<std::string>{"map.pgm", "map.png", "map.yaml", "overview.png", "summary.json", "trajectory.tum"});
    for (const std::string& name : names) run += ReadBytes(dir / name);
  }
  CHECK(bytes[0] == bytes[1]);
  CHECK(ReadBytes(dir / "trajectory.tum") == "5.000000 0.250000000 0.500000000 0 0 0 0.000000000 1.000000000\n");
  CHECK(ReadBytes(dir / "summary.json") == "{}\n");
}

TEST_CASE("a reader that has a file open keeps the whole old one") {
  const TemporaryFolder folder;
  Results results = MakeResults(4, 4);
  WriteResults(folder.path, results);
  std::ifstream reader(folder.path / "summary.json");
  results.summary_json = "{\"scans\": 1}\n";
  WriteResults(folder.path, results);
  std::string text;
  std::getline(reader, text);
  CHECK(text == "{}");
  CHECK(ReadBytes(folder.path / "summary.json") == results.summary_json);
}

TEST_CASE("an empty map is written as one unexplored cell") {
  const TemporaryFolder folder;
  for (const double cell_size_m : {0.0, 0.05}) {
    Results results;
    results.grid.cell_size_m = cell_size_m;
    WriteResults(folder.path, results);
    const Picture picture = DecodePng(ReadBytes(folder.path / "map.png"));
    CHECK(picture.width == 1);
    CHECK(picture.height == 1);
    CHECK(picture.At(0, 0) == 127);
    const std::string expected = cell_size_m == 0.0 ? "resolution: 1\n" : "resolution: 0.05\n";
    CHECK(ReadBytes(folder.path / "map.yaml").find(expected) != std::string::npos);
    CHECK(ReadBytes(folder.path / "trajectory.tum").empty());
    CHECK(DecodePng(ReadBytes(folder.path / "overview.png")).channels == 3);
  }
}

TEST_CASE("the overview shows start, path, end, lost scans and hits where they are") {
  // 100 x 100 unexplored cells of 0.1 m from (-5, -5) m on: 16 pixels a cell, so a metre is 160 pixels.
  const TemporaryFolder folder;
  Results results;
  results.grid = {100, 100, -50, -50, 0.1, std::vector<std::uint8_t>(10000, 127)};
  results.matches = {MakeMatch(1, {-3.0, 0.0, 0.0}, 0.0, MatchState::kFirst),
                     MakeMatch(2, {2.0, 4.0, 0.0}, 0.1, MatchState::kLost),
                     MakeMatch(3, {3.0, 0.0, kPi / 2}, 0.9, MatchState::kOk)};
  results.last_scan = {3, {{0.0f}, {2.0f}}, {}};  // looks up from (3, 0): a hit 2 m ahead
  WriteResults(folder.path, results);
  const Picture picture = DecodePng(ReadBytes(folder.path / "overview.png"));
  REQUIRE(picture.width == 1600);
  REQUIRE(picture.height > 1600);
  const auto ColourAt = [&](double x_m, double y_m) {
    return picture.ColourAt(static_cast<std::size_t>((x_m + 5.0) * 160), static_cast<std::size_t>((5.0 - y_m) * 160));
  };
  const auto start = ColourAt(-3.0, 0.0);
  const auto path = ColourAt(0.0, 0.0);
  const auto end = ColourAt(3.0, 0.0);
  const auto lost = ColourAt(2.0, 4.0);
  const auto hit = ColourAt(3.0, 2.0);
  CHECK((start[1] > start[0] && start[1] > start[2]));  // green
  CHECK((end[0] > end[1] && end[0] > end[2]));          // red
  CHECK(path[2] > path[0]);                             // blue
  CHECK((lost[0] > lost[1] && lost[1] > lost[2]));      // orange
  CHECK((hit[0] > hit[1] && hit[2] > hit[1]));          // magenta
  CHECK(ColourAt(-2.0, 3.0) == std::array<int, 3>{127, 127, 127});
  CHECK(ColourAt(3.0, 3.0) == std::array<int, 3>{127, 127, 127});
}

TEST_CASE("the overview shows loops that hold and loops that were taken out in colours that its strip explains") {
  const TemporaryFolder folder;
  Results results;
  results.grid = {100, 100, -50, -50, 0.1, std::vector<std::uint8_t>(10000, 127)};
  results.loops = {{{-3.0, 1.0, 0.0}, {3.0, 1.0, 0.0}, false}, {{-3.0, -1.0, 0.0}, {3.0, -1.0, 0.0}, true}};
  WriteResults(folder.path, results);
  const Picture picture = DecodePng(ReadBytes(folder.path / "overview.png"));
  const auto ColourAt = [&](double x_m, double y_m) {
    return picture.ColourAt(static_cast<std::size_t>((x_m + 5.0) * 160), static_cast<std::size_t>((5.0 - y_m) * 160));
  };
  const auto held = ColourAt(0.0, 1.0);
  const auto taken_out = ColourAt(0.0, -1.0);
  CHECK((held[1] > 2 * held[0] && held[2] > 2 * held[0]));                        // turquoise
  CHECK((taken_out[0] > taken_out[1] + 30 && taken_out[1] > taken_out[2] + 30));  // brown
  CHECK(ColourAt(0.0, 0.0) == std::array<int, 3>{127, 127, 127});
  // Letters are thin: their colours are mixed with the white of the strip.
  const auto StripHas = [](const Picture& shown, auto&& is_colour) {
    for (std::size_t y = shown.height - 44; y < shown.height; ++y) {
      for (std::size_t x = 0; x < shown.width; ++x) {
        const auto [red, green, blue] = shown.ColourAt(x, y);
        if (is_colour(red, green, blue)) return true;
      }
    }
    return false;
  };
  const auto IsTurquoise = [](int red, int green, int blue) { return green > red + 60 && std::abs(green - blue) < 20; };
  const auto IsBrown = [](int red, int green, int blue) { return red < 200 && red > green + 25 && green > blue + 25; };
  CHECK(StripHas(picture, IsTurquoise));
  CHECK(StripHas(picture, IsBrown));
  Results narrow = results;
  narrow.grid = {2, 100, -1, -50, 0.1, std::vector<std::uint8_t>(200, 127)};
  WriteResults(folder.path, narrow);
  CHECK(StripHas(DecodePng(ReadBytes(folder.path / "overview.png")), IsBrown));  // the last words have room

  results.loops.pop_back();
  WriteResults(folder.path, results);
  const Picture without = DecodePng(ReadBytes(folder.path / "overview.png"));
  CHECK(StripHas(without, IsTurquoise));
  CHECK_FALSE(StripHas(without, IsBrown));
  results.loops.clear();
  WriteResults(folder.path, results);
  CHECK_FALSE(StripHas(DecodePng(ReadBytes(folder.path / "overview.png")), IsTurquoise));
}

TEST_CASE("the overview shows where the path breaks and where it is joined, and no scan of another piece") {
  const TemporaryFolder folder;
  Results results;
  results.grid = {100, 100, -50, -50, 0.1, std::vector<std::uint8_t>(10000, 127)};
  results.loops = {{{-3.0, 1.0, 0.0}, {3.0, 1.0, 0.0}, false, true}};
  std::vector<ScanMatch> matches{MakeMatch(1, {-4.0, -4.0, 0.0}, 0.9, MatchState::kFirst),
                                 MakeMatch(2, {-3.0, -4.0, 0.0}, 0.9, MatchState::kOk),
                                 MakeMatch(3, {2.0, 3.0, 0.0}, 0.9, MatchState::kLost)};
  matches.back().floating = true;  // as one of another piece comes
  results.matches = matches;
  results.pieces.num_pieces = 2;
  results.pieces.num_breaks = 1;
  results.pieces.breaks = {{3, 2, BreakReason::kGap, 9.0, {0.0, -2.0, 0.0}, 1, 2}};
  WriteResults(folder.path, results);
  const Picture picture = DecodePng(ReadBytes(folder.path / "overview.png"));
  const auto ColourAt = [&](double x_m, double y_m) {
    return picture.ColourAt(static_cast<std::size_t>((x_m + 5.0) * 160), static_cast<std::size_t>((5.0 - y_m) * 160));
  };
  const auto joined = ColourAt(0.0, 1.0);
  CHECK((joined[2] > joined[0] + 50 && joined[0] > joined[1] + 30));  // violet
  const auto broken = ColourAt(0.0, -2.0);
  CHECK((broken[0] > broken[2] + 50 && broken[2] > broken[1] + 50));  // crimson
  CHECK(ColourAt(0.04, -2.0) == std::array<int, 3>{127, 127, 127});   // a cross
  CHECK(ColourAt(2.0, 3.0) == std::array<int, 3>{127, 127, 127});
  matches.back().floating = false;
  results.matches = matches;
  WriteResults(folder.path, results);
  const Picture lost = DecodePng(ReadBytes(folder.path / "overview.png"));
  CHECK(lost.ColourAt(1120, 320) != std::array<int, 3>{127, 127, 127});
}

TEST_CASE("pieces have maps of their own, and none of an earlier writing stays") {
  const TemporaryFolder folder;
  const Results piece = MakeResults(7, 5);
  const MatchSequence matches{MakeMatch(5, {1.0, 2.0, 0.0}, 0.9, MatchState::kOk)};
  for (const int number : {2, 3}) WritePiece(folder.path, number, piece.grid, matches);
  WriteResults(folder.path, piece);
  for (const char* file : {"map.png", "map.pgm", "map.yaml"}) {
    CHECK(ReadBytes(folder.path / "pieces/3" / file) == ReadBytes(folder.path / file));
  }
  CHECK(ReadBytes(folder.path / "pieces/2/trajectory.tum").find("1.000000000 2.000000000") != std::string::npos);
  WritePiece(folder.path, 4, {}, {});  // nothing was seen
  CHECK(DecodePng(ReadBytes(folder.path / "pieces/4/map.png")).width == 1);
  RemovePieces(folder.path);
  CHECK_FALSE(fs::exists(folder.path / "pieces"));
  RemovePieces(folder.path);  // there are none

  WritePiece(folder.path, 2, piece.grid, matches);
  fs::create_directories(folder.path / "pieces/mine");
  std::ofstream(folder.path / "pieces/2/notes.txt") << "of the user";
  RemovePieces(folder.path);
  CHECK(fs::exists(folder.path / "pieces/mine"));
  CHECK(fs::exists(folder.path / "pieces/2/notes.txt"));
  CHECK_FALSE(fs::exists(folder.path / "pieces/2/map.png"));
}

TEST_CASE("the overview shows the last scan deskewed by its match") {
  // The laser drives ahead at 2 m/s; 0.5 s before the scan's time it was 1 m further back and saw a wall 2 m ahead.
  const TemporaryFolder folder;
  Results results;
  results.grid = {100, 100, -50, -50, 0.1, std::vector<std::uint8_t>(10000, 127)};
  results.last_scan = {1, {{0.0f}, {2.0f}, {-0.5f}}, {}};
  ScanMatch match = MakeMatch(1, {}, 0.9, MatchState::kOk);
  match.twist.x_m_s = 2.0;
  results.matches = {match};
  WriteResults(folder.path, results);
  const Picture picture = DecodePng(ReadBytes(folder.path / "overview.png"));
  const auto IsHitAt = [&](double x_m) {
    const auto colour = picture.ColourAt(static_cast<std::size_t>((x_m + 5.0) * 160), 800);
    return colour[0] > colour[1] && colour[2] > colour[1];
  };
  CHECK(IsHitAt(1.0));
  CHECK_FALSE(IsHitAt(2.0));
}

TEST_CASE("the overview is enlarged to about 1600 pixels and shrunk only above 4000") {
  const auto SideOf = [](int width_cells) {
    const TemporaryFolder folder;
    WriteResults(folder.path, MakeResults(width_cells, 3));
    return DecodePng(ReadBytes(folder.path / "overview.png")).width;
  };
  CHECK(SideOf(2) == 640);  // the strip's least width
  CHECK(SideOf(700) == 1400);
  CHECK(SideOf(1600) == 1600);
  CHECK(SideOf(3999) == 3999);
  CHECK(SideOf(9000) == 4000);
}

TEST_CASE("the letters below a large picture are as large in it as below a small one") {
  // The height of the strip's letters, which is where it is neither white nor the scale bar, over the picture's width.
  const auto LetterShare = [](int width_cells) {
    const TemporaryFolder folder;
    Results results = MakeResults(width_cells, 3);
    results.matches = {MakeMatch(1, {0.0, 0.0, 0.0}, 0.0, MatchState::kFirst)};
    WriteResults(folder.path, results);
    const Picture picture = DecodePng(ReadBytes(folder.path / "overview.png"));
    std::size_t first = picture.height;
    std::size_t last = 0;
    for (std::size_t y = 10; y < picture.height; ++y) {
      for (std::size_t x = 0; x < picture.width; ++x) {
        const auto colour = picture.ColourAt(x, y);
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
  const TemporaryFolder folder;
  Results results = MakeResults(50, 50);
  std::vector<ScanMatch> matches;
  for (const double far_m : {1e300, -1e300, 1e9}) {
    matches.push_back(MakeMatch(1, {far_m, far_m, 1.0}, 0.5, MatchState::kOk));
    matches.push_back(MakeMatch(2, {far_m, -far_m, 1.0}, 0.5, MatchState::kLost));
  }
  results.matches = matches;
  results.last_scan = {2, {std::vector<float>(360, 0.01f), std::vector<float>(360, 5.0f)}, {}};
  CHECK_NOTHROW(WriteResults(folder.path, results));
}

TEST_CASE("a grid that is not the size of its cells and a pose that is not finite are refused") {
  const TemporaryFolder folder;
  Results results = MakeResults(7, 5);
  results.grid.width_cells = 8;
  CHECK_THROWS_WITH(WriteResults(folder.path, results),
                    "WriteResults: a grid of 8 x 5 cells of 0.05 m cannot hold 35 cells");
  results.grid.width_cells = -7;
  results.grid.height_cells = -5;
  CHECK_THROWS_AS(WriteResults(folder.path, results), std::invalid_argument);
  results = MakeResults(7, 5);
  results.grid.cell_size_m = 0.0;
  CHECK_THROWS_AS(WriteResults(folder.path, results), std::invalid_argument);
  results = MakeResults(7, 5);
  results.matches = {MakeMatch(1, {std::nan(""), 0.0, 0.0}, 0.5, MatchState::kOk)};
  CHECK_THROWS_AS(WriteResults(folder.path, results), std::invalid_argument);
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("what cannot be written is named with the reason, and leaves no temporary file") {
  const TemporaryFolder folder;
  const Results results = MakeResults(4, 4);
  const fs::path file = folder.path / "file";
  std::ofstream(file) << "x";
  CHECK(ErrorOf(file / "out", results) == "cannot make the folder " + (file / "out").string() + ": Not a directory");
  CHECK(ErrorOf("/proc/self", results).rfind("cannot write /proc/self/map.png: ", 0) == 0);

  const fs::path dir = folder.path / "dir";
  fs::create_directories(dir / "map.png");
  CHECK(ErrorOf(dir, results) == "cannot write " + (dir / "map.png").string() + ": Is a directory");
  CHECK(std::distance(fs::directory_iterator(dir), {}) == 1);
}

TEST_CASE("a disk that fills up at the last file leaves all the old ones") {
  const TemporaryFolder folder;
  WriteResults(folder.path, MakeResults(4, 4));
  std::map<fs::path, std::string> old_files;
  for (const auto& entry : fs::directory_iterator(folder.path)) old_files[entry.path()] = ReadBytes(entry.path());

  // A limit on the size of files stands in for the full disk.
  rlimit unlimited{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &unlimited) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limited{100000, unlimited.rlim_max};
  REQUIRE(setrlimit(RLIMIT_FSIZE, &limited) == 0);
  Results results = MakeResults(5, 7);
  results.summary_json = std::string(200000, 'x');
  const std::string error = ErrorOf(folder.path, results);
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, old_handler);

  CHECK(error == "cannot write " + (folder.path / "summary.json").string() + ": File too large");
  CHECK(old_files.size() == 6);
  std::map<fs::path, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder.path)) files[entry.path()] = ReadBytes(entry.path());
  CHECK(files == old_files);
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
  CHECK(json["parameters"]["one"]["z_first"] == 40);
  CHECK(json["parameters"]["one"]["a_second"] == true);
  CHECK(json["parameters"]["one"]["size_m"] == 0.05);
  CHECK(json["parameters"]["one"]["seed"] == ~std::uint64_t{0});
  CHECK(json["parameters"]["one"]["log"] == "not \xEF\xBF\xBD UTF-8 \"quoted\"");
  CHECK(json["parameters"]["other"] == nlohmann::json{{"z_first", 41}});
  CHECK(json["counts"]["dropped"] == 3);
  CHECK(json["timings"]["match"] == nlohmann::json{{"p50_ms", 1.5}, {"p95_ms", 2.0}, {"p99_ms", 2.5}, {"max_ms", 3.5}});
  CHECK(nlohmann::json::parse(FormatSummary({}))["counts"] == nlohmann::json::object());
}
