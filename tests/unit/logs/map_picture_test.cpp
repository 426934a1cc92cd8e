#include "common/logs/map_picture.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include "catch.hpp"
#include "common/logs/map_files.hpp"
#include "common/logs/read_map.hpp"
#include "common/logs/replacement.hpp"
#include "scratch.hpp"

using namespace crsm;

namespace {

std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Write(const ScratchFolder& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder / name, std::ios::binary) << text;
}

std::string YamlOf(const std::string& picture) { return FormatMapYaml(MakeUnexploredCell(0.05), picture); }

}  // namespace

TEST_CASE("the picture that map.yaml names is kept when map.png is replaced, and older ones are removed") {
  const ScratchFolder folder;
  Write(folder, "map.png", "first");
  Write(folder, "map.yaml", YamlOf("map.png"));
  CHECK(FindPicture(folder.path()) == "map.png");
  FreeMapPicture(folder.path());
  CHECK(FindPicture(folder.path()) == "map.1.png");
  CHECK(ReadText(folder / "map.1.png") == "first");
  CHECK(ReadText(folder / "map.yaml") == YamlOf("map.1.png"));
  CHECK_FALSE(std::filesystem::exists(folder / "map.1.yaml"));
  FreeMapPicture(folder.path());  // it is free
  CHECK(NameNextPicture(folder.path()) == "map.2.png");
  for (const char* name : {"map.2.png", "map.3.png", "map.04.png", "map.x.png", "map.png.bak"}) {
    Write(folder, name, "another");
  }
  RemoveOldPictures(folder.path(), "map.3.png");
  CHECK_FALSE(std::filesystem::exists(folder / "map.2.png"));
  for (const char* name : {"map.1.png", "map.3.png", "map.04.png", "map.x.png", "map.png.bak"}) {
    CHECK(std::filesystem::exists(folder / name));
  }
  Write(folder, "map.yaml", YamlOf("map.png"));
  RemoveOldPictures(folder.path());
  CHECK_FALSE(std::filesystem::exists(folder / "map.1.png"));
}

TEST_CASE("map.png is made free also while the next map.yaml is half written") {
  const ScratchFolder folder;
  Write(folder, "map.png", "first");
  Write(folder, "map.yaml", YamlOf("map.png"));
  Replacement next(folder.path());
  next.Write("map.png", "second");
  next.Write("map.yaml", YamlOf("map.png") + "# next\n");
  FreeMapPicture(folder.path());
  CHECK(ReadText(folder / "map.yaml") == YamlOf("map.1.png"));
  next.Rename();
  CHECK(ReadText(folder / "map.png") == "second");
  CHECK(ReadText(folder / "map.yaml") == YamlOf("map.png") + "# next\n");
}

TEST_CASE("a folder without a map, or with somebody's own map.yaml, is left as it is") {
  const ScratchFolder folder;
  FreeMapPicture(folder.path());
  CHECK(std::filesystem::is_empty(folder.path()));
  CHECK(FindPicture(folder.path()) == "map.png");
  for (const char* yaml : {"image: /etc/passwd\n", "image: ../map.png\n", "resolution: 1\n", ""}) {
    Write(folder, "map.yaml", yaml);
    FreeMapPicture(folder.path());
    CHECK(ReadText(folder / "map.yaml") == yaml);
    CHECK(FindPicture(folder.path()) == "map.png");
  }
}

TEST_CASE("what a killed process has left half written is removed, and the pair of map.yaml is not") {
  const ScratchFolder folder;
  const pid_t ended = 999'999'999;  // more than the kernel gives
  for (const std::string name : {".map.png.", ".map.yaml.", ".map.12.png.", ".map.12.yaml.", ".graph.g2o."}) {
    Write(folder, name + std::to_string(ended) + ".tmp", "half");
    Write(folder, name + std::to_string(getpid()) + ".tmp", "is being written");
  }
  Write(folder, "map.7.png", "picture");
  Write(folder, "map.6.png", "picture");
  Write(folder, "map.yaml", YamlOf("map.7.png"));
  RemoveLeftovers(folder.path());
  std::size_t num_left = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    CHECK(entry.path().filename().string().find(std::to_string(ended)) == std::string::npos);
    ++num_left;
  }
  CHECK(num_left == 7);
  CHECK(std::filesystem::exists(folder / "map.7.png"));
}
