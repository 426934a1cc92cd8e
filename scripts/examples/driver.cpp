// An example of a laser driver: see kHelp.

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <thread>

namespace {

constexpr const char* kHelp =
    "An example of a laser driver: it publishes scans on LASER as bot_core.planar_lidar_t, ten a second.\n"
    "It has no device: it simulates a room of 6 x 4 m, in which the laser turns on the spot by 0.2 rad/s.\n"
    "\n"
    "usage: example_driver [NUMBER OF SCANS]\n"
    "Without a number it goes on until Ctrl-C. LCM_DEFAULT_URL in the environment names the bus.\n";

constexpr double kPi = 3.14159265358979323846;
constexpr int kBeams = 360;
constexpr double kRate_hz = 10.0;
constexpr double kTurn_rad_s = 0.2;

/// From a place 1.5 m left and 0.7 m below the middle of the room [m].
double RangeToWall(double heading_rad) {
  const double x = std::cos(heading_rad);
  const double y = std::sin(heading_rad);
  const double to_side_m = (x > 0.0 ? 3.0 + 1.5 : 3.0 - 1.5) / std::max(std::abs(x), 1e-9);
  const double to_end_m = (y > 0.0 ? 2.0 + 0.7 : 2.0 - 0.7) / std::max(std::abs(y), 1e-9);
  return std::min(to_side_m, to_end_m);
}

bot_core::planar_lidar_t ScanAt(double yaw_rad) {
  using namespace std::chrono;
  bot_core::planar_lidar_t scan{};
  // Each scan needs one of its own.
  scan.utime = duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
  scan.rad0 = static_cast<float>(-kPi);  // radians, counter-clockwise from straight ahead
  scan.radstep = static_cast<float>(2.0 * kPi / kBeams);
  scan.nranges = kBeams;
  for (int i = 0; i < kBeams; ++i) {  // metres; 0: no return
    const double angle_rad = scan.rad0 + i * static_cast<double>(scan.radstep);
    scan.ranges.push_back(static_cast<float>(RangeToWall(yaw_rad + angle_rad)));
  }
  return scan;
}

}  // namespace

int main(int argc, char** argv) {
  const bool asks = argc == 2 && std::strcmp(argv[1], "--help") == 0;
  const long num_scans = argc > 1 ? std::atol(argv[1]) : std::numeric_limits<long>::max();
  if (argc > 2 || num_scans < 1) {
    std::fputs(kHelp, asks ? stdout : stderr);
    return asks ? EXIT_SUCCESS : 2;
  }
  lcm::LCM lcm;  // where LCM_DEFAULT_URL says
  if (!lcm.good()) {
    std::fputs("example_driver: no bus: is there a route for multicast?\n", stderr);
    return EXIT_FAILURE;
  }
  for (long number = 0; number < num_scans; ++number) {
    const bot_core::planar_lidar_t scan = ScanAt(kTurn_rad_s * static_cast<double>(number) / kRate_hz);
    lcm.publish("LASER", &scan);
    std::this_thread::sleep_for(std::chrono::duration<double>(1.0 / kRate_hz));
  }
}
