#include "services/bus/bus_role.hpp"

#include <netinet/in.h>
#include <unistd.h>

#include <optional>

#include "catch.hpp"
#include "scratch.hpp"

namespace crsm {
namespace {

/// A bus that no other process of the tests asks for.
BusAddress OwnBus(const std::string& prefix = "") {
  return {"udpm://239.255.76.67:7790?ttl=0", prefix + std::to_string(getpid()) + "/"};
}

bool IsFree(const BusAddress& address, const std::string& role) {
  return ErrorOf([&] { BusRole(address, role); }).empty();
}

}  // namespace

TEST_CASE("a role on a bus is refused while a process has it, which is named with its command line") {
  const BusAddress bus = OwnBus();
  CHECK_FALSE(FindRoleHolder(bus, kMatcherRole));
  std::optional<BusRole> role(std::in_place, bus, kMatcherRole);
  const std::string error = ErrorOf([&] { BusRole(bus, kMatcherRole); });
  INFO(error);
  CHECK(error.find("port 7790 with the channel prefix " + bus.channel_prefix + " already has its matcher, process " +
                   std::to_string(getpid()) + " (") == 0);
  CHECK(error.find("unit_tests") != std::string::npos);
  CHECK(FindRoleHolder(bus, kMatcherRole));
  role.reset();
  CHECK_FALSE(FindRoleHolder(bus, kMatcherRole));
  CHECK(IsFree(bus, kMatcherRole));
}

TEST_CASE("a role is of one bus and one channel prefix") {
  const BusRole role(OwnBus(), kMapOwnerRole);
  BusAddress bus = OwnBus();
  CHECK(IsFree(bus, kMatcherRole));
  bus.lcm_url = "udpm://239.255.76.67:7791?ttl=0";
  CHECK(IsFree(bus, kMapOwnerRole));
  bus.lcm_url = "udpm://239.255.76.68:7790?ttl=1&recv_buf_size=300000";  // LCM tells buses apart by their port alone
  CHECK_FALSE(IsFree(bus, kMapOwnerRole));
  CHECK(IsFree(OwnBus("robot1/"), kMapOwnerRole));
  CHECK(IsFree({bus.lcm_url, OwnBus().channel_prefix + "/"}, kMapOwnerRole));
}

TEST_CASE("channel prefixes that are too long for the name of a socket are told apart all the same") {
  const std::string length(200, 'x');
  const BusRole role(OwnBus(length + "1"), kMapOwnerRole);
  CHECK(IsFree(OwnBus(length + "2"), kMapOwnerRole));
  CHECK_FALSE(IsFree(OwnBus(length + "1"), kMapOwnerRole));
}

TEST_CASE("who has a role is known however often it was asked, also where the queue of those who ask is full") {
  const BusAddress bus = OwnBus();
  const BusRole role(bus, kSelectorRole);
  const std::string known = *FindRoleHolder(bus, kSelectorRole);
  CHECK(known.find(std::to_string(getpid())) != std::string::npos);
  for (int i = 0; i < 5000; ++i) FindRoleHolder(bus, kSelectorRole);
  CHECK(FindRoleHolder(bus, kSelectorRole));
  CHECK_FALSE(IsFree(bus, kSelectorRole));
  for (int i = 0; i < 10'000; ++i) {
    FindRoleHolder(bus, kSelectorRole);
    if (i % 1000 == 0) role.DismissVisitors();
  }
  CHECK(FindRoleHolder(bus, kSelectorRole) == known);
}

TEST_CASE("who has a role is busy, not unknown, while the queue of those who ask is full") {
  const BusAddress bus = OwnBus();
  const BusRole role(bus, kSelectorRole);
  const Sender sender{htonl(INADDR_LOOPBACK), 9};
  CHECK(FindRole(bus, kSelectorRole, sender) == RoleHolder::kAnother);
  for (int i = 0; i < 5000; ++i) FindRoleHolder(bus, kSelectorRole);
  CHECK(FindRole(bus, kSelectorRole, sender) == RoleHolder::kBusy);
  role.DismissVisitors();
  CHECK(FindRole(bus, kSelectorRole, sender) == RoleHolder::kAnother);
}

}  // namespace crsm
