// Whether a map is to be trusted: the same answer from one process and from five, and an exit code for it.

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

void CheckSaid(const std::string& said, const std::string& text) {
  INFO(said);
  CHECK(said.find(text) != std::string::npos);
}

}  // namespace

TEST_CASE("five processes in lockstep judge a map as one process does") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 250, 2), "run.lcm");
  folder.Map(log, "offline");
  folder.MapWithStack(log, "stack");
  const nlohmann::json verdict = folder.Summary("offline")["verdict"];
  CHECK(verdict["trust"] == "good");
  CHECK(verdict["agreement"] > 0.9);
  CHECK(verdict == folder.Summary("stack")["verdict"]);
  for (const char* key : {"scans", "on_map", "floating", "lost", "without_rays", "left_out", "degenerate",
                          "path_length_m", "mean_fitness", "made_from", "recorded"}) {
    INFO(key);
    CHECK(folder.Summary("offline")[key] == folder.Summary("stack")[key]);
  }
  CHECK(folder.Summary("stack")["made_from"] == "run.lcm");
  CHECK(folder.Summary("stack")["mapped"].get<std::string>().ends_with("Z"));
  const std::string other = folder.Write(TakeScans("sim:demo", 20, 2), "other.lcm");
  for (const char* out : {"offline", "stack"}) {
    folder.Map(other, out, {"--resume", folder / out, "--no-odometry"});
    CHECK(folder.Summary(out)["made_from"] == "run.lcm; then other.lcm --no-odometry");
  }
  folder.MapWithStack(log, "stack", {"--resume", folder / "stack"});
  CHECK(folder.Summary("stack")["made_from"] == "run.lcm; then other.lcm --no-odometry; then run.lcm");
}

TEST_CASE("a log of which half cannot be used is doubtful, and the reason is said, by one process and by many") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:demo", 60, 2);
  for (std::size_t i = 1; i < scans.size(); i += 2) scans[i].ranges_m.resize(1);
  const std::string log = folder.Write(scans, "run.lcm");
  for (const Ended& ended : {folder.Map(log, "offline"), folder.MapWithStack(log, "stack")}) {
    CheckSaid(ended.errors, "30 of 60 scans on LASER are left out: scans have 1 rays");
    CheckSaid(ended.output, "the map is doubtful");
    CheckSaid(ended.output, "30 of 60 scans of the recording were refused or repeated (50 %)");
  }
  CHECK(folder.Summary("offline")["verdict"] == folder.Summary("stack")["verdict"]);
  for (const char* out : {"offline", "stack"}) CHECK(folder.Summary(out)["left_out"] == 30);
}

TEST_CASE("a robot that is lost is said while it runs, and when it is found, by one process and by many") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:demo", 60);
  for (std::size_t i = 20; i < 40; ++i) {  // leaves before the laser
    for (std::size_t beam = 0; beam < scans[i].ranges_m.size(); ++beam) {
      scans[i].ranges_m[beam] = 0.3f + 0.01f * static_cast<float>(beam * 37 % 100);
    }
  }
  const std::string log = folder.Write(scans, "run.lcm");
  for (const auto& [errors, name] :
       {std::pair(folder.Map(log, "offline", {"--no-loops"}).errors, "slam_offline"),
        std::pair(folder.MapWithStack(log, "stack", {"--no-loops"}).errors, "map_updater")}) {
    const std::string said = name + std::string(": the robot is ");
    CheckSaid(errors, said + "lost: 10 lost scans since t = ");
    CheckSaid(errors, said + "lost: 20 lost scans since t = ");
    CheckSaid(errors, said + "found again after 20 lost scans");
  }
}

TEST_CASE("slam_offline says on its last lines whether the map is to be trusted, and with --strict by exit code 3") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:demo", 60, 2);
  folder.Write(scans, "good.lcm");
  for (LaserScan& scan : scans) {
    for (float& range_m : scan.ranges_m) range_m *= 1000.0f;  // millimetres
  }
  folder.Write(scans, "bad.lcm");
  const auto Map = [&](const std::string& name, std::vector<std::string> flags, int exit_code,
                       const std::string& words) {
    flags.insert(flags.begin(), {folder / (name + ".lcm"), "--out", folder / name});
    const Ended ended = folder.Run("slam_offline", flags);
    CHECK(ended.exit_code == exit_code);
    CheckSaid(ended.output, words);
  };
  Map("good", {"--strict"}, 0, "the map is good");
  Map("bad", {}, 1, "the map is not to be trusted");  // no scan is mapped
  Map("bad", {"--strict", "--force"}, 3, "warning: 100 % of the scans have no rays");
}
