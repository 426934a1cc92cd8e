#pragma once

#include <cerrno>
#include <chrono>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/base/line_limit.hpp"
#include "services/base/status.hpp"
#include "services/bus/bus_role.hpp"
#include "services/bus/multicast_sender.hpp"
#include "services/bus/multicast_socket.hpp"
#include "services/bus/sole_sender.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// What tells the bus of a URL from others on this machine: "port 7667", since LCM heeds nothing else of a multicast
/// address, or the whole URL of a server. Throws UsageError where the URL is of no bus.
std::string NameBus(const std::string& url);

/// Throws, in one line, where no Bus can be made of a URL: UsageError if it is of no bus, std::runtime_error if there
/// is no route for multicast.
void CheckBus(const std::string& url);

/// The URL as LCM is to see it: checked, because LCM turns some mistakes into another transport in silence, and with
/// the receive buffer that it asks for only when told. Empty: LCM's default. Throws UsageError where it is of no bus.
std::string CompleteUrl(std::string url);

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
  Bus(const std::string& url, const std::string& channel_prefix, Counters& counters,
      Reception reception = Reception::kByHandler);

  /// Calls `handler` for each well-formed message; others are counted as CHANNEL_malformed and dropped. An exception
  /// that leaves the handler is counted as handler_failed; its text is said on stderr, the first time. A channel that
  /// ends in * stands for all whose names begin so.
  template <class Message>
  void Subscribe(const std::string& channel, std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, MakeRawHandler(channel, std::move(handler)));
  }
  /// The same of another channel prefix than this bus has.
  template <class Message>
  void SubscribeOf(const std::string& prefix, const std::string& channel, std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, MakeRawHandler(prefix + channel, std::move(handler)), prefix);
  }

  /// The same of messages of whatever type: `handler` returns whether they are well-formed.
  void SubscribeBytes(const std::string& channel, std::function<bool(std::span<const std::uint8_t>)> handler);

  /// The same on a channel on which one process alone has something to say, the one that has the channel's role. What
  /// comes from another one is counted as CHANNEL_refused and dropped, and said on stderr, the first time; see
  /// SoleSender. A change from one sender to the next is counted as CHANNEL_sender_changed and said. By UDP multicast
  /// only, and where the kernel gives as large a buffer as the URL asks for: else all senders are the same, and
  /// senders_unknown counts.
  template <class Message>
  void SubscribeToOne(const char* channel, const char* role, std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, MakeRawHandler(channel, std::move(handler)));
    BelieveOnly(prefix_, role);
  }
  /// The same of another channel prefix than this bus has.
  template <class Message>
  void SubscribeToOneOf(const std::string& prefix, const char* channel, const char* role,
                        std::function<void(const Message&)> handler) {
    SubscribeRaw(channel, MakeRawHandler(prefix + channel, std::move(handler)), prefix);
    BelieveOnly(prefix, role);
  }

  /// Who sent the message that is being handled.
  const Sender& sender() const { return sender_; }
  /// Whether a sender is known to be the process that has a role on this bus.
  bool HasRole(const Sender& sender, const char* role) const { return FindHolder(role, sender) == RoleHolder::kSender; }
  /// Who has a role on this bus, for a sender.
  RoleHolder FindHolder(const char* role, const Sender& sender) const {
    return FindRole({url_, prefix_}, role, sender);
  }
  /// Whether a message is to be believed that only who has a role may send: from this host only its holder, as far as
  /// that can be told. Of other hosts the roles are not known.
  bool MayHaveRole(const Sender& sender, const char* role) const;

  /// A message that LCM cannot send is counted as publish_failed; why is said on stderr, the first time.
  template <class Message>
  void Publish(const char* channel, const Message& message) {
    PublishOf(prefix_, channel, message);
  }
  /// The same with another channel prefix than this bus has.
  template <class Message>
  void PublishOf(const std::string& prefix, const char* channel, const Message& message) {
    const std::string name = prefix + channel;
    const int size = message.getEncodedSize();
    if (own_sender_ && MulticastSender::Fits(name, static_cast<std::size_t>(size))) {
      message.encode(own_sender_->Add(name, static_cast<std::size_t>(size)).data(), 0, size);
      own_sender_channel_ = channel;
      return gathers_ ? void() : Send();
    }
    errno = 0;
    if (lcm_.publish(name, &message) != 0) CountUnpublished(channel, errno);
  }

  /// Sends at once what `publish` publishes, by Publish.
  void Together(const std::function<void()>& publish);

  /// Handles the messages that are there, 1000 at most, waiting for the first no longer than `timeout_ms`. Throws
  /// std::runtime_error if the bus is gone.
  void Wait(int timeout_ms);

  /// Where this bus is, if it is one by UDP multicast.
  const std::optional<MulticastAddress>& multicast() const { return multicast_; }
  const std::string& prefix() const { return prefix_; }

 private:
  using RawHandler = std::function<void(std::span<const std::uint8_t>)>;
  struct Subscription {
    std::string channel;
    std::string name;  ///< in counters: the channel without the prefix of this bus
    RawHandler handler;
    Bus* bus;
    bool failed_before = false;
    std::optional<SoleSender> sole_sender = {};  ///< who is to be believed, where it is not everybody
    bool refused_before = false;
    LineLimit changes = {};  ///< of the sender

    bool Takes(std::string_view heard) const;
    void Receive(const Sender& sender, std::span<const std::uint8_t> bytes);
    void ReceiveFromLcm(const lcm::ReceiveBuffer* buffer, const std::string& channel);
    void Refuse(const Sender& sender);
    void SayChanged(const Sender& sender);
    void Handle(const Sender& sender, std::span<const std::uint8_t> bytes);
  };

  template <class Message>
  RawHandler MakeRawHandler(const std::string& channel, std::function<void(const Message&)> handler) {
    return
        [this, counter = MalformedCounter(channel), handler = std::move(handler)](std::span<const std::uint8_t> bytes) {
          if (const auto message = Decode<Message>(bytes)) {
            handler(*message);
          } else {
            counters_.Add(counter);
          }
        };
  }

  static std::string MalformedCounter(const std::string& channel) {
    return channel.substr(0, channel.find_last_not_of("/*") + 1) + "_malformed";
  }

  /// prefix: nothing for that of this bus.
  void SubscribeRaw(const std::string& channel, RawHandler handler, const std::optional<std::string>& prefix = {});
  void BelieveOnly(const std::string& prefix, const char* role);
  void FilterSockets();
  void AwaitAny(int timeout_ms);
  void HandleWhole();
  void Send();
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
  std::unique_ptr<MulticastSender> own_sender_;  ///< the same of what is sent
  std::string own_sender_channel_;               ///< of what it was given last
  bool gathers_ = false;                         ///< what is published is sent later
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_look_at_lcm_{};  ///< for fragments, where none came for a while
  Clock::time_point fragments_until_{};   ///< some came, and more may
  Sender sender_;                         ///< of the message that is being handled
};

}  // namespace crsm
