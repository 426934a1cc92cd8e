#include "services/map_viewer/access.hpp"

#include <unistd.h>

#include <array>

#include "catch.hpp"
#include "services/base/usage_error.hpp"

namespace crsm {

TEST_CASE("--http takes an address and a port, of IPv6 too, and nothing else") {
  CHECK(ParseHttpAddress("127.0.0.1:8765").port == 8765);
  CHECK(ParseHttpAddress("localhost:0").address == "127.0.0.1");
  for (const char* text : {"127.9.9.9:1", "[::1]:8765"}) CHECK(ParseHttpAddress(text).is_loopback);
  for (const char* text : {"0.0.0.0:8765", "[::]:8765", "10.0.0.1:80"}) CHECK_FALSE(ParseHttpAddress(text).is_loopback);
  for (const char* text : {"[::1]:8765", "10.0.0.1:80"}) CHECK(FormatAuthority(ParseHttpAddress(text)) == text);
  for (const char* text :
       {"", ":", "8765", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:8x", "robot:8765",
        "::1:8765", "[::1", "[::1]8765", "[1.2.3.4]:5", "127.0.0.1:87 65"}) {
    INFO(text);
    CHECK_THROWS_AS(ParseHttpAddress(text), UsageError);
  }
}

TEST_CASE("on the loopback only its own names are hosts: a site whose name leads here is not") {
  const Access access(true, "");
  for (const char* host : {"localhost", "LOCALHOST:8765", "127.0.0.1:8765", "127.0.0.1", "[::1]:8765", "[::1]"}) {
    INFO(host);
    CHECK(access.AllowsHost(host));
  }
  for (const char* host : {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "192.168.1.2:8765",
                           "localhost:port", "localhost:", "127.0.0.1:8765:1", "[::1", "[evil]", "[::1]x",
                           "a@localhost", "127.evil", "127.0.0.1/", "0.0.0.0"}) {
    INFO(host);
    CHECK_FALSE(access.AllowsHost(host));
  }
}

TEST_CASE("beyond this host, IP addresses and its own name are hosts") {
  const Access access(false, "secret");
  std::array<char, 256> name{};
  REQUIRE(gethostname(name.data(), name.size() - 1) == 0);
  for (const std::string& host : {std::string("192.168.1.2"), std::string("[fe80::1]"), std::string(name.data())}) {
    CHECK(access.AllowsHost(host + ":8765"));
  }
  CHECK_FALSE(access.AllowsHost("evil.example:8765"));
}

TEST_CASE("a page of another site is not let in; Foxglove's and Lichtblick's are, to what they know") {
  constexpr const char* kHost = "localhost:8765";
  CHECK(Access::AllowsOrigin("http://localhost:8765", kHost, false));
  CHECK(Access::AllowsOrigin("http://LOCALHOST:8765", kHost, true));
  CHECK_FALSE(Access::AllowsOrigin("http://localhost:9000", kHost, true));  // another program's page
  CHECK_FALSE(Access::AllowsOrigin("http://127.0.0.1:8765", kHost, true));
  for (const char* origin : {"", "null", "http://evil.example", "https://localhost", "http://localhost@evil.example",
                             "http://localhost/", "file://", "https://app.foxglove.dev"}) {
    INFO(origin);
    CHECK_FALSE(Access::AllowsOrigin(origin, kHost, false));
  }
  CHECK(Access::AllowsOrigin("https://app.foxglove.dev", kHost, true));
  CHECK(Access::AllowsOrigin("file://", kHost, true));
  CHECK_FALSE(Access::AllowsOrigin("https://app.foxglove.dev.evil.example", kHost, true));
  CHECK_FALSE(Access::AllowsOrigin("null", kHost, true));
}

TEST_CASE("only the whole token is the token") {
  const Access access(false, "0123abcd");
  CHECK(access.AllowsToken("0123abcd"));
  for (const char* token : {"", "0123abc", "0123abcde", "0123abce", "x"}) CHECK_FALSE(access.AllowsToken(token));
  CHECK(Access(true, "").AllowsToken("whatever"));
}

TEST_CASE("half of the token is enough to look, and for nothing else") {
  const Access access(false, "0123abcd");
  CHECK(access.AllowsToken("0123"));
  CHECK_FALSE(access.AllowsChange("0123"));
  CHECK(access.AllowsChange("0123abcd"));
  for (const char* token : {"", "abcd", "012", "01230123"}) {
    CHECK_FALSE(access.AllowsToken(token));
    CHECK_FALSE(access.AllowsChange(token));
  }
  CHECK(Access(true, "").AllowsChange(""));
}

TEST_CASE("a key is found in a query by its whole name") {
  CHECK(FindInQuery("/live?robot=1&token=ab", "token") == "ab");
  CHECK(FindInQuery("/live?robot=1&token=ab", "robot") == "1");
  CHECK(FindInQuery("/live?xtoken=ab&token=", "token") == "");
  CHECK_FALSE(FindInQuery("/live?xtoken=ab", "token"));
  CHECK_FALSE(FindInQuery("/token=ab", "token"));
  CHECK_FALSE(FindInQuery("", "token"));
  CHECK_FALSE(FindInQuery("?&&&=&token", "token"));
}

}  // namespace crsm
