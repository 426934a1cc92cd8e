#include "services/runtime/bus.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <regex>
#include <stdexcept>
#include <utility>

#include "services/runtime/socket_filter.hpp"

namespace crsm {
namespace {

constexpr const char* kReceiveBuffer = "recv_buf_size=2097152";  // [bytes]; a burst of map parts fits
// Messages of one channel. LCM drops the newest of more, and does not say so: room for all that come while a stage
// works, or waits for a core, 0.15 s of 65,000 scans/s. Longer queues belong to the stages, which count what they drop.
constexpr int kQueueCapacity = 10000;

/// The port of a udpm:// URL, if LCM will take all of it as it is meant: it passes over options that it does not know
/// or cannot read.
std::optional<int> MulticastPort(const std::string& url) {
  static const std::regex kForm(R"(udpm://(?:2(?:2[4-9]|3[0-9])(?:\.[0-9]{1,3}){3}(?::([0-9]{1,5}))?)?)"
                                R"((?:\?(?:ttl|recv_buf_size)=[0-9]+(?:&(?:ttl|recv_buf_size)=[0-9]+)*)?)");
  std::smatch parts;
  if (!std::regex_match(url, parts, kForm)) return std::nullopt;
  const int port = parts[1].matched ? std::stoi(parts[1]) : 7667;
  return port >= 1 && port <= 65535 ? std::optional(port) : std::nullopt;
}

/// The URL as LCM is to see it: checked, because LCM turns some mistakes into another transport in silence, and with
/// the receive buffer that it asks for only when told.
std::string CompleteUrl(std::string url) {
  if (url.empty()) {
    const char* environment = std::getenv("LCM_DEFAULT_URL");
    url = environment && *environment ? environment : "udpm://239.255.76.67:7667?ttl=0";
  }
  const bool multicast = url.rfind("udpm://", 0) == 0;
  if (multicast ? !MulticastPort(url) : url.rfind("tcpq://", 0) != 0) {
    throw std::runtime_error(
        fmt::format("--lcm-url {}: not a bus between processes; one is like udpm://239.255.76.67:7667?ttl=0 or "
                    "tcpq://localhost:7700",
                    url));
  }
  if (multicast && url.find("recv_buf_size") == std::string::npos) {
    url += (url.find('?') == std::string::npos ? "?" : "&") + std::string(kReceiveBuffer);
  }
  return url;
}

std::string EscapeForRegex(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string("\\^$.|?*+()[]{}").find(c) != std::string::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

/// The socket that the first subscription has opened; none if that is not clear.
std::optional<int> FindNewSocket(int port, const std::set<int>& old_sockets) {
  std::set<int> sockets = FindUdpSockets(port);
  for (const int socket : old_sockets) sockets.erase(socket);
  return sockets.size() == 1 ? std::optional(*sockets.begin()) : std::nullopt;
}

}  // namespace

Bus::Bus(std::string url, const std::string& channel_prefix, Counters& counters)
    : port_(MulticastPort(url = CompleteUrl(url))), lcm_(url), prefix_(channel_prefix), counters_(counters) {
  if (!lcm_.good()) {
    throw std::runtime_error(
        fmt::format("--lcm-url {}: LCM cannot open it; is the address right, and its server up?", url));
  }
}

void Bus::Subscription::Handle(const lcm::ReceiveBuffer* buffer, const std::string&) {
  try {
    handler({static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
  } catch (const std::exception& error) {  // would poison the LCM handle
    counters->Add("handler_failed");
    if (!std::exchange(failed_before, true)) fmt::print(stderr, "a message on {} failed: {}\n", channel, error.what());
  }
}

void Bus::SubscribeRaw(const char* channel, std::function<void(std::span<const std::uint8_t>)> handler) {
  const bool first = channels_.empty();
  const std::set<int> sockets_of_others = first && port_ ? FindUdpSockets(*port_) : std::set<int>();
  subscriptions_.push_back(
      std::make_unique<Subscription>(Subscription{prefix_ + channel, std::move(handler), &counters_}));
  lcm::Subscription* subscription =
      lcm_.subscribe(EscapeForRegex(prefix_ + channel), &Subscription::Handle, subscriptions_.back().get());
  if (!subscription || lcm_.getFileno() < 0) {
    throw std::runtime_error(
        "no multicast route for LCM; as root: ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo");
  }
  subscription->setQueueCapacity(kQueueCapacity);
  if (first && port_) socket_ = FindNewSocket(*port_, sockets_of_others);
  channels_.push_back(prefix_ + channel);
  FilterSocket();
}

/// Without the filter everything works as well, at a price.
void Bus::FilterSocket() {
  if (!port_) return;
  if (!socket_ || !AttachFilter(*socket_, MakeChannelFilter(channels_))) counters_.Add("socket_unfiltered");
}

void Bus::CountUnpublished(const std::string& channel, int error) {
  if (counters_.counts().count("publish_failed") == 0) {
    fmt::print(stderr, "LCM cannot publish on {}{}\n", prefix_ + channel,
               error != 0 ? fmt::format(": {}", std::strerror(error)) : "");
  }
  counters_.Add("publish_failed");
}

void Bus::Wait(int timeout_ms) {
  // What LCM holds, so that what a stage works on is fresh; but who sends faster than they are read does not keep it
  // from its work.
  constexpr int kMostMessages = 1000;
  errno = 0;
  int handled = lcm_.handleTimeout(timeout_ms);
  for (int i = 1; handled > 0 && i < kMostMessages; ++i) handled = lcm_.handleTimeout(0);
  if (handled < 0 && errno != EINTR) throw std::runtime_error("the bus is gone: LCM can receive no more");
}

}  // namespace crsm
