// What an mbot's own programs hear of us.

#include <mbot_lcm_msgs/occupancy_grid_t.hpp>
#include <mbot_lcm_msgs/pose2D_t.hpp>

#include "catch.hpp"
#include "common/logs/read_map.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

/// As an mbot's program hears, with LCM's own decoder.
class Mbot {
 public:
  explicit Mbot(const std::string& url) : lcm_(url + "&recv_buf_size=2097152") {
    lcm_.subscribe("SLAM_POSE", &Mbot::HearPose, this)->setQueueCapacity(0);  // none is left out on a busy machine
    lcm_.subscribe("SLAM_MAP", &Mbot::HearMap, this)->setQueueCapacity(0);
  }

  bool Await(const std::function<bool()>& condition) {
    return WaitUntil([&] {
      while (lcm_.handleTimeout(20) > 0) continue;
      return condition();
    });
  }

  std::vector<mbot_lcm_msgs::pose2D_t> poses;
  std::vector<mbot_lcm_msgs::occupancy_grid_t> maps;

 private:
  void HearPose(const lcm::ReceiveBuffer*, const std::string&, const mbot_lcm_msgs::pose2D_t* pose) {
    poses.push_back(*pose);
  }
  void HearMap(const lcm::ReceiveBuffer*, const std::string&, const mbot_lcm_msgs::occupancy_grid_t* map) {
    maps.push_back(*map);
  }

  lcm::LCM lcm_;
};

}  // namespace

TEST_CASE("with mbot_publisher an mbot's programs hear each pose, and the map as it is drawn") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  const std::vector<LaserScan> scans = TakeScans("sim:corridor", 100);
  const std::string log = folder.Write(scans, "run.lcm");
  Mbot mbot(url);
  Stack stack({url, folder / "out", {}});
  REQUIRE(stack.StartServices());
  Process publisher("mbot_publisher", {"--lcm-url", url}, folder / "log");
  REQUIRE(publisher.AwaitReady());
  REQUIRE(stack.StartPublisher(log, "max"));
  REQUIRE(mbot.Await([&] { return !mbot.poses.empty() && mbot.poses.back().utime == scans.back().utime; }));
  // The map comes again when nothing is new, for who starts late: after the last pose, all of it is there.
  const std::size_t num_maps = mbot.maps.size();
  REQUIRE(mbot.Await([&] { return mbot.maps.size() >= num_maps + 2; }));
  CHECK(publisher.Interrupt() == 0);
  REQUIRE(stack.Finish());

  CHECK(mbot.poses.size() == scans.size());
  const DenseGrid expected = ReadMap(folder / "out");
  const mbot_lcm_msgs::occupancy_grid_t& map = mbot.maps.back();
  CHECK(map.utime == scans.back().utime);
  CHECK(map.width == expected.width_cells);
  CHECK(map.height == expected.height_cells);
  CHECK(map.origin_x == Approx(expected.origin_x_cells * 0.05));
  CHECK(map.origin_y == Approx(expected.origin_y_cells * 0.05));
  CHECK(map.meters_per_cell == Approx(0.05));
  REQUIRE(map.cells.size() == expected.cells.size());
  std::size_t num_wrong = 0;
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    num_wrong += map.cells[i] != std::max(-127, 127 - expected.cells[i]);
  }
  CHECK(num_wrong == 0);
  const std::string trajectory = ReadFile(folder / "out/trajectory.tum");
  const std::string last_line = trajectory.substr(trajectory.rfind('\n', trajectory.size() - 2) + 1);
  double t_s = 0.0, x_m = 0.0, y_m = 0.0;
  REQUIRE(std::sscanf(last_line.c_str(), "%lf %lf %lf", &t_s, &x_m, &y_m) == 3);
  CHECK(mbot.poses.back().x == Approx(x_m).margin(1e-5));
  CHECK(mbot.poses.back().y == Approx(y_m).margin(1e-5));
}
