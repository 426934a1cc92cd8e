// What a client may send to map_viewer: HTTP, frames of WebSocket after a good beginning, and what stands in these.

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

#include "input.hpp"
#include "services/map_viewer/page_feed.hpp"
#include "services/map_viewer/site.hpp"
#include "services/map_viewer/web_server.hpp"

namespace {

using namespace crsm;

/// How a conversation may begin: with nothing, or with a client that was let in already.
constexpr std::array<const char*, 3> kBeginnings{
    "",
    "GET /live?robot=0 HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    "Sec-WebSocket-Protocol: crsm.view.v1\r\n\r\n",
    "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n",
};

/// A viewer with a scene.
class FuzzedViewer {
 public:
  FuzzedViewer() {
    TileBytes cells;
    cells.fill(200);
    scene_.map().Set({0, -1}, cells, 1);
    scene_.map().SetVersion(7, 1);
  }

  void Converse(const std::string& beginning, std::span<const std::uint8_t> rest) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) std::abort();
    server_.Adopt(ends[1]);
    Send(ends[0], beginning.data(), beginning.size());
    Send(ends[0], rest.data(), rest.size());
    shutdown(ends[0], SHUT_WR);
    while (Drain(ends[0])) server_.Serve(std::chrono::milliseconds(0));
    close(ends[0]);
    server_.Serve(std::chrono::milliseconds(0));
  }

 private:
  void Send(int socket, const void* bytes, std::size_t size) {
    if (size > 0 && send(socket, bytes, size, MSG_NOSIGNAL) >= 0) server_.Serve(std::chrono::milliseconds(0));
  }

  /// Whether the viewer goes on.
  static bool Drain(int socket) {
    std::array<char, 65536> ignored;
    ssize_t size = 0;
    while ((size = recv(socket, ignored.data(), ignored.size(), 0)) > 0) continue;
    return size < 0 && errno == EAGAIN;
  }

  Scene scene_{""};
  Site site_{{&scene_}, Access(true, "")};
  Counters counters_;
  WebServer server_{HttpAddress{"127.0.0.1", 0}, [this](const WebRequest& request) { return site_.Answer(request); },
                    counters_};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static FuzzedViewer viewer;
  if (size == 0) return 0;
  viewer.Converse(kBeginnings[data[0] % kBeginnings.size()], {data + 1, size - 1});
  return 0;
}
