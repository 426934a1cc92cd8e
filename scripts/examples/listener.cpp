// Prints the robot's pose from POSE: x y yaw, in metres and radians.
//
// usage: example_listener

#include <bot_core/pose_t.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>

namespace {

struct Listener {
  void Show(const lcm::ReceiveBuffer*, const std::string&, const bot_core::pose_t* pose) {
    const double yaw_rad = 2.0 * std::atan2(pose->orientation[3], pose->orientation[0]);  // about the vertical alone
    std::printf("%.3f %.3f %.3f\n", pose->pos[0], pose->pos[1], yaw_rad);
    std::fflush(stdout);
  }
};

}  // namespace

int main() {
  lcm::LCM lcm;  // where LCM_DEFAULT_URL says
  if (!lcm.good()) {
    std::fputs("example_listener: no bus: is there a route for multicast?\n", stderr);
    return EXIT_FAILURE;
  }
  Listener listener;
  lcm.subscribe("POSE", &Listener::Show, &listener);
  while (lcm.handle() == 0) continue;
}
