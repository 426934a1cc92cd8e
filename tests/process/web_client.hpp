#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "processes.hpp"

namespace crsm {

/// A TCP connection to this host.
class TcpClient {
 public:
  explicit TcpClient(std::uint16_t port);
  ~TcpClient();
  TcpClient(const TcpClient&) = delete;

  /// Whether the other end took it.
  bool Send(const std::string& bytes);
  /// Sends them again and again until the other end takes no more for half a second, or has taken `most`. How many it
  /// has taken, or the kernel for it.
  std::size_t Flood(const std::string& bytes, std::size_t most);
  /// What has come, waiting for at least one byte; empty where the other end closes, or nothing comes within kPatience.
  std::string Receive();
  /// All until the other end closes.
  std::string ReceiveAll();
  /// Whether the other end has closed, or does within `patience`.
  bool IsClosed(std::chrono::milliseconds patience);

 private:
  int socket_;
};

/// Asks with a header of these lines besides the request line; the whole answer.
std::string AskHttp(std::uint16_t port, const std::string& target,
                    std::map<std::string, std::string> headers = {{"Host", "localhost"}});

/// A client of WebSocket that was written from RFC 6455 alone, without the library that the viewer uses.
class WebSocketClient {
 public:
  WebSocketClient(std::uint16_t port, const std::string& target, const std::string& subprotocol,
                  const std::string& more_headers = "");

  /// The first line of the answer, as "HTTP/1.1 101 Switching Protocols".
  const std::string& status() const { return status_; }
  const std::string& header() const { return header_; }

  struct Message {
    bool is_text = false;
    std::string bytes;
  };
  /// The next message; nothing where the viewer closes or says nothing within kPatience. Pings are answered.
  std::optional<Message> Receive();

  void SendText(const std::string& text) { SendFrame(0x81, text); }
  /// first_byte: FIN and opcode.
  void SendFrame(std::uint8_t first_byte, const std::string& payload);
  TcpClient& tcp() { return tcp_; }

 private:
  /// The first `size` bytes of what comes; nothing where it ends before.
  std::optional<std::string> Take(std::size_t size);

  TcpClient tcp_;
  std::string status_;
  std::string header_;
  std::string buffer_;
};

/// A map_viewer on a port of its own.
class Viewer {
 public:
  Viewer(std::vector<std::string> arguments, const TemporaryFolder& folder);

  bool AwaitReady() { return process_.AwaitReady(); }
  std::uint16_t port() const;
  Process& process() { return process_; }

 private:
  Process process_;
};

}  // namespace crsm
