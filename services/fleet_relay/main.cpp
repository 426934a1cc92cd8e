// fleet_relay: stands between the bus of one robot, which does not leave its host, and the network of a fleet. What
// fleet_mapper needs of the robot goes out, and what it asks for comes in: nothing else. So the robot's own processes
// never wait for the network, and hear nothing of it.

#include <fmt/format.h>

#include <chrono>

#include "services/base/usage_error.hpp"
#include "services/bus/service.hpp"

namespace crsm {
namespace {

class FleetRelay {
 public:
  FleetRelay(const CommandLine& command_line, const std::string& fleet_url)
      : service_(command_line),
        network_(fleet_url, command_line.settings().channel_prefix, service_.counters()),
        owner_({fleet_url, command_line.settings().channel_prefix}, kMapOwnerRole),
        loop_closer_({fleet_url, command_line.settings().channel_prefix}, kLoopCloserRole) {
    Bus& robot = service_.bus();
    robot.SubscribeToOne<keyframe_t>(kKeyframeChannel, kMapOwnerRole,
                                     [this](const keyframe_t& message) { Send(kKeyframeChannel, message); });
    robot.SubscribeToOne<pose_graph_t>(kPoseGraphChannel, kLoopCloserRole, [this](const pose_graph_t& message) {
      if (message.part == 0) Send(kPoseGraphChannel, WithoutPoses(message));
    });
    robot.SubscribeToOne<robot_marks_t>(kRobotMarksChannel, kMapOwnerRole,
                                        [this](const robot_marks_t& message) { Send(kRobotMarksChannel, message); });
    robot.Subscribe<service_status_t>(ServiceStatusChannel("map_updater"), [this](const service_status_t& message) {
      Send(ServiceStatusChannel("map_updater").c_str(), Shorten(message));
    });
    robot.Subscribe<bot_core::pose_t>(kPoseChannel, [this](const bot_core::pose_t& message) {
      constexpr auto kPeriod = std::chrono::milliseconds(500);  // to be looked at
      if (Clock::now() < next_pose_) return;
      next_pose_ = Clock::now() + kPeriod;
      Send(kPoseChannel, message);
    });
    network_.Subscribe<keyframe_request_t>(kKeyframeRequestChannel, [this](const keyframe_request_t& message) {
      service_.counters().Add("requests");
      service_.bus().Publish(kKeyframeRequestChannel, message);
    });
  }

  void Run() {
    constexpr int kPeriod_ms = 10;
    service_.Run(
        [this] {
          network_.Wait(0);
          owner_.DismissVisitors();
          loop_closer_.DismissVisitors();
          return true;
        },
        kPeriod_ms);
  }

 private:
  template <class Message>
  void Send(const char* channel, const Message& message) {
    service_.counters().Add("sent");
    service_.counters().Add("sent_bytes", message.getEncodedSize());
    service_.SetState("relaying");
    network_.Publish(channel, message);
  }

  /// The common map has poses of its own: what was found is all that it needs.
  static pose_graph_t WithoutPoses(pose_graph_t message) {
    message.num_moved = 0;
    message.moved.clear();
    message.num_parts = 1;
    return message;
  }

  /// That it lives.
  static service_status_t Shorten(service_status_t message) {
    message.num_counters = message.num_parameters = 0;
    message.counter_name.clear();
    message.counter_value.clear();
    message.parameter_name.clear();
    message.parameter_value.clear();
    return message;
  }

  Service service_;
  Bus network_;
  // In the robot's place, on the network.
  BusRole owner_;
  BusRole loop_closer_;
  Clock::time_point next_pose_{};
};

}  // namespace
}  // namespace crsm

int main(int argc, char** argv) {
  crsm::CommandLine command_line(
      "fleet_relay",
      "Passes on what fleet_mapper needs of a robot from the robot's bus to the network of "
      "the fleet, and what it asks for back: KEYFRAME, POSE_GRAPH, ROBOT_MARKS, POSE; KEYFRAME_REQUEST.",
      crsm::FlagsOfFleetRelay());
  std::string fleet_url;
  command_line.AddOption("--fleet-url", fleet_url,
                         "URL of the fleet's LCM bus, on another port than the robot's: "
                         "udpm://239.255.76.67:7668?ttl=1");
  if (const auto exit_code = command_line.Parse(argc, argv)) return *exit_code;
  return crsm::RunMain(command_line.program(), [&] {
    if (fleet_url.empty()) throw crsm::UsageError("--fleet-url: is missing: give the URL of the fleet's bus");
    if (crsm::NameBus(fleet_url) == crsm::NameBus(command_line.settings().lcm_url)) {
      throw crsm::UsageError(fmt::format("--fleet-url {}: is the robot's own bus: give it another port", fleet_url));
    }
    crsm::FleetRelay(command_line, fleet_url).Run();
  });
}
