#pragma once

#include <linux/filter.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace crsm {

/// A filter in the kernel for the socket on which LCM receives its multicast.
///
/// Each packet on the bus goes to the socket of every process. LCM wakes a thread of each for it, which then looks
/// whether anybody here has subscribed to its channel; most often nobody has. With the filter such packets are dropped
/// before anybody is woken. It also keeps away what LCM 1.3.1 takes without enough suspicion: a fragment whose offset
/// plus its size wraps at 32 bits passes its check, and is written outside of the message
/// (https://github.com/lcm-proj/lcm/issues/628).
///
/// Nobody needs a privilege for that. What the filter drops, the kernel counts as drops of that socket (/proc/net/udp).

/// Larger messages, which come in fragments, are dropped [bytes]: many times what any of ours may be.
inline constexpr std::uint32_t kLargestFragmentedMessage = 1 << 22;

/// What is to pass: messages that are whole in one packet, fragments of larger ones, or both.
enum class Packets { kWhole, kFragments, kBoth };

/// Whose packets are to pass: those of processes of this host, or of others as well. LCM's ttl=0 keeps what is sent on
/// this host, and says nothing of what others send.
enum class Hosts { kThis, kAll };

constexpr Hosts HostsHeardAt(int ttl) { return ttl == 0 ? Hosts::kThis : Hosts::kAll; }

/// What a filter lets through.
struct Passage {
  Packets packets = Packets::kBoth;
  Hosts hosts = Hosts::kAll;
};

/// The filter program that lets through the messages on these channels, as the kernel sees them: with the UDP header.
///
/// A message in one packet is let through if its channel is one of these, up to and with the NUL behind it. So is the
/// first fragment of a longer one; of its other fragments, which do not name their channel, those that can be part of a
/// message of no more than kLargestFragmentedMessage. LCM throws them away where it has not got the first. Of this host
/// is what comes by the loopback interface, and the multicast of its own that the kernel hands back.
/// A channel that ends in * stands for all whose names begin so.
std::vector<sock_filter> MakeChannelFilter(std::vector<std::string> channels, const Passage& passage = {});

/// Has a socket filtered from now on, instead of how it was before. If the kernel refuses the program (it takes 4,096
/// instructions), the socket is as without any filter, and the answer is false.
bool AttachFilter(int socket, const std::vector<sock_filter>& program);

/// The sockets of this process that receive UDP on a port, whoever has opened them. LCM does not tell which is its own:
/// it is the one that was not there before the first subscription.
std::set<int> FindUdpSockets(int port);

}  // namespace crsm
