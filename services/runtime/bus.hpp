#pragma once

#include <cerrno>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/runtime/multicast_socket.hpp"
#include "services/runtime/status.hpp"
#include "services/runtime/wire.hpp"

namespace crsm {

// The channels, and what travels on them.
inline constexpr const char* kLaserChannel = "LASER";                   // bot_core.planar_lidar_t
inline constexpr const char* kOdometryChannel = "ODOMETRY";             // bot_core.pose_t, of a scan, before it
inline constexpr const char* kCriticalRaysChannel = "CRITICAL_RAYS";    // crsm.critical_rays_t
inline constexpr const char* kScanMatchChannel = "SCAN_MATCH";          // crsm.scan_match_t
inline constexpr const char* kPoseChannel = "POSE";                     // bot_core.pose_t
inline constexpr const char* kTruePoseChannel = "TRUE_POSE";            // bot_core.pose_t, of simulated worlds
inline constexpr const char* kMapDeltaChannel = "MAP_DELTA";            // crsm.map_delta_t
inline constexpr const char* kMapRequestChannel = "MAP_REQUEST";        // crsm.map_request_t
inline constexpr const char* kServiceStatusChannel = "SERVICE_STATUS";  // crsm.service_status_t
// In journals only: an empty crsm.map_delta_t, that says of which map the journal is, and whether it is a finished one.
inline constexpr const char* kMapEpochChannel = "MAP_EPOCH";
inline constexpr const char* kFinishedMapEpochChannel = "FINISHED_MAP_EPOCH";

/// What tells the bus of a URL from others on this machine: "port 7667", since LCM heeds nothing else of a multicast
/// address, or the whole URL of a server. Throws UsageError where the URL is of no bus.
std::string NameBus(const std::string& url);

/// Who takes messages out of the kernel's buffer.
enum class Reception {
  kByHandler,  ///< the thread that handles them, at the least cost: for those that handle messages all the time
  kByThread    ///< a thread of LCM, at once: for those that are busy with other things for long
};

/// The thin seam over LCM: checked messages in, messages out, no exception into C code.
class Bus {
 public:
  /// url: empty for LCM's default. Throws in one line: UsageError if it is of no bus, std::runtime_error if the bus
  /// cannot be reached.
  Bus(std::string url, const std::string& channel_prefix, Counters& counters,
      Reception reception = Reception::kByHandler);

  /// Calls `handler` for each well-formed message; others are counted as CHANNEL_malformed and dropped. An exception
  /// that leaves the handler is counted as handler_failed; its text is said on stderr, the first time.
  template <class Message>
  void Subscribe(const char* channel, std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, [this, channel, handler = std::move(handler)](std::span<const std::uint8_t> bytes) {
      if (const auto message = Decode<Message>(bytes)) {
        handler(*message);
      } else {
        counters_.Add(std::string(channel) + "_malformed");
      }
    });
  }

  /// A message that LCM cannot send is counted as publish_failed; why is said on stderr, the first time.
  template <class Message>
  void Publish(const char* channel, const Message& message) {
    errno = 0;
    if (lcm_.publish(prefix_ + channel, &message) != 0) CountUnpublished(channel, errno);
  }

  /// Handles the messages that are there, 1000 at most, waiting for the first no longer than `timeout_ms`. Throws
  /// std::runtime_error if the bus is gone.
  void Wait(int timeout_ms);

 private:
  struct Subscription {
    std::string channel;
    std::function<void(std::span<const std::uint8_t>)> handler;
    Counters* counters;
    bool failed_before = false;
    void Handle(std::span<const std::uint8_t> bytes);
    void HandleLcm(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  };

  void SubscribeRaw(const char* channel, std::function<void(std::span<const std::uint8_t>)> handler);
  void FilterSockets();
  bool HandleWhole(int timeout_ms);
  void CountUnpublished(const std::string& channel, int error);

  std::optional<MulticastAddress> multicast_;  ///< of a bus by UDP multicast
  lcm::LCM lcm_;
  std::string prefix_;
  Counters& counters_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::vector<std::string> channels_;            ///< subscribed to, with the prefix
  std::optional<int> lcm_socket_;                ///< on which LCM receives, if it is known
  std::unique_ptr<MulticastSocket> own_socket_;  ///< which leaves to LCM no more than fragments, if it is there
};

}  // namespace crsm
