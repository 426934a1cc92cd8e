#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <future>
#include <thread>
#include <utility>

#include "common/logs/stop_request.hpp"
#include "services/sources/devices/descriptor_connection.hpp"

namespace crsm {
namespace {

using AddressList = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// What a name server says, or the error.
struct Answer {
  int error = 0;
  AddressList addresses{nullptr, &freeaddrinfo};
};

Answer LookUp(const std::string& host, const std::string& port) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  return {error, {found, &freeaddrinfo}};
}

/// A name server that is silent lets who asks wait for long, whatever signal comes: a thread of its own waits.
AddressList Resolve(const std::string& host, const std::string& port) {
  constexpr auto kLookEvery = std::chrono::milliseconds(20);
  std::packaged_task<Answer()> task([host, port] { return LookUp(host, port); });
  std::future<Answer> future = task.get_future();
  std::thread(std::move(task)).detach();
  while (future.wait_for(kLookEvery) != std::future_status::ready) {
    if (StopRequested()) throw DeviceError(fmt::format("stopped while the host {} was looked up", host));
  }
  Answer answer = future.get();
  if (answer.error != 0) throw DeviceError(fmt::format("there is no host {}: {}", host, gai_strerror(answer.error)));
  return std::move(answer.addresses);
}

/// 0, or the errno of a connection that did not come about.
int Connect(int descriptor, const addrinfo& address) {
  constexpr int kPatience_ms = 1000;
  if (connect(descriptor, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  pollfd entry{descriptor, POLLOUT, 0};
  if (poll(&entry, 1, kPatience_ms) <= 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

[[noreturn]] void Refuse(const std::string& host, const std::string& port, int error) {
  if (error == ECONNREFUSED) {
    throw DeviceError(
        fmt::format("{} is there, but refuses port {}: is it the laser's port, or does another program use the laser? "
                    "It serves only one",
                    host, port));
  }
  throw DeviceError(fmt::format(
      "{} does not answer ({}): does the laser have power, is its cable plugged in, and is this host in its network?",
      host, std::strerror(error)));
}

}  // namespace

std::unique_ptr<Connection> OpenTcp(const std::string& host, const std::string& port) {
  const AddressList addresses = Resolve(host, port);
  int error = EHOSTUNREACH;
  for (const addrinfo* address = addresses.get(); address; address = address->ai_next) {
    const int descriptor = socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (descriptor < 0) continue;
    error = Connect(descriptor, *address);
    if (error == 0) {
      const int on = 1;
      setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return std::make_unique<DescriptorConnection>(descriptor, "has ended the connection: does it still have power?");
    }
    close(descriptor);
  }
  Refuse(host, port, error);
}

}  // namespace crsm
