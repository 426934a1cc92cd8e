#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace crsm {

/// Where the viewer is reached: an IP address and a port, 0 for any that is free.
struct HttpAddress {
  std::string address;
  std::uint16_t port = 0;
  bool is_loopback = true;
};

/// Reads ADDRESS:PORT, [ADDRESS]:PORT for IPv6. Throws UsageError that names --http where it is something else.
HttpAddress ParseHttpAddress(const std::string& text);

/// An address as it stands in a URL: [::1]:8765.
std::string FormatAuthority(const HttpAddress& address);

/// Who may see the map. A browser runs the scripts of every site that it visits, and all of these can talk to this
/// host: that a request comes from this host says nothing.
///
/// Host must be one that no foreign name server can give to a site: an IP address or this host's own name, and of the
/// loopback alone where the viewer listens there alone. Origin, which browsers send, must be the very
/// address under which the viewer was asked, with its port, or the desktop program or site of Foxglove or Lichtblick.
/// Beyond this host, a token is needed besides. Its first half is enough to look, and to change nothing.
class Access {
 public:
  /// token: empty where none is needed.
  Access(bool is_loopback, std::string token) : is_loopback_(is_loopback), token_(std::move(token)) {}

  /// Of a Host header, with or without a port.
  bool AllowsHost(std::string_view host) const;
  /// Of an Origin header. host: the Host header beside it, which is allowed. foxglove: whether Foxglove's protocol is
  /// asked for.
  static bool AllowsOrigin(std::string_view origin, std::string_view host, bool foxglove);
  /// To look. Takes as long for a token that is nearly right; so does the next one.
  bool AllowsToken(std::string_view token) const;
  /// To change something.
  bool AllowsChange(std::string_view token) const;

 private:
  bool is_loopback_;
  std::string token_;
};

/// The part of a token with which one may only look. Nobody guesses it, who has to ask the viewer for each guess.
inline std::string ToLookToken(const std::string& token) { return token.substr(0, token.size() / 2); }

/// The value of a key in the query of a target: "/live?robot=1&token=ab". Nothing is unescaped: no value needs it.
std::optional<std::string_view> FindInQuery(std::string_view target, std::string_view key);

}  // namespace crsm
