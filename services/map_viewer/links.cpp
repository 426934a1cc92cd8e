#include "services/map_viewer/links.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>

namespace crsm {
namespace {

std::optional<std::string> ToText(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.sa_family == AF_INET) {
    sockaddr_in ipv4{};
    std::memcpy(&ipv4, &address, sizeof(ipv4));
    inet_ntop(AF_INET, &ipv4.sin_addr, text.data(), text.size());
  } else if (address.sa_family == AF_INET6) {
    sockaddr_in6 ipv6{};
    std::memcpy(&ipv6, &address, sizeof(ipv6));
    if (IN6_IS_ADDR_LINKLOCAL(&ipv6.sin6_addr)) return std::nullopt;
    inet_ntop(AF_INET6, &ipv6.sin6_addr, text.data(), text.size());
  } else {
    return std::nullopt;
  }
  return text.data();
}

bool IsV6(const std::string& address) { return address.find(':') != std::string::npos; }

}  // namespace

std::vector<std::string> ListInterfaceAddresses() {
  std::vector<std::string> addresses;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return addresses;
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> all(first, &freeifaddrs);
  for (const ifaddrs* entry = first; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || !(entry->ifa_flags & IFF_UP) || (entry->ifa_flags & IFF_LOOPBACK)) continue;
    auto address = ToText(*entry->ifa_addr);
    if (address && std::count(addresses.begin(), addresses.end(), *address) == 0) addresses.push_back(*address);
  }
  std::stable_partition(addresses.begin(), addresses.end(), [](const auto& address) { return !IsV6(address); });
  return addresses;
}

std::vector<std::string> MakeLinks(const HttpAddress& listens_at, const std::string& token,
                                   const std::vector<std::string>& interfaces) {
  std::vector<std::string> hosts{listens_at.address};
  if (listens_at.address == "0.0.0.0" || listens_at.address == "::") {
    const bool ipv6_too = IsV6(listens_at.address);
    hosts.clear();
    std::copy_if(interfaces.begin(), interfaces.end(), std::back_inserter(hosts),
                 [&](const auto& address) { return ipv6_too || !IsV6(address); });
    if (hosts.empty()) hosts.emplace_back(ipv6_too ? "::1" : "127.0.0.1");
  }
  std::vector<std::string> links;
  for (const std::string& host : hosts) {
    links.push_back(fmt::format("http://{}/{}", FormatAuthority({host, listens_at.port, listens_at.is_loopback}),
                                token.empty() ? "" : "#token=" + token));
  }
  return links;
}

}  // namespace crsm
