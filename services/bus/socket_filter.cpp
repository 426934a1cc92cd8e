#include "services/bus/socket_filter.hpp"

#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/select.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace crsm {
namespace {

// Where things stand in a packet [bytes]: LCM's UDP multicast protocol, behind the UDP header.
constexpr std::uint32_t kMagicAt = 8;
constexpr std::uint32_t kShortChannelAt = 16;  // behind the magic and the sequence number
constexpr std::uint32_t kSizeAt = 16;          // of the whole message
constexpr std::uint32_t kOffsetAt = 20;        // of the fragment in the message
constexpr std::uint32_t kNumberAt = 24;        // of the fragment, 16 bits
constexpr std::uint32_t kNumFragmentsAt = 26;  // 16 bits
constexpr std::uint32_t kLongChannelAt = 28;   // in the first fragment only
constexpr std::uint32_t kShortMagic = 0x4c433032;
constexpr std::uint32_t kLongMagic = 0x4c433033;

constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();  // of the packet's bytes

// The instructions. A load beyond the packet's end drops the packet.
constexpr sock_filter LoadWord(std::uint32_t at) { return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, at); }
constexpr sock_filter LoadHalf(std::uint32_t at) { return BPF_STMT(BPF_LD | BPF_H | BPF_ABS, at); }
constexpr sock_filter SetX(std::uint32_t value) { return BPF_STMT(BPF_LDX | BPF_IMM, value); }
constexpr sock_filter Return(std::uint32_t num_bytes) { return BPF_STMT(BPF_RET | BPF_K, num_bytes); }
constexpr sock_filter Jump(std::uint32_t skip) { return BPF_JUMP(BPF_JMP | BPF_JA, skip, 0, 0); }
constexpr sock_filter IfEqual(std::uint32_t value, std::uint8_t skip_if, std::uint8_t skip_else) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, skip_if, skip_else);
}

/// Drops what was sent by another host, and goes on behind itself with the rest.
std::vector<sock_filter> MakeHostFilter() {
  const auto Ask = [](std::int32_t what) { return LoadWord(static_cast<std::uint32_t>(SKF_AD_OFF + what)); };
  return {Ask(SKF_AD_IFINDEX), IfEqual(if_nametoindex("lo"), 3, 0),  //
          Ask(SKF_AD_PKTTYPE), IfEqual(PACKET_LOOPBACK, 1, 0), Return(0)};
}

/// Drops what is no LCM message, lets later fragments through or drops them, and goes on behind itself with the rest,
/// the place of the channel in X.
std::vector<sock_filter> MakeHeaderFilter(Packets packets) {
  const std::uint8_t to_short = packets == Packets::kFragments ? 1 : 14;  // 1: to the Return(0) behind the next
  const std::uint8_t to_long = packets == Packets::kWhole ? 0 : 1;
  return {LoadWord(kMagicAt), IfEqual(kShortMagic, to_short, 0), IfEqual(kLongMagic, to_long, 0), Return(0),
          LoadWord(kSizeAt), BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, kLargestFragmentedMessage, 3, 0),
          BPF_STMT(BPF_MISC | BPF_TAX, 0), LoadWord(kOffsetAt),
          BPF_JUMP(BPF_JMP | BPF_JGT | BPF_X, 0, 0, 1),  // the offset against the size
          Return(0),
          LoadHalf(kNumFragmentsAt),  // the header is whole
          LoadHalf(kNumberAt), IfEqual(0, 1, 0), Return(kAll),
          // Here with the first fragment; a message in one packet comes to the next but one.
          SetX(kLongChannelAt), Jump(1), SetX(kShortChannelAt)};
}

/// Lets a packet through that has these bytes at X; else goes on behind itself.
std::vector<sock_filter> MakeNameFilter(const std::string& bytes) {
  std::vector<sock_filter> program;
  const auto num_comparisons = bytes.size() / 4 + bytes.size() % 4 / 2 + bytes.size() % 2;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t left = bytes.size() - at;
    const std::size_t size = left >= 4 ? 4 : left >= 2 ? 2 : 1;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
    const auto width = static_cast<std::uint16_t>(size == 4 ? BPF_W : size == 2 ? BPF_H : BPF_B);
    program.push_back(BPF_STMT(static_cast<std::uint16_t>(BPF_LD | BPF_IND | width), static_cast<std::uint32_t>(at)));
    const std::size_t left_after = num_comparisons - program.size() / 2 - 1;
    program.push_back(IfEqual(value, 0, static_cast<std::uint8_t>(2 * left_after + 1)));
    at += size;
  }
  program.push_back(Return(kAll));
  return program;
}

}  // namespace

std::vector<sock_filter> MakeChannelFilter(std::vector<std::string> channels, const Passage& passage) {
  // Short names first: those that are compared before a packet's own are then no longer than that, and no load for
  // them goes beyond the packet's end.
  std::stable_sort(channels.begin(), channels.end(),
                   [](const std::string& one, const std::string& other) { return one.size() < other.size(); });
  std::vector<sock_filter> program;
  if (passage.hosts == Hosts::kThis) program = MakeHostFilter();
  const std::vector<sock_filter> header = MakeHeaderFilter(passage.packets);
  program.insert(program.end(), header.begin(), header.end());
  for (const std::string& channel : channels) {
    const bool all_that_begin_so = !channel.empty() && channel.back() == '*';
    const std::vector<sock_filter> name =
        MakeNameFilter(all_that_begin_so ? channel.substr(0, channel.size() - 1) : channel + '\0');
    program.insert(program.end(), name.begin(), name.end());
  }
  program.push_back(Return(0));
  return program;
}

bool AttachFilter(int socket, const std::vector<sock_filter>& program) {
  if (program.size() <= BPF_MAXINSNS) {
    std::vector<sock_filter> instructions = program;
    const sock_fprog filter{static_cast<std::uint16_t>(instructions.size()), instructions.data()};
    if (setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0) return true;
  }
  const int none = 0;
  setsockopt(socket, SOL_SOCKET, SO_DETACH_FILTER, &none, sizeof none);
  return false;
}

std::set<int> FindUdpSockets(int port) {
  std::set<int> found;
  for (int descriptor = 0; descriptor < FD_SETSIZE; ++descriptor) {  // LCM waits by select(), which takes no more
    int type = 0;
    socklen_t type_size = sizeof type;
    sockaddr_in address{};
    socklen_t address_size = sizeof address;
    if (getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &type_size) == 0 && type == SOCK_DGRAM &&
        getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &address_size) == 0 &&
        address.sin_family == AF_INET && ntohs(address.sin_port) == port) {
      found.insert(descriptor);
    }
  }
  return found;
}

}  // namespace crsm
