#include "services/bus/bus_role.hpp"

#include <unistd.h>

#include <optional>

#include "catch.hpp"

namespace crsm {
namespace {

/// A bus that no other process of the tests asks for.
BusAddress OwnBus(const std::string& prefix = "") {
  return {"udpm://239.255.76.67:7790?ttl=0", prefix + std::to_string(getpid()) + "/"};
}

std::string ErrorOf(const BusAddress& address, const std::string& role) {
  try {
    const BusRole taken(address, role);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a role on a bus is refused while a process has it, which is named with its command line") {
  const BusAddress bus = OwnBus();
  CHECK_FALSE(FindRoleHolder(bus, kMatcherRole));
  std::optional<BusRole> role(std::in_place, bus, kMatcherRole);
  const std::string error = ErrorOf(bus, kMatcherRole);
  INFO(error);
  CHECK(error.find("port 7790 with the channel prefix " + bus.channel_prefix + " already has its matcher, process " +
                   std::to_string(getpid()) + " (") == 0);
  CHECK(error.find("unit_tests") != std::string::npos);
  CHECK(FindRoleHolder(bus, kMatcherRole));
  role.reset();
  CHECK_FALSE(FindRoleHolder(bus, kMatcherRole));
  CHECK(ErrorOf(bus, kMatcherRole).empty());
}

TEST_CASE("a role is of one bus and one channel prefix") {
  const BusRole role(OwnBus(), kMapOwnerRole);
  BusAddress bus = OwnBus();
  CHECK(ErrorOf(bus, kMatcherRole).empty());
  bus.lcm_url = "udpm://239.255.76.67:7791?ttl=0";
  CHECK(ErrorOf(bus, kMapOwnerRole).empty());
  bus.lcm_url = "udpm://239.255.76.68:7790?ttl=1&recv_buf_size=300000";  // LCM tells buses apart by their port alone
  CHECK_FALSE(ErrorOf(bus, kMapOwnerRole).empty());
  CHECK(ErrorOf(OwnBus("robot1/"), kMapOwnerRole).empty());
  CHECK(ErrorOf({bus.lcm_url, OwnBus().channel_prefix + "/"}, kMapOwnerRole).empty());
}

TEST_CASE("channel prefixes that are too long for the name of a socket are told apart all the same") {
  const std::string length(200, 'x');
  const BusRole role(OwnBus(length + "1"), kMapOwnerRole);
  CHECK(ErrorOf(OwnBus(length + "2"), kMapOwnerRole).empty());
  CHECK_FALSE(ErrorOf(OwnBus(length + "1"), kMapOwnerRole).empty());
}

TEST_CASE("who has a role is known however often it was asked") {
  const BusAddress bus = OwnBus();
  const BusRole role(bus, kSelectorRole);
  const std::string known = *FindRoleHolder(bus, kSelectorRole);
  for (int i = 0; i < 10'000; ++i) {
    FindRoleHolder(bus, kSelectorRole);
    if (i % 1000 == 0) role.DismissVisitors();
  }
  CHECK(FindRoleHolder(bus, kSelectorRole) == known);
  CHECK(known.find(std::to_string(getpid())) != std::string::npos);
}

TEST_CASE("where the queue of those who ask is full, the role is taken all the same") {
  const BusAddress bus = OwnBus();
  const BusRole role(bus, kSelectorRole);
  for (int i = 0; i < 5000; ++i) FindRoleHolder(bus, kSelectorRole);
  CHECK(FindRoleHolder(bus, kSelectorRole));
  CHECK_FALSE(ErrorOf(bus, kSelectorRole).empty());
}

}  // namespace crsm
