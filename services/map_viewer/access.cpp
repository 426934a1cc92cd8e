#include "services/map_viewer/access.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "common/math/parse_number.hpp"
#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

/// The sites and programs whose pages may ask for Foxglove's protocol. A site cannot pretend to be a file.
constexpr std::array<std::string_view, 4> kFoxgloveOrigins{"https://app.foxglove.dev", "https://studio.foxglove.dev",
                                                           "https://lichtblick-suite.github.io", "file://"};

bool IsIpv4(const std::string& host) {
  in_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1;
}

bool IsIpv6(const std::string& host) {
  in6_addr address{};
  return inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

struct HostAndPort {
  std::string host;  ///< without the brackets of IPv6
  std::optional<std::string_view> port;
};

HostAndPort Split(std::string_view text) {
  if (text.starts_with('[')) {
    const auto end = text.find(']');
    if (end == std::string_view::npos) return {};
    const std::string_view rest = text.substr(end + 1);
    if (!rest.empty() && rest.front() != ':') return {};
    const std::string host(text.substr(1, end - 1));
    if (!IsIpv6(host)) return {};
    return {host, rest.empty() ? std::nullopt : std::optional(rest.substr(1))};
  }
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return {std::string(text), std::nullopt};
  return {std::string(text.substr(0, colon)), text.substr(colon + 1)};
}

std::string ToLower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

bool IsLoopback(const std::string& host) {
  return host == "localhost" || host == "::1" || (IsIpv4(host) && host.starts_with("127."));
}

/// Looks at every byte of `expected`.
bool IsSame(std::string_view token, std::string_view expected) {
  unsigned difference = token.size() == expected.size() ? 0 : 1;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const char given = i < token.size() ? token[i] : '\0';
    difference |= static_cast<unsigned char>(given ^ expected[i]);
  }
  return difference == 0;
}

std::string NameOfThisHost() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "localhost";
  return ToLower(name.data());
}

}  // namespace

HttpAddress ParseHttpAddress(const std::string& text) {
  const auto [host, port_text] = Split(text);
  const auto port = port_text ? ParseNumber<std::uint16_t>(*port_text) : std::nullopt;
  const std::string address = host == "localhost" ? "127.0.0.1" : host;
  if (!port || !(IsIpv4(address) || IsIpv6(address))) {
    throw UsageError(fmt::format("--http: '{}' is not ADDRESS:PORT, as in 127.0.0.1:8765 or 0.0.0.0:8765", text));
  }
  return {address, *port, IsLoopback(address)};
}

std::string FormatAuthority(const HttpAddress& address) {
  return IsIpv6(address.address) ? fmt::format("[{}]:{}", address.address, address.port)
                                 : fmt::format("{}:{}", address.address, address.port);
}

bool Access::AllowsHost(std::string_view text) const {
  const auto [given, port] = Split(text);
  const std::string host = ToLower(given);
  if (host.empty() || (port && !ParseNumber<std::uint16_t>(*port))) return false;
  if (IsLoopback(host)) return true;
  return !is_loopback_ && (IsIpv4(host) || IsIpv6(host) || host == NameOfThisHost());
}

bool Access::AllowsOrigin(std::string_view origin, std::string_view host, bool foxglove) {
  if (foxglove && std::find(kFoxgloveOrigins.begin(), kFoxgloveOrigins.end(), origin) != kFoxgloveOrigins.end()) {
    return true;
  }
  constexpr std::string_view kScheme = "http://";
  return origin.starts_with(kScheme) &&
         ToLower(std::string(origin.substr(kScheme.size()))) == ToLower(std::string(host));
}

bool Access::AllowsToken(std::string_view token) const {
  return AllowsChange(token) || IsSame(token, ToLookToken(token_));
}

bool Access::AllowsChange(std::string_view token) const { return token_.empty() || IsSame(token, token_); }

std::optional<std::string_view> FindInQuery(std::string_view target, std::string_view key) {
  const auto question = target.find('?');
  std::string_view query = question == std::string_view::npos ? "" : target.substr(question + 1);
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
    if (pair.starts_with(key) && pair.substr(key.size()).starts_with('=')) return pair.substr(key.size() + 1);
  }
  return std::nullopt;
}

}  // namespace crsm
