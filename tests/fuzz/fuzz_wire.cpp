// Every decoder: what it takes can be written again, and has the size that it had. And those of foreign lasers, and
// what is said of messages that are refused.

#include <cstdlib>

#include "input.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/message_types.hpp"
#include "services/wire/pose_types.hpp"
#include "services/wire/wire.hpp"

namespace crsm {
namespace {

template <class... Messages>
void DecodeAsEach(std::span<const std::uint8_t> bytes) {
  const auto Try = [&]<class Message>(const std::optional<Message>& message) {
    if (message && static_cast<std::size_t>(message->getEncodedSize()) != bytes.size()) std::abort();
  };
  (Try(Decode<Messages>(bytes)), ...);
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  DecodeAsEach<bot_core::planar_lidar_t, sweep_t, bot_core::pose_t, critical_rays_t, scan_match_t, tracking_state_t,
               map_delta_t, map_page_t, map_request_t, scan_request_t, scan_answer_t, keyframe_t, keyframe_request_t,
               pose_graph_t, service_status_t, journal_head_t, journal_check_t, changes_t, fleet_pose_t,
               fleet_keyframe_t, mark_t, kept_mark_t, robot_marks_t, fleet_marks_t>({data, size});
  DescribeRefusedLaser({data, size});
  DecodePose({data, size});
  LaserMessageOptions counter_clockwise;
  counter_clockwise.botlab_clockwise = false;
  for (const auto& [fingerprint, type] : LaserTypes()) {
    type.decode({data, size}, {});
    type.decode({data, size}, counter_clockwise);
  }
  return 0;
}
