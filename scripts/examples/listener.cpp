// An example of a listener: see kHelp.

#include <bot_core/pose_t.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <lcm/lcm-cpp.hpp>

namespace {

constexpr const char* kHelp =
    "Prints the robot's pose from POSE, until Ctrl-C: x y yaw, in metres and radians.\n"
    "\n"
    "usage: example_listener\n"
    "LCM_DEFAULT_URL in the environment names the bus.\n";

struct Listener {
  void Show(const lcm::ReceiveBuffer*, const std::string&, const bot_core::pose_t* pose) {
    const double yaw_rad = 2.0 * std::atan2(pose->orientation[3], pose->orientation[0]);  // about the vertical alone
    std::printf("%.3f %.3f %.3f\n", pose->pos[0], pose->pos[1], yaw_rad);
    std::fflush(stdout);
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) {
    const bool asks = argc == 2 && std::strcmp(argv[1], "--help") == 0;
    std::fputs(kHelp, asks ? stdout : stderr);
    return asks ? EXIT_SUCCESS : 2;
  }
  lcm::LCM lcm;  // where LCM_DEFAULT_URL says
  if (!lcm.good()) {
    std::fputs("example_listener: no bus: is there a route for multicast?\n", stderr);
    return EXIT_FAILURE;
  }
  Listener listener;
  lcm.subscribe("POSE", &Listener::Show, &listener);
  while (lcm.handle() == 0) continue;
}
