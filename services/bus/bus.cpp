#include "services/bus/bus.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/math/parse_number.hpp"
#include "services/base/usage_error.hpp"
#include "services/bus/socket_filter.hpp"

namespace crsm {
namespace {

// Messages of one channel. LCM drops the newest of more, and does not say so: room for all that come while a stage
// works, or waits for a core, 0.15 s of 65,000 scans/s. Longer queues belong to the stages, which count what they drop.
constexpr int kQueueCapacity = 10000;
// Handled in one go: all that are there, so that what a stage works on is fresh; but who sends faster than they are
// read does not keep it from its work.
constexpr int kMostMessages = 1000;

/// What is before the first such character, and what is behind it, if it is there.
std::pair<std::string_view, std::optional<std::string_view>> SplitAt(std::string_view text, char separator) {
  const std::size_t at = text.find(separator);
  if (at == std::string_view::npos) return {text, std::nullopt};
  return {text.substr(0, at), text.substr(at + 1)};
}

/// Where a udpm:// URL leads, if LCM will take all of it as it is meant: it passes over options that it does not know
/// or cannot read.
std::optional<MulticastAddress> ParseMulticastUrl(std::string_view url) {
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) return std::nullopt;
  auto [place, options] = SplitAt(url.substr(kScheme.size()), '?');
  MulticastAddress address;
  if (!place.empty()) {
    const auto [group, port] = SplitAt(place, ':');
    address.group = group;
    in_addr parsed{};
    if (inet_pton(AF_INET, address.group.c_str(), &parsed) != 1 || !IN_MULTICAST(ntohl(parsed.s_addr))) {
      return std::nullopt;
    }
    if (port) address.port = ParseNumber<std::uint16_t>(*port).value_or(0);
  }
  while (options) {
    const auto [option, others] = SplitAt(*options, '&');
    const auto [key, value] = SplitAt(option, '=');
    const auto number = ParseNumber<int>(value.value_or(""));
    if ((key != "ttl" && key != "recv_buf_size") || !number || *number < 0) return std::nullopt;
    (key == "ttl" ? address.ttl : address.buffer_bytes) = *number;  // LCM takes the last one, too
    options = others;
  }
  return address.port > 0 ? std::optional(address) : std::nullopt;
}

/// LCM's own way to name a channel, or all that begin so: a regular expression.
std::string ToRegex(const std::string& channel) {
  const bool all_that_begin_so = channel.ends_with('*');
  const std::string text = all_that_begin_so ? channel.substr(0, channel.size() - 1) : channel;
  std::string escaped;
  for (const char c : text) {
    if (std::string("\\^$.|?*+()[]{}").find(c) != std::string::npos) escaped += '\\';
    escaped += c;
  }
  return all_that_begin_so ? escaped + ".*" : escaped;
}

/// What to say where LCM cannot open a bus. By multicast it finds out when it is made, by a server when it subscribes.
std::string WhyUnreachable(const std::string& url, bool multicast) {
  if (multicast) {
    return fmt::format("--lcm-url {}: no multicast route for LCM; as root: {}", url,
                       "ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo");
  }
  return fmt::format("--lcm-url {}: no LCM server answers there; is the address right, and does the server run?", url);
}

/// The socket that the first subscription has opened; none if that is not clear.
std::optional<int> FindNewSocket(int port, const std::set<int>& old_sockets) {
  std::set<int> sockets = FindUdpSockets(port);
  for (const int socket : old_sockets) sockets.erase(socket);
  return sockets.size() == 1 ? std::optional(*sockets.begin()) : std::nullopt;
}

/// LCM opens sockets and pipes when it first listens, and does not survive it where it cannot.
void CheckDescriptors() {
  constexpr std::size_t kOfLcm = 12;
  std::vector<int> opened;
  while (opened.size() < kOfLcm) {
    const int descriptor = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) break;
    opened.push_back(descriptor);
  }
  for (const int descriptor : opened) close(descriptor);
  if (opened.size() < kOfLcm) {
    throw std::runtime_error(
        fmt::format("the bus needs {} more open files than this process may have ({}): ulimit -n "
                    "allows more",
                    kOfLcm - opened.size(), std::strerror(EMFILE)));
  }
}

/// Whether packets to a bus have a way. LCM finds out in the same manner, but says it in ten lines.
bool HasRoute(const MulticastAddress& address) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(address.port));
  if (inet_pton(AF_INET, address.group.c_str(), &place.sin_addr) != 1) return true;  // LCM will say what is wrong
  const int visitor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (visitor < 0) return true;
  const bool has_route = connect(visitor, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  close(visitor);
  return has_route;
}

std::string PrepareUrl(const std::string& url) {
  CheckDescriptors();
  CheckBus(url);
  return CompleteUrl(url);
}

}  // namespace

