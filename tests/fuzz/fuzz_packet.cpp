// Packets of LCM's UDP multicast, as MulticastSocket takes them, without the kernel's filter before it: the channel and
// the message lie within the packet, one behind the other, and the message goes on into the decoders.

#include <cstdlib>

#include "input.hpp"
#include "services/bus/multicast_socket.hpp"
#include "services/wire/wire.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  const std::span<const std::uint8_t> packet(data, size);
  const auto message = MulticastSocket::Parse(packet);
  if (!message) return 0;
  const auto* channel = reinterpret_cast<const std::uint8_t*>(message->channel.data());
  const bool channel_inside = channel >= data && channel + message->channel.size() < data + size;
  const bool ends_together = message->bytes.data() + message->bytes.size() == data + size;
  if (!channel_inside || !ends_together || channel[message->channel.size()] != 0 ||
      message->bytes.data() != channel + message->channel.size() + 1) {
    std::abort();
  }
  Decode<critical_rays_t>(message->bytes);
  Decode<scan_match_t>(message->bytes);
  Decode<map_delta_t>(message->bytes);
  Decode<map_request_t>(message->bytes);
  return 0;
}
