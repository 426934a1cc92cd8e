// What each process was told stands in its SERVICE_STATUS and in summary.json.

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

nlohmann::json ReadSummary(const std::filesystem::path& out) {
  return nlohmann::json::parse(ReadFile(out / "summary.json"));
}

}  // namespace

TEST_CASE("the summary of a run of half a second tells what each process used, as each was told") {
  const TemporaryFolder folder;
  WriteScans(TakeScans("sim:demo", 20), folder / "run.lcm");
  const std::string url = MakeBusUrl();
  const auto Start = [&](const std::string& program, std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--lcm-url", url});
    return std::make_unique<Process>(program, flags, folder / "log");
  };
  const auto updater = Start("map_updater", {"--lockstep", "--update-distance-m", "0.35"});
  const auto matcher = Start("rrhc_matcher", {"--lockstep", "--num-evaluations", "1234", "--seed", "9", "--odometry"});
  const auto selector = Start("ray_selector", {"--method", "density"});
  const auto exporter = Start("map_exporter", {"--out", folder / "out"});
  for (const auto& process : {&updater, &matcher, &selector, &exporter}) REQUIRE((*process)->AwaitReady());
  const auto publisher = Start("laser_publisher", {folder / "run.lcm", "--rate", "max", "--odometry"});
  CHECK(publisher->AwaitExit() == 0);
  CHECK(exporter->Interrupt() == 0);

  const nlohmann::json used = ReadSummary(folder / "out")["parameters"];
  CAPTURE(used.dump(2));
  CHECK(used["rrhc_matcher"]["num_evaluations"] == 1234);
  CHECK(used["rrhc_matcher"]["seed"] == 9);
  CHECK(used["rrhc_matcher"]["odometry"] == true);
  CHECK(used["rrhc_matcher"]["lockstep"] == true);
  CHECK(used["rrhc_matcher"]["climb"] == "shrinking");
  CHECK(used["rrhc_matcher"]["window_m"] == 0.4);
  CHECK(used["ray_selector"]["method"] == "density");
  CHECK(used["map_updater"]["update_distance_m"] == 0.35);
  CHECK(used["laser_publisher"]["odometry"] == true);
  CHECK(used["laser_publisher"]["rate"] == "max");
  CHECK(used["map_exporter"]["out"] == (folder / "out").string());
  // Each tells what it uses, and nothing of the others'.
  CHECK_FALSE(used["map_exporter"].contains("seed"));
  CHECK_FALSE(used["ray_selector"].contains("num_evaluations"));
  CHECK_FALSE(used["map_updater"].contains("odometry"));
  CHECK(used.size() == 5);
}

TEST_CASE("slam_offline tells all that it used") {
  const TemporaryFolder folder;
  WriteScans(TakeScans("sim:demo", 3), folder / "run.lcm");
  REQUIRE(Run("slam_offline", {folder / "run.lcm", "--out", folder / "out", "--seed", "5", "--range-max-m", "20"},
              folder / "log") == 0);
  const nlohmann::json used = ReadSummary(folder / "out")["parameters"];
  REQUIRE(used.size() == 1);
  CHECK(used["slam_offline"]["seed"] == 5);
  CHECK(used["slam_offline"]["range_max_m"] == 20.0);
  CHECK(used["slam_offline"]["odometry"] == false);
  CHECK(used["slam_offline"]["cell_size_m"] == 0.05);
  CHECK(used["slam_offline"]["out"] == (folder / "out").string());
}

TEST_CASE("each process has a channel of its own for its status, which holds its parameters and stays small") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  TestBus bus(url, "robot1/");
  service_status_t heard{};
  std::size_t num_bytes = 0;
  bus->Subscribe<service_status_t>("SERVICE_STATUS/rrhc_matcher", [&](const service_status_t& status) {
    heard = status;
    num_bytes = Encode(status).size();
  });
  int num_others = 0;
  bus->Subscribe<service_status_t>("SERVICE_STATUS/ray_selector", [&](const service_status_t&) { ++num_others; });
  const std::string long_start = "1.5,2,0." + std::string(5000, '0');
  Process matcher("rrhc_matcher",
                  {"--lcm-url", url, "--channel-prefix", "robot1/", "--wide-window-m", "0.7", "--start", long_start},
                  folder / "log");
  REQUIRE(bus.Await([&] { return heard.num_parameters > 0; }));
  const auto Value = [&](const std::string& name) {
    const auto found = std::find(heard.parameter_name.begin(), heard.parameter_name.end(), name);
    REQUIRE(found != heard.parameter_name.end());
    return heard.parameter_value[static_cast<std::size_t>(found - heard.parameter_name.begin())];
  };
  CHECK(heard.name == "rrhc_matcher");
  CHECK(Value("wide_window_m") == "0.7");
  CHECK(Value("velocity_model") == "true");
  CHECK(Value("channel_prefix") == "robot1/");
  CHECK(Value("start") == long_start.substr(0, 1000) + "...");
  CHECK(num_bytes < 8192);
  CHECK(num_others == 0);
}
