// Whether a map is to be trusted: the same answer from one process and from five, and an exit code for it.

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

const std::string kRunStack = CRSM_SOURCE_DIR "/scripts/run_stack";

nlohmann::json ReadVerdict(const std::filesystem::path& out) {
  return nlohmann::json::parse(ReadFile(out / "summary.json"))["verdict"];
}

}  // namespace

TEST_CASE("five processes in lockstep judge a map as one process does") {
  const TemporaryFolder folder;
  WriteScans(TakeScans("sim:demo", 250, 2), folder / "run.lcm");
  const std::string log = folder / "run.lcm";
  REQUIRE(Run("slam_offline", {log, "--out", folder / "offline"}, folder / "log") == 0);
  REQUIRE(Run(kRunStack, {log, "--out", folder / "stack", "--lcm-url", MakeBusUrl()}, folder / "log") == 0);
  const nlohmann::json verdict = ReadVerdict(folder / "offline");
  CHECK(verdict["trust"] == "good");
  CHECK(verdict["agreement"] > 0.9);
  CHECK(verdict == ReadVerdict(folder / "stack"));
}

TEST_CASE("a log of which half cannot be used is doubtful, and the reason is said, by one process and by many") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:demo", 60, 2);
  for (std::size_t i = 1; i < scans.size(); i += 2) scans[i].ranges_m.resize(1);
  const std::string log = folder / "run.lcm";
  WriteScans(scans, log);
  Process alone("slam_offline", {log, "--out", folder / "offline"}, folder / "log1");
  CHECK(alone.AwaitExit() == 0);
  Process stack(kRunStack, {log, "--out", folder / "stack", "--lcm-url", MakeBusUrl()}, folder / "log2");
  CHECK(stack.AwaitExit() == 0);
  for (const Process* process : {&alone, &stack}) {
    INFO(process->errors() + process->output());
    CHECK(process->errors().find("30 of 60 scans on LASER are left out: scans have 1 rays") != std::string::npos);
    CHECK(process->output().find("the map is doubtful") != std::string::npos);
    CHECK(process->output().find("30 of 60 scans of the recording are left out (50 %)") != std::string::npos);
  }
  CHECK(ReadVerdict(folder / "offline") == ReadVerdict(folder / "stack"));
}

TEST_CASE("a robot that is lost is said while it runs, and when it is found, by one process and by many") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:demo", 60);
  for (std::size_t i = 20; i < 40; ++i) {  // leaves before the laser
    for (std::size_t beam = 0; beam < scans[i].ranges_m.size(); ++beam) {
      scans[i].ranges_m[beam] = 0.3f + 0.01f * static_cast<float>(beam * 37 % 100);
    }
  }
  const std::string log = folder / "run.lcm";
  WriteScans(scans, log);
  Process alone("slam_offline", {log, "--out", folder / "offline", "--no-loops"}, folder / "log1");
  CHECK(alone.AwaitExit() == 0);
  Process stack(kRunStack, {log, "--out", folder / "stack", "--no-loops", "--lcm-url", MakeBusUrl()}, folder / "log2");
  CHECK(stack.AwaitExit() == 0);
  for (const auto& [process, name] : {std::pair(&alone, "slam_offline"), std::pair(&stack, "map_updater")}) {
    INFO(process->errors());
    const std::string said = name + std::string(": the robot is ");
    CHECK(process->errors().find(said + "lost: 10 scans since t = ") != std::string::npos);
    CHECK(process->errors().find(said + "lost: 20 scans since t = ") != std::string::npos);
    CHECK(process->errors().find(said + "found again after 20 lost scans") != std::string::npos);
  }
}

TEST_CASE("slam_offline says on its last lines whether the map is to be trusted, and with --strict by exit code 3") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:demo", 60, 2);
  WriteScans(scans, folder / "good.lcm");
  for (LaserScan& scan : scans) {
    for (float& range_m : scan.ranges_m) range_m *= 1000.0f;  // millimetres
  }
  WriteScans(scans, folder / "bad.lcm");
  const auto Map = [&](const std::string& name, std::vector<std::string> flags, int exit_code,
                       const std::string& words) {
    flags.insert(flags.begin(), {folder / (name + ".lcm"), "--out", folder / name});
    Process process("slam_offline", flags, folder / "log");
    CHECK(process.AwaitExit() == exit_code);
    INFO(process.output());
    CHECK(process.output().find(words) != std::string::npos);
  };
  Map("good", {"--strict"}, 0, "the map is good");
  Map("bad", {}, 1, "the map is not to be trusted");  // no scan is mapped
  Map("bad", {"--strict", "--force"}, 3, "warning: 100 % of the scans have no rays");
}