std::string CompleteUrl(std::string url) {
  if (url.empty()) {
    const char* environment = std::getenv("LCM_DEFAULT_URL");
    url = environment && *environment ? environment : "udpm://239.255.76.67:7667?ttl=0";
  }
  const bool multicast = url.rfind("udpm://", 0) == 0;
  if (multicast ? !ParseMulticastUrl(url) : url.rfind("tcpq://", 0) != 0) {
    throw UsageError(
        fmt::format("--lcm-url {}: is no bus between processes; use one like udpm://239.255.76.67:7667?ttl=0 or "
                    "tcpq://localhost:7700",
                    url));
  }
  if (multicast && url.find("recv_buf_size") == std::string::npos) {
    url += (url.find('?') == std::string::npos ? "?" : "&") +
           fmt::format("recv_buf_size={}", MulticastAddress().buffer_bytes);
  }
  return url;
}

std::string NameBus(const std::string& url) {
  const std::string complete = CompleteUrl(url);
  const auto multicast = ParseMulticastUrl(complete);
  return multicast ? fmt::format("port {}", multicast->port) : complete;
}

void CheckBus(const std::string& url) {
  const std::string complete = CompleteUrl(url);
  const auto multicast = ParseMulticastUrl(complete);
  if (multicast && !HasRoute(*multicast)) throw std::runtime_error(WhyUnreachable(complete, true));
}

Bus::Bus(const std::string& url, const std::string& channel_prefix, Counters& counters, Reception reception)
    : url_(PrepareUrl(url)),
      multicast_(ParseMulticastUrl(url_)),
      lcm_(url_),
      prefix_(channel_prefix),
      counters_(counters) {
  if (!lcm_.good()) {
    throw std::runtime_error(WhyUnreachable(url_, multicast_.has_value()));
  }
  if (multicast_ && reception == Reception::kByHandler) own_socket_ = MulticastSocket::Open(*multicast_);
  if (multicast_) own_sender_ = MulticastSender::Open(*multicast_);
}

bool Bus::Subscription::Takes(std::string_view heard) const {
  if (!channel.ends_with('*')) return channel == heard;
  return heard.starts_with(std::string_view(channel).substr(0, channel.size() - 1));
}

