// What each process was told stands in its SERVICE_STATUS and in summary.json.

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

TEST_CASE("the summary of a run of half a second tells what each process used, as each was told") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 20), "run.lcm");
  const std::string url = MakeBusUrl();
  Stack stack({.url = url,
               .out = folder / "out",
               .own_flags = {{"map_updater", {"--update-distance-m", "0.35"}},
                             {"rrhc_matcher", {"--seed", "9", "--no-odometry"}},
                             {"ray_selector", {"--rays-max", "70"}},
                             {"laser_publisher", {"--no-odometry"}}}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(log, "max"));
  CHECK(stack.Finish());

  const nlohmann::json used = folder.Summary("out")["parameters"];
  CAPTURE(used.dump(2));
  CHECK(used["rrhc_matcher"]["seed"] == 9);
  CHECK(used["rrhc_matcher"]["odometry"] == false);
  CHECK(used["rrhc_matcher"]["lockstep"] == true);
  CHECK(used["ray_selector"]["rays_max"] == 70);
  CHECK(used["map_updater"]["update_distance_m"] == 0.35);
  CHECK(used["laser_publisher"]["odometry"] == false);
  CHECK(used["laser_publisher"]["rate"] == "max");
  CHECK(used["map_exporter"]["out"] == (folder / "out").string());
  // Each tells what it uses, and nothing of the others'.
  CHECK_FALSE(used["map_exporter"].contains("seed"));
  CHECK_FALSE(used["ray_selector"].contains("odometry"));
  CHECK_FALSE(used["map_updater"].contains("odometry"));
  CHECK(used.size() == 6);
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
                  {"--lcm-url", url, "--channel-prefix", "robot1/", "--seed", "7", "--start", long_start},
                  folder / "log");
  REQUIRE(bus.Await([&] { return heard.num_parameters > 0; }));
  const auto Value = [&](const std::string& name) {
    const auto found = std::find(heard.parameter_name.begin(), heard.parameter_name.end(), name);
    REQUIRE(found != heard.parameter_name.end());
    return heard.parameter_value[static_cast<std::size_t>(found - heard.parameter_name.begin())];
  };
  CHECK(heard.name == "rrhc_matcher");
  CHECK(Value("seed") == "7");
  CHECK(Value("odometry") == "true");
  CHECK(Value("channel_prefix") == "robot1/");
  CHECK(Value("start") == long_start.substr(0, 1000) + "...");
  CHECK(num_bytes < 8192);
  CHECK(num_others == 0);
}
