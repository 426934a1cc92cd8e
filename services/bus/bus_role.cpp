#include "services/bus/bus_role.hpp"

#include <fmt/core.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "services/base/process_info.hpp"
#include "services/bus/bus.hpp"

namespace crsm {
namespace {

struct SocketName {
  sockaddr_un address{};
  socklen_t size = 0;
};

/// FNV-1a: the same on every machine and in every build.
std::uint64_t Hash(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

/// A leading NUL makes the name an abstract one, of which every byte counts.
SocketName NameOf(const BusAddress& bus, const std::string& role) {
  SocketName name;
  std::string text = fmt::format("crsm/{}/{}/{}", NameBus(bus.lcm_url), bus.channel_prefix, role);
  if (text.size() >= sizeof name.address.sun_path) text = fmt::format("crsm/{:016x}/{}", Hash(text), role);
  name.address.sun_family = AF_UNIX;
  std::memcpy(name.address.sun_path + 1, text.data(), text.size());
  name.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return name;
}

int OpenSocket() {
  const int opened = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (opened < 0) throw std::runtime_error(fmt::format("cannot open a Unix socket: {}", std::strerror(errno)));
  return opened;
}

/// A process that has a role.
struct Holder {
  pid_t pid = 0;   ///< 0 where it cannot be seen
  uid_t user = 0;  ///< likewise
  bool is_busy = false;
};

/// Whether the socket at a port is the holder's, where its open files are not seen: another user's socket is not. The
/// same user's is, if each process has a user of its own, as the units of systemd have it.
RoleHolder JudgeByUser(const Holder& holder, std::uint16_t port) {
  constexpr uid_t kUnmapped = 65534;  // stands for all users that this process cannot name
  const auto user = FindUdpUser(port);
  if (holder.pid <= 0 || !user || *user == kUnmapped || holder.user == kUnmapped) return RoleHolder::kUnknown;
  if (*user != holder.user) return RoleHolder::kAnother;
  return holder.user == geteuid() ? RoleHolder::kUnknown : RoleHolder::kSender;
}

/// Nothing where none has it.
std::optional<Holder> FindHolder(const BusAddress& address, const std::string& role) {
  const SocketName name = NameOf(address, role);
  const int visitor = OpenSocket();
  ucred holder{};
  socklen_t size = sizeof holder;
  const bool connected = connect(visitor, reinterpret_cast<const sockaddr*>(&name.address), name.size) == 0;
  const bool queue_full = !connected && errno == EAGAIN;
  const bool known = connected && getsockopt(visitor, SOL_SOCKET, SO_PEERCRED, &holder, &size) == 0;
  close(visitor);
  if (!connected && !queue_full) return std::nullopt;
  return known ? Holder{holder.pid, holder.uid, queue_full} : Holder{0, 0, queue_full};
}

}  // namespace

BusRole::BusRole(const BusAddress& address, const std::string& role) : socket_(OpenSocket()) {
  constexpr int kLongestQueue = 4096;
  const SocketName name = NameOf(address, role);
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&name.address), name.size) == 0 &&
      listen(socket_, kLongestQueue) == 0) {
    return;
  }
  const int error = errno;
  close(socket_);
  if (error != EADDRINUSE) {
    throw std::runtime_error(
        fmt::format("cannot become the {} of {}: {}", role, NameBus(address.lcm_url), std::strerror(error)));
  }
  const auto holder = FindRoleHolder(address, role);
  throw std::runtime_error(
      DescribeTakenRole(address, role, holder.value_or("a process that starts or ends at this moment")));
}

BusRole::~BusRole() { close(socket_); }

void BusRole::DismissVisitors() const {
  constexpr int kMostAtOnce = 4096;  // who comes again and again does not keep this process from its work
  for (int i = 0; i < kMostAtOnce; ++i) {
    const int visitor = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC);
    if (visitor < 0) return;
    close(visitor);
  }
}

std::optional<std::string> FindRoleHolder(const BusAddress& address, const std::string& role) {
  const auto holder = FindHolder(address, role);
  if (!holder) return std::nullopt;
  return holder->pid > 0 ? DescribeProcess(holder->pid) : "an unknown process";
}

RoleHolder FindRole(const BusAddress& address, const std::string& role, const Sender& sender) {
  const auto holder = FindHolder(address, role);
  if (!holder) return RoleHolder::kNobody;
  if (!sender.known()) return RoleHolder::kUnknown;
  if (!IsOfThisHost(sender)) return RoleHolder::kAnother;
  if (holder->is_busy) return RoleHolder::kBusy;
  const auto has_port = holder->pid > 0 ? HasUdpPort(holder->pid, sender.port) : std::nullopt;
  if (!has_port) return JudgeByUser(*holder, sender.port);
  return *has_port ? RoleHolder::kSender : RoleHolder::kAnother;
}

std::string DescribeTakenRole(const BusAddress& address, const std::string& role, const std::string& holder) {
  const std::string prefix =
      address.channel_prefix.empty() ? "" : fmt::format(" with the channel prefix {}", address.channel_prefix);
  return fmt::format(
      "{}{} already has its {}, {}: stop that process, or choose another bus (--lcm-url "
      "'udpm://239.255.76.67:7700?ttl=0') or another --channel-prefix",
      NameBus(address.lcm_url), prefix, role, holder);
}

}  // namespace crsm