void Bus::Subscription::ReceiveFromLcm(const lcm::ReceiveBuffer* buffer, const std::string&) {
  // LCM does not tell senders. Ours send whole messages, which come by the own socket; what LCM got before its socket
  // was filtered comes too early for anybody.
  if (sole_sender && bus->own_socket_) return bus->counters_.Add(name + "_unattributed");
  Receive({}, {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
}

void Bus::Subscription::Receive(const Sender& sender, std::span<const std::uint8_t> bytes) {
  using enum SoleSender::Verdict;
  const auto verdict = sole_sender ? sole_sender->Judge(sender, SoleSender::Clock::now()) : kBelieved;
  if (verdict == kRefused) return Refuse(sender);
  if (verdict == kChanged) SayChanged(sender);
  Handle(sender, bytes);
}

void Bus::Subscription::Refuse(const Sender& refused) {
  bus->counters_.Add(name + "_refused");
  if (std::exchange(refused_before, true)) return;
  fmt::print(stderr, "{} from {} is refused: another process sends it; stop one of the two\n", channel,
             refused.Describe());
}

void Bus::Subscription::SayChanged(const Sender& sender) {
  bus->counters_.Add(name + "_sender_changed");
  const auto line = changes.Pass(fmt::format("{} comes from another process now, {}: the one before has ended, or had "
                                             "not the role",
                                             channel, sender.Describe()),
                                 SoleSender::Clock::now());
  if (line) fmt::print(stderr, "{}\n", *line);
}

void Bus::Subscription::Handle(const Sender& sender, std::span<const std::uint8_t> bytes) {
  bus->sender_ = sender;
  try {
    handler(bytes);
  } catch (const std::bad_alloc&) {  // nothing is right from here on
    std::fputs("there is no memory left: the process ends\n", stderr);
    std::_Exit(EXIT_FAILURE);
  } catch (const std::exception& error) {  // would poison the LCM handle
    bus->counters_.Add("handler_failed");
    if (!std::exchange(failed_before, true))
      fmt::print(stderr, "cannot handle a message on {}: {}\n", channel, error.what());
  }
}

void Bus::SubscribeBytes(const std::string& channel, std::function<bool(std::span<const std::uint8_t>)> handler) {
  SubscribeRaw(channel, [this, counter = MalformedCounter(channel),
                         handler = std::move(handler)](std::span<const std::uint8_t> bytes) {
    if (!handler(bytes)) counters_.Add(counter);
  });
}

void Bus::BelieveOnly(const std::string& prefix, const char* role) {
  subscriptions_.back()->sole_sender.emplace([this, prefix, role](const Sender& sender) {
    return FindRole({url_, prefix}, role, sender);
  });
  if (!own_socket_) counters_.Add("senders_unknown");
}

void Bus::SubscribeRaw(const std::string& channel, RawHandler handler, const std::optional<std::string>& prefix) {
  const std::string whole = prefix.value_or(prefix_) + channel;

  const bool first = channels_.empty();
  const std::set<int> sockets_of_others = first && multicast_ ? FindUdpSockets(multicast_->port) : std::set<int>();
  subscriptions_.push_back(
      std::make_unique<Subscription>(Subscription{whole, prefix.value_or("") + channel, std::move(handler), this}));
  lcm::Subscription* subscription =
      lcm_.subscribe(ToRegex(whole), &Subscription::ReceiveFromLcm, subscriptions_.back().get());
  if (!subscription || lcm_.getFileno() < 0) {
    throw std::runtime_error(WhyUnreachable(url_, multicast_.has_value()));
  }
  subscription->setQueueCapacity(kQueueCapacity);
  if (first && multicast_) lcm_socket_ = FindNewSocket(multicast_->port, sockets_of_others);
  channels_.push_back(whole);
  if (multicast_) FilterSockets();
}

/// LCM's socket lets through what the other does not, so that nothing is heard twice. Without filters, and without that
/// other socket, everything works as well, at a price.
void Bus::FilterSockets() {
  const Hosts hosts = HostsHeardAt(multicast_->ttl);
  if (own_socket_ && lcm_socket_ &&
      AttachFilter(*lcm_socket_, MakeChannelFilter(channels_, {Packets::kFragments, hosts})) &&
      own_socket_->Listen(channels_)) {
    return;
  }
  own_socket_.reset();
  if (!lcm_socket_ || !AttachFilter(*lcm_socket_, MakeChannelFilter(channels_, {Packets::kBoth, hosts}))) {
    counters_.Add("socket_unfiltered");
  }
}

bool Bus::MayHaveRole(const Sender& sender, const char* role) const {
  if (!sender.known()) return true;
  const RoleHolder holder = FindHolder(role, sender);
  return holder == RoleHolder::kSender || holder == RoleHolder::kUnknown ||
         (holder == RoleHolder::kNobody && !IsOfThisHost(sender));
}

void Bus::Together(const std::function<void()>& publish) {
  const auto Finish = [this](bool* gathers) {
    *gathers = false;
    if (own_sender_) Send();
  };
  gathers_ = true;
  const std::unique_ptr<bool, decltype(Finish)> finish(&gathers_, Finish);  // also where something is thrown
  publish();
}

void Bus::Send() {
  if (const int error = own_sender_->Flush(); error != 0) CountUnpublished(own_sender_channel_, error);
}

void Bus::CountUnpublished(const std::string& channel, int error) {
  if (counters_.counts().count("publish_failed") == 0) {
    fmt::print(stderr, "LCM cannot publish on {}{}\n", prefix_ + channel,
               error != 0 ? fmt::format(": {}", std::strerror(error)) : "");
  }
  counters_.Add("publish_failed");
}

void Bus::Wait(int timeout_ms) {
  constexpr auto kSeldom = std::chrono::milliseconds(20);
  constexpr auto kFragmentsGoOn = std::chrono::seconds(10);
  if (own_socket_) {
    AwaitAny(timeout_ms);
    HandleWhole();
    const auto now = Clock::now();
    if (now < next_look_at_lcm_ && now >= fragments_until_) return;
    next_look_at_lcm_ = now + kSeldom;
    timeout_ms = 0;
  }
  errno = 0;
  int handled = lcm_.handleTimeout(timeout_ms);
  if (handled > 0) fragments_until_ = Clock::now() + kFragmentsGoOn;
  for (int i = 1; handled > 0 && i < kMostMessages; ++i) handled = lcm_.handleTimeout(0);
  if (handled < 0 && errno != EINTR) throw std::runtime_error("the bus is gone: LCM cannot receive messages any more");
}

/// Waits for a message on the own socket; where others come in fragments, for those too, at one more system call.
void Bus::AwaitAny(int timeout_ms) {
  if (Clock::now() < fragments_until_) {
    std::array<pollfd, 2> waited{{{own_socket_->descriptor(), POLLIN, 0}, {lcm_.getFileno(), POLLIN, 0}}};
    poll(waited.data(), waited.size(), timeout_ms);
    timeout_ms = 0;
  }
  own_socket_->Await(timeout_ms);
}

/// Handles the messages on the own socket.
void Bus::HandleWhole() {
  for (int i = 0; i < kMostMessages || own_socket_->has_more(); ++i) {
    const auto message = own_socket_->Receive();
    if (!message) return;
    for (const auto& subscription : subscriptions_) {
      if (subscription->Takes(message->channel)) subscription->Receive(message->sender, message->bytes);
    }
  }
}

}  // namespace crsm
