#pragma once

#include <optional>
#include <string>

#include "services/bus/sole_sender.hpp"

namespace crsm {

// What only one process may be on a bus, with one channel prefix: two would mix their scans, poses or maps.
inline constexpr const char* kPublisherRole = "publisher";
inline constexpr const char* kSelectorRole = "ray selector";
inline constexpr const char* kMatcherRole = "matcher";
inline constexpr const char* kMapOwnerRole = "owner of a map";
inline constexpr const char* kLoopCloserRole = "loop closer";
inline constexpr const char* kStackRole = "stack";
inline constexpr const char* kGuideRole = "guide";  // tells a robot where it is, by START_POSE

/// A bus and a channel prefix on it.
struct BusAddress {
  std::string lcm_url;  ///< empty for LCM's default
  std::string channel_prefix;
};

/// A role that this process has until its end, however it ends. Kept by an abstract Unix socket that bears its name:
/// there is no file that could be left behind, or belong to somebody else, and network namespaces separate these
/// sockets where they separate the buses. Processes on other hosts are not seen.
class BusRole {
 public:
  /// Throws std::runtime_error that says which process has the role already.
  BusRole(const BusAddress& address, const std::string& role);
  ~BusRole();
  BusRole(const BusRole&) = delete;

  /// Those who asked who has the role wait in a queue, which is full some day: to be called now and then.
  void DismissVisitors() const;

 private:
  int socket_ = -1;
};

/// Which process has a role, in words; nothing where none has it.
std::optional<std::string> FindRoleHolder(const BusAddress& address, const std::string& role);

/// Who has a role, for one that sent a message.
RoleHolder FindRole(const BusAddress& address, const std::string& role, const Sender& sender);

/// What to say to who wants a role that is taken.
std::string DescribeTakenRole(const BusAddress& address, const std::string& role, const std::string& holder);

}  // namespace crsm
