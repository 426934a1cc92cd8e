#include "services/bus/bus_role.hpp"

#include <grp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
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

TEST_CASE("a process of another user has its role by the user of its socket, and another user's process has not") {
  if (geteuid() != 0) {
    WARN("  skipped: users of roles: needs root");
    return;
  }
  constexpr uid_t kFirstUser = 60001;
  const BusAddress bus = OwnBus();
  const auto Become = [](uid_t user) { return setgroups(0, nullptr) == 0 && setgid(user) == 0 && setuid(user) == 0; };
  int ready[2];
  int done[2];
  REQUIRE(pipe(ready) == 0);
  REQUIRE(pipe(done) == 0);
  const auto Start = [&](uid_t user, bool has_role) {  // the port of its UDP socket
    const pid_t child = fork();
    if (child == 0) {
      close(done[1]);
      std::optional<BusRole> role;
      if (!Become(user)) _exit(1);
      if (has_role) role.emplace(bus, kMatcherRole);
      const int opened = socket(AF_INET, SOCK_DGRAM, 0);
      sockaddr_in address{};
      socklen_t size = sizeof address;
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      if (bind(opened, reinterpret_cast<const sockaddr*>(&address), size) != 0) _exit(1);
      getsockname(opened, reinterpret_cast<sockaddr*>(&address), &size);
      char byte = 0;
      if (write(ready[1], &address.sin_port, sizeof address.sin_port) > 0)
        byte = static_cast<char>(read(done[0], &byte, 1));
      _exit(byte);
    }
    in_port_t port = 0;
    REQUIRE(read(ready[0], &port, sizeof port) == sizeof port);
    return Sender{htonl(INADDR_LOOPBACK), ntohs(port)};
  };
  const Sender holder = Start(kFirstUser, true);
  const Sender other = Start(kFirstUser + 1, false);
  const pid_t judge = fork();
  if (judge == 0) {
    if (!Become(kFirstUser + 2)) _exit(1);
    const bool right = FindRole(bus, kMatcherRole, holder) == RoleHolder::kSender &&
                       FindRole(bus, kMatcherRole, other) == RoleHolder::kAnother;
    _exit(right ? 0 : 2);
  }
  int status = 0;
  waitpid(judge, &status, 0);
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(FindRole(bus, kMatcherRole, holder) == RoleHolder::kSender);
  close(done[1]);
  while (wait(nullptr) > 0) {
  }
}

TEST_CASE("of a sender that is not known nobody can tell whether it has a role") {
  const BusRole role(OwnBus(), kMatcherRole);
  CHECK(FindRole(OwnBus(), kMatcherRole, Sender()) == RoleHolder::kUnknown);
}

}  // namespace crsm
