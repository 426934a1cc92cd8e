#include "services/sources/devices/descriptor_connection.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>

namespace crsm {

DescriptorConnection::~DescriptorConnection() { close(descriptor_); }

bool DescriptorConnection::Await(short events, std::chrono::milliseconds longest) const {
  pollfd entry{descriptor_, events, 0};
  return poll(&entry, 1, static_cast<int>(longest.count())) > 0;  // a signal ends the wait
}

std::string DescriptorConnection::Read(std::chrono::milliseconds longest) {
  constexpr std::size_t kMostBytes = 65536;
  if (!Await(POLLIN, longest)) return "";
  std::string bytes(kMostBytes, '\0');
  const ssize_t size = read(descriptor_, bytes.data(), bytes.size());
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return "";
  if (size <= 0) throw DeviceError(gone_);
  bytes.resize(static_cast<std::size_t>(size));
  return bytes;
}

void DescriptorConnection::Write(std::string_view bytes) {
  constexpr auto kPatience = std::chrono::milliseconds(500);
  while (!bytes.empty()) {
    const ssize_t size = write(descriptor_, bytes.data(), bytes.size());
    if (size > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(size));
    } else if (errno == EAGAIN) {
      if (!Await(POLLOUT, kPatience)) throw DeviceError("takes no more bytes: does the laser run?");
    } else if (errno != EINTR) {
      throw DeviceError(gone_);
    }
  }
}

}  // namespace crsm
