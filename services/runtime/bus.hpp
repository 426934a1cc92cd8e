#pragma once

#include <cerrno>
#include <deque>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/runtime/multicast_socket.hpp"
#include "services/runtime/sole_sender.hpp"
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

/// Who takes messages out of the kernel's buffer.
enum class Reception {
  kByHandler,  ///< the thread that handles them, at the least cost: for those that handle messages all the time
  kByThread    ///< a thread of LCM, at once: for those that are busy with other things for long
};

/// The thin seam over LCM: checked messages in, messages out, no exception into C code.
class Bus {
 public:
  /// url: empty for LCM's default. Throws std::runtime_error in one line if the bus cannot be reached.
  Bus(std::string url, const std::string& channel_prefix, Counters& counters,
      Reception reception = Reception::kByHandler);

  /// Calls `handler` for each well-formed message; others are counted as CHANNEL_malformed and dropped. An exception
  /// that leaves the handler is counted as handler_failed; its text is said on stderr, the first time.
  template <class Message>
  void Subscribe(const char* channel, std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, MakeRawHandler(channel, std::move(handler)));
  }

  /// The same on a channel on which one process alone has something to say. What comes from another one is counted as
  /// CHANNEL_refused and dropped, and said on stderr, the first time; see SoleSender. By UDP multicast only, and where
  /// the kernel gives as large a buffer as the URL asks for: else all senders are the same, and senders_unknown counts.
  template <class Message>
  void SubscribeToOne(const char* channel, std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, MakeRawHandler(channel, std::move(handler)));
    subscriptions_.back()->sole_sender.emplace();
    if (!own_socket_) counters_.Add("senders_unknown");
  }

  /// Who sent the message that is being handled.
  const Sender& sender() const { return sender_; }

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
  using RawHandler = std::function<void(std::span<const std::uint8_t>)>;
  struct HeldMessage {
    Sender sender;
    std::vector<std::uint8_t> bytes;
  };
  struct Subscription {
    std::string channel;
    RawHandler handler;
    Bus* bus;
    bool failed_before = false;
    std::optional<SoleSender> sole_sender = {};  ///< who is to be believed, where it is not everybody
    std::deque<HeldMessage> held = {};           ///< until it is decided
    bool refused_before = false;

    void Receive(const Sender& sender, std::span<const std::uint8_t> bytes);
    void ReceiveFromLcm(const lcm::ReceiveBuffer* buffer, const std::string& channel);
    void DecideHeld();
    void Refuse(const Sender& sender);
    void Handle(const Sender& sender, std::span<const std::uint8_t> bytes);
  };

  template <class Message>
  RawHandler MakeRawHandler(const char* channel, std::function<void(const Message&)> handler) {
    return [this, channel, handler = std::move(handler)](std::span<const std::uint8_t> bytes) {
      if (const auto message = Decode<Message>(bytes)) {
        handler(*message);
      } else {
        counters_.Add(std::string(channel) + "_malformed");
      }
    };
  }

  void SubscribeRaw(const char* channel, RawHandler handler);
  void FilterSockets();
  void Receive(int timeout_ms);
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
  Sender sender_;                                ///< of the message that is being handled
};

}  // namespace crsm
