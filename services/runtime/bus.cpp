#include "services/runtime/bus.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstdlib>
#include <regex>
#include <stdexcept>

namespace crsm {
namespace {

constexpr const char* kReceiveBuffer = "recv_buf_size=2097152";  // [bytes]; a burst of map parts fits
// Messages of one channel. LCM drops the newest of more, and does not say so: room for all that come while a stage
// works, or waits for a core, 0.15 s of 65,000 scans/s. Longer queues belong to the stages, which count what they drop.
constexpr int kQueueCapacity = 10000;

/// Whether LCM will take all of a udpm:// URL as it is meant: it passes over options that it does not know or cannot
/// read.
bool IsMulticastUrl(const std::string& url) {
  static const std::regex kForm(R"(udpm://(?:2(?:2[4-9]|3[0-9])(?:\.[0-9]{1,3}){3}(?::([0-9]{1,5}))?)?)"
                                R"((?:\?(?:ttl|recv_buf_size)=[0-9]+(?:&(?:ttl|recv_buf_size)=[0-9]+)*)?)");
  std::smatch parts;
  if (!std::regex_match(url, parts, kForm)) return false;
  const int port = parts[1].matched ? std::stoi(parts[1]) : 7667;
  return port >= 1 && port <= 65535;
}

/// The URL as LCM is to see it: checked, because LCM turns some mistakes into another transport in silence, and with
/// the receive buffer that it asks for only when told.
std::string CompleteUrl(std::string url) {
  if (url.empty()) {
    const char* environment = std::getenv("LCM_DEFAULT_URL");
    url = environment && *environment ? environment : "udpm://239.255.76.67:7667?ttl=0";
  }
  const bool multicast = url.rfind("udpm://", 0) == 0;
  if (multicast ? !IsMulticastUrl(url) : url.rfind("tcpq://", 0) != 0) {
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

}  // namespace

Bus::Bus(std::string url, const std::string& channel_prefix, Counters& counters)
    : lcm_(url = CompleteUrl(url)), prefix_(channel_prefix), counters_(counters) {
  if (!lcm_.good()) {
    throw std::runtime_error(
        fmt::format("--lcm-url {}: LCM cannot open it; is the address right, and its server up?", url));
  }
}

void Bus::Subscription::Handle(const lcm::ReceiveBuffer* buffer, const std::string&) {
  try {
    handler({static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
  } catch (const std::exception&) {  // would poison the LCM handle
    counters->Add("handler_failed");
  }
}

void Bus::SubscribeRaw(const char* channel, std::function<void(std::span<const std::uint8_t>)> handler) {
  subscriptions_.push_back(std::make_unique<Subscription>(Subscription{std::move(handler), &counters_}));
  lcm::Subscription* subscription =
      lcm_.subscribe(EscapeForRegex(prefix_ + channel), &Subscription::Handle, subscriptions_.back().get());
  if (!subscription || lcm_.getFileno() < 0) {
    throw std::runtime_error(
        "no multicast route for LCM; as root: ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo");
  }
  subscription->setQueueCapacity(kQueueCapacity);
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
