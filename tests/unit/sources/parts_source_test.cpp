#include "services/sources/parts_source.hpp"

#include <algorithm>

#include "catch.hpp"
#include "lcm_events.hpp"
#include "packed.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/wire.hpp"
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
  const auto expected = OpenLaserSource((folder / "whole.log").string(), {});
  const auto parts = OpenLaserSource((folder / "run.log.*").string(), {});
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
  CHECK(ErrorOf([&] { OpenLaserSource((folder / "other.*").string(), {}); }) ==
        "there is no file " + (folder / "other.*").string());
}

TEST_CASE(
    "parts whose times go from the last to the first are read so, and one that is compressed, too, is read once") {
  const ScratchFolder folder;
  for (int part = 0; part < 4; ++part) folder.Write("run.log." + std::to_string(part), LineAt(10 - part));
  folder.Write("run.log.3.gz", Pack("gzip", LineAt(7)));
  const auto parts = OpenLaserSource((folder / "run.log.*").string(), {});
  const auto scans = ReadAll(*parts);
  REQUIRE(scans.size() == 4);
  CHECK(std::ranges::is_sorted(scans, {}, &LaserScan::utime));
  REQUIRE(parts->Complaints().size() == 1);
  CHECK(parts->Complaints()[0].starts_with("the parts are read from the last to the first"));
}

TEST_CASE("parts that begin at the same time are read in the order of their numbers") {
  const ScratchFolder folder;
  for (int part = 0; part < 3; ++part) {
    folder.Write("run.log." + std::to_string(part), LineAt(0) + "FLASER 3 1 1 " + std::to_string(part) +
                                                        " 0 0 0 0 0 0 " + std::to_string(part + 1) + " host 0\n");
  }
  const auto parts = OpenLaserSource((folder / "run.log.*").string(), {});
  CHECK(parts->Next()->utime == 500'000);
  CHECK(parts->Next()->utime == 1'000'000);
  CHECK(parts->Complaints().empty());
}

TEST_CASE("all parts are of the laser of the first one, and a first part without one is left out") {
  const ScratchFolder folder;
  const auto ScanOn = [](const std::string& channel, std::int64_t utime) {
    bot_core::planar_lidar_t scan{};
    scan.utime = utime;
    scan.nranges = 3;
    scan.ranges = {1.0f, 2.0f, 3.0f};
    scan.radstep = 0.5f;
    return Event(channel, DataOf(scan));
  };
  folder.Write("run.lcm.0", Event("OTHER", "nothing"));
  folder.Write("run.lcm.1", ScanOn("FRONT", 1) + ScanOn("REAR", 2));
  folder.Write("run.lcm.2", ScanOn("REAR", 3) + ScanOn("FRONT", 4));
  const auto parts = OpenLaserSource((folder / "run.lcm.*").string(), {});
  const auto scans = ReadAll(*parts);
  REQUIRE(scans.size() == 2);
  CHECK(scans[0].utime == 1);
  CHECK(scans[1].utime == 4);
  const std::vector<std::string> complaints = parts->Complaints();
  REQUIRE(complaints.size() == 3);
  CHECK(complaints[0].find("run.lcm.0 has no laser messages") != std::string::npos);
  CHECK(complaints[1].find("the scans are those on FRONT; there is a laser on REAR, too") != std::string::npos);
}

TEST_CASE("a part that a link names once more is read once") {
  const ScratchFolder folder;
  for (int part = 0; part < 3; ++part) folder.Write("run.log." + std::to_string(part), LineAt(part));
  std::filesystem::create_symlink(folder / "run.log.2", folder / "run.log.latest");
  CHECK(ReadAll(*OpenLaserSource((folder / "run.log.*").string(), {})).size() == 3);
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
