// What a process is on a bus, and where it writes to, it is alone: a second one is refused, by the name of the first.

#include <algorithm>
#include <fstream>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

const std::string kRunStack = CRSM_SOURCE_DIR "/scripts/run_stack";

/// Checks that a program ends at once, in one line that has all of `expected`.
void CheckRefused(const std::string& program, const std::vector<std::string>& arguments,
                  const std::vector<std::string>& expected, const std::filesystem::path& logs) {
  Process process(program, arguments, logs);
  CHECK(process.AwaitExit() == 1);
  const std::string errors = process.errors();
  INFO(errors);
  CHECK(std::count(errors.begin(), errors.end(), '\n') == 1);
  for (const std::string& text : expected) CHECK(errors.find(text) != std::string::npos);
}

}  // namespace

TEST_CASE("a second process in a role on one bus and prefix is refused, and told which process has it") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  const std::vector<std::vector<std::string>> commands{{"map_updater", "--journal", folder / "journal"},
                                                       {"rrhc_matcher"},
                                                       {"ray_selector"},
                                                       {"loop_closer"},
                                                       {"laser_publisher", "sim:hall", "--rate", "1"}};
  for (const auto& command : commands) {
    std::vector<std::string> arguments(command.begin() + 1, command.end());
    arguments.insert(arguments.end(), {"--lcm-url", url});
    Process first(command.front(), arguments, folder / "log");
    REQUIRE(first.AwaitReady());
    if (command.front() == "map_updater") arguments[1] = folder / "journal_2";
    CheckRefused(command.front(), arguments,
                 {" already has its ", ", process " + std::to_string(first.pid()) + " (", command.back()},
                 folder / "log");
    if (command.front() == "rrhc_matcher")
      CheckRefused("hill_climber", arguments, {" already has its matcher"}, folder / "log");
    arguments.insert(arguments.end(), {"--channel-prefix", "robot2/"});
    if (command.front() == "map_updater") arguments[1] = folder / "journal_3";
    Process other_prefix(command.front(), arguments, folder / "log");
    CHECK(other_prefix.AwaitReady());
    CHECK(other_prefix.Interrupt() == 0);
    CHECK(first.Interrupt() == 0);
  }
  CHECK_FALSE(std::filesystem::exists(folder / "journal_2"));  // refused before it wrote anything
}

TEST_CASE("run_stack is refused where services were started by hand, and touches nothing") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process updater("map_updater", {"--lcm-url", url}, folder / "log");
  REQUIRE(updater.AwaitReady());
  CheckRefused(kRunStack, {"sim:demo", "--out", folder / "out", "--lcm-url", url},
               {"run_stack: ", "already has its owner of a map, process " + std::to_string(updater.pid())},
               folder / "log");
  CHECK_FALSE(std::filesystem::exists(folder / "out"));
  CHECK(updater.Interrupt() == 0);
}

TEST_CASE("several exporters of one bus write to folders of their own, and not two to one") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process one("map_exporter", {"--lcm-url", url, "--out", folder / "one"}, folder / "log");
  Process two("map_exporter", {"--lcm-url", url, "--out", folder / "two"}, folder / "log");
  REQUIRE(one.AwaitReady());
  REQUIRE(two.AwaitReady());
  const std::string holder = "process " + std::to_string(one.pid());
  CheckRefused("map_exporter", {"--lcm-url", MakeBusUrl(), "--out", folder / "one"}, {"/one: ", holder, "writes there"},
               folder / "log");
  CheckRefused("slam_offline", {"sim:demo", "--out", folder / "one"}, {"/one: ", "writes there"}, folder / "log");
  CheckRefused(kRunStack, {"sim:demo", "--out", folder / "one", "--lcm-url", MakeBusUrl()}, {"/one: ", "writes there"},
               folder / "log");
  CHECK(one.Interrupt() == 0);
  CHECK(two.Interrupt() == 0);
}

TEST_CASE("a journal has one owner, on whatever bus") {
  const TemporaryFolder folder;
  Process one("map_updater", {"--lcm-url", MakeBusUrl(), "--journal", folder / "journal"}, folder / "log");
  REQUIRE(one.AwaitReady());
  CheckRefused("map_updater", {"--lcm-url", MakeBusUrl(), "--journal", folder / "journal", "--resume"},
               {"--journal ", "process " + std::to_string(one.pid()), "writes there"}, folder / "log");
  CHECK(one.Interrupt() == 0);
}
