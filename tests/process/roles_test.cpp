// What a process is on a bus, and where it writes to, it is alone: a second one is refused, by the name of the first.

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

/// Checks that a program ends at once, in one line that has all of `expected`.
void CheckRefused(const TemporaryFolder& folder, const std::string& program, const std::vector<std::string>& arguments,
                  const std::vector<std::string>& expected) {
  for (const std::string& text : expected) folder.CheckRefused(program, arguments, text, 1);
}

std::string ProcessOf(const Process& process) { return ", process " + std::to_string(process.pid()); }

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
    CheckRefused(folder, command.front(), arguments, {" already has its ", ProcessOf(first) + " (", command.back()});
    if (command.front() == "rrhc_matcher") {
      folder.CheckRefused("hill_climber", arguments, " already has its matcher", 1);
    }
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
  folder.CheckRefused("run_stack", {"sim:demo", "--out", folder / "out", "--lcm-url", url},
                      "already has its owner of a map" + ProcessOf(updater), 1);
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
  const std::string taken = (folder / "one").string() + ": process " + std::to_string(one.pid());
  folder.CheckRefused("map_exporter", {"--lcm-url", MakeBusUrl(), "--out", folder / "one"}, taken, 1);
  folder.CheckRefused("slam_offline", {"sim:demo", "--out", folder / "one"}, taken, 1);
  folder.CheckRefused("run_stack", {"sim:demo", "--out", folder / "one", "--lcm-url", MakeBusUrl()}, taken, 1);
  CHECK(one.Interrupt() == 0);
  CHECK(two.Interrupt() == 0);
}
