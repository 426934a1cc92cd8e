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
inline constexpr const char* kLaserChannel = "LASER";                 // bot_core.planar_lidar_t
inline constexpr const char* kOdometryChannel = "ODOMETRY";           // bot_core.pose_t, of a scan, before it
inline constexpr const char* kCriticalRaysChannel = "CRITICAL_RAYS";  // crsm.critical_rays_t
inline constexpr const char* kScanMatchChannel = "SCAN_MATCH";        // crsm.scan_match_t
inline constexpr const char* kPoseChannel = "POSE";                   // bot_core.pose_t
inline constexpr const char* kTruePoseChannel = "TRUE_POSE";          // bot_core.pose_t, of simulated worlds
inline constexpr const char* kMapDeltaChannel = "MAP_DELTA";          // crsm.map_delta_t
inline constexpr const char* kMapRequestChannel = "MAP_REQUEST";      // crsm.map_request_t
// crsm.service_status_t, a channel for each process: so each has a row of its own in lcm-spy.
inline std::string ServiceStatusChannel(const std::string& process) { return "SERVICE_STATUS/" + process; }
inline constexpr const char* kEveryServiceStatus = "SERVICE_STATUS/*";
// On which no laser can be.
inline constexpr const char* kChannelsOfStack[]{kOdometryChannel, kCriticalRaysChannel, kScanMatchChannel, kPoseChannel,
                                                kTruePoseChannel, kMapDeltaChannel,     kMapRequestChannel};
// In journals only.
inline constexpr const char* kJournalHeadChannel = "JOURNAL_HEAD";    // crsm.journal_head_t, the first event
inline constexpr const char* kJournalCheckChannel = "JOURNAL_CHECK";  // crsm.journal_check_t, behind each stretch

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
  using Refused = std::function<void(std::span<const std::uint8_t>)>;

  /// url: empty for LCM's default. Throws in one line: UsageError if it is of no bus, std::runtime_error if the bus
  /// cannot be reached.
  Bus(std::string url, const std::string& channel_prefix, Counters& counters,
      Reception reception = Reception::kByHandler);

  /// Calls `handler` for each well-formed message; others are counted as CHANNEL_malformed and dropped. An exception
  /// that leaves the handler is counted as handler_failed; its text is said on stderr, the first time. A channel that
  /// ends in * stands for all whose names begin so. `refused`, if given, is called with the bytes of malformed ones.
  template <class Message>
  void Subscribe(const std::string& channel, std::function<void(const Message&)> handler, Refused refused = {}) {
    const std::string counter = channel.substr(0, channel.find_last_not_of("/*") + 1) + "_malformed";
    SubscribeRaw(channel, [this, counter, handler = std::move(handler),
                           refused = std::move(refused)](std::span<const std::uint8_t> bytes) {
      if (const auto message = Decode<Message>(bytes)) {
        handler(*message);
      } else {
        counters_.Add(counter);
        if (refused) refused(bytes);
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

  /// Where this bus is, if it is one by UDP multicast.
  const std::optional<MulticastAddress>& multicast() const { return multicast_; }
  const std::string& prefix() const { return prefix_; }

 private:
  struct Subscription {
    std::string channel;
    std::function<void(std::span<const std::uint8_t>)> handler;
    Counters* counters;
    bool failed_before = false;
    bool Takes(std::string_view heard) const;
    void Handle(std::span<const std::uint8_t> bytes);
    void HandleLcm(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  };

  void SubscribeRaw(const std::string& channel, std::function<void(std::span<const std::uint8_t>)> handler);
  void FilterSockets();
  bool HandleWhole(int timeout_ms);
  void CountUnpublished(const std::string& channel, int error);

  std::string url_;
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
