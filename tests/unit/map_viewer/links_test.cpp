#include "services/map_viewer/links.hpp"

#include <algorithm>

#include "catch.hpp"

namespace crsm {
namespace {

const std::vector<std::string> kInterfaces{"192.168.1.2", "10.0.0.7", "2001:db8::5"};

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("a viewer that listens at one address has one link, with its token") {
  CHECK(MakeLinks({"127.0.0.1", 8765, true}, "", kInterfaces) == Texts{"http://127.0.0.1:8765/"});
  CHECK(MakeLinks({"10.0.0.7", 80, false}, "ab", kInterfaces) == Texts{"http://10.0.0.7:80/#token=ab"});
  CHECK(MakeLinks({"2001:db8::5", 80, false}, "ab", {}) == Texts{"http://[2001:db8::5]:80/#token=ab"});
}

TEST_CASE("a viewer that listens everywhere has a link for each interface that reaches it") {
  CHECK(MakeLinks({"0.0.0.0", 8765, false}, "ab", kInterfaces) ==
        Texts{"http://192.168.1.2:8765/#token=ab", "http://10.0.0.7:8765/#token=ab"});
  CHECK(MakeLinks({"::", 8765, false}, "ab", kInterfaces) == Texts{"http://192.168.1.2:8765/#token=ab",
                                                                   "http://10.0.0.7:8765/#token=ab",
                                                                   "http://[2001:db8::5]:8765/#token=ab"});
  CHECK(MakeLinks({"0.0.0.0", 8765, false}, "ab", {"2001:db8::5"}) == Texts{"http://127.0.0.1:8765/#token=ab"});
  CHECK(MakeLinks({"::", 8765, false}, "ab", {}) == Texts{"http://[::1]:8765/#token=ab"});
}

TEST_CASE("the addresses of this host are none of the loopback's and none that need a zone; each is a host of a link") {
  const Texts addresses = ListInterfaceAddresses();
  const Access access(false, "ab");
  for (const std::string& address : addresses) {
    INFO(address);
    CHECK_FALSE(address.starts_with("127."));
    CHECK(address != "::1");
    CHECK_FALSE(address.starts_with("fe80:"));
    CHECK(std::count(addresses.begin(), addresses.end(), address) == 1);
    CHECK(access.AllowsHost(FormatAuthority({address, 8765, false})));
  }
  const auto first_ipv6 =
      std::find_if(addresses.begin(), addresses.end(), [](const auto& a) { return a.find(':') != std::string::npos; });
  CHECK(std::all_of(first_ipv6, addresses.end(), [](const auto& a) { return a.find(':') != std::string::npos; }));
}

}  // namespace crsm
