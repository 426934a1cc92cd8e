#include "services/sources/parts_source.hpp"

#include "catch.hpp"
#include "services/sources/open_laser_source.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace {

std::string LineAt(int second) {
  return "FLASER 3 1.5 2.5 3.5 0 0 0 " + std::to_string(second) + " 0 0 " + std::to_string(second) + ".5 host 0\n";
}

}  // namespace

TEST_CASE("the parts of a log are one log, in the order of their numbers, compressed or not") {
  const ScratchFolder folder;
  std::string whole;
  for (int part = 8; part < 12; ++part) {
    std::string lines;
    for (int i = 0; i < 10; ++i) lines += LineAt(10 * part + i);
    if (part == 10) lines += "FLASER 3 wrong\n";
    whole += lines;
    folder.Write("run.log." + std::to_string(part), part == 9 ? Pack("zstd", lines) : lines);
  }
  folder.Write("whole.log", whole);
  SourceOptions options;
  options.odometry.is_used = true;
  const auto expected = OpenLaserSource((folder / "whole.log").string(), options);
  const auto parts = OpenLaserSource((folder / "run.log.*").string(), options);
  double progress = -1.0;
  for (int i = 0; i < 40; ++i) {
    const auto scan = parts->Next();
    REQUIRE(scan);
    CHECK(scan == expected->Next());
    CHECK(parts->Odometry()->x_m == expected->Odometry()->x_m);
    CHECK(parts->Progress() >= progress);
    progress = parts->Progress();
  }
  CHECK_FALSE(parts->Next());
  CHECK(parts->Progress() == 1.0);
  CHECK(CountOf(*parts, "bad_line") == 1);
  REQUIRE(parts->Complaints().size() == 1);
  CHECK(parts->Complaints()[0].find((folder / "run.log.10").string() + ": 1 of 11 scans") == 0);
  CHECK(ErrorOf([&] { OpenLaserSource((folder / "other.*").string(), options); }) ==
        "there is no file " + (folder / "other.*").string());
}

TEST_CASE("a part that cannot be read is left out and said, and the parts behind it are read") {
  const ScratchFolder folder;
  folder.Write("run.log.0", LineAt(1));
  folder.Write("run.log.1", "");
  folder.Write("run.log.2", LineAt(2));
  const auto parts = OpenLaserSource((folder / "run.log.*").string(), {});
  CHECK(ReadAll(*parts).size() == 2);
  CHECK(CountOf(*parts, "truncated") == 1);
  REQUIRE(parts->Complaints().size() == 1);
  CHECK(parts->Complaints()[0].find((folder / "run.log.1").string() + " is empty") == 0);
  folder.Write("[a].log.0", LineAt(1));
  CHECK(FindParts((folder / "[a].log.*").string()).size() == 1);
}

TEST_CASE("files that a source is read from are known, whatever names it") {
  const ScratchFolder folder;
  for (const char* name : {"run.0", "run.1", "a.world"}) folder.Write(name, "");
  const std::string path = folder.path().string();
  CHECK(FilesOfSource(path).size() == 3);
  CHECK(FilesOfSource(path + "/run.*") == std::vector{path + "/run.0", path + "/run.1"});
  CHECK(FilesOfSource("sim:" + path + "/a.world") == std::vector{path + "/a.world"});
  CHECK(FilesOfSource("sim:demo").empty());
  CHECK(FilesOfSource("rplidar:/dev/none").empty());
}

TEST_CASE("parts go by their numbers, and by their letters where they have none") {
  const ScratchFolder folder;
  const std::vector<std::string> names{"a2b10", "a2b9", "a10", "a", "b01", "b1c", "a02b9"};
  for (const std::string& name : names) folder.Write(name, "");
  std::vector<std::string> found;
  for (const std::string& path : FindParts((folder / "*").string())) {
    found.push_back(std::filesystem::path(path).filename().string());
  }
  REQUIRE(found.size() == names.size());
  CHECK(found.front() == "a");
  CHECK(std::ranges::find(found, "a2b9") < std::ranges::find(found, "a2b10"));
  CHECK(std::ranges::find(found, "a2b10") < std::ranges::find(found, "a10"));
  CHECK(std::ranges::find(found, "a10") < std::ranges::find(found, "b01"));
}
