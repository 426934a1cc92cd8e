#include "web_client.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <regex>
#include <stdexcept>

namespace crsm {
namespace {

/// Whether there is something to read, or the end, in time.
bool AwaitReadable(int socket, std::chrono::milliseconds patience) {
  pollfd waited{socket, POLLIN, 0};
  return poll(&waited, 1, static_cast<int>(patience.count())) == 1;
}

}  // namespace

TcpClient::TcpClient(std::uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    close(socket_);
    throw std::runtime_error(fmt::format("nobody listens on port {}", port));
  }
}

TcpClient::~TcpClient() { close(socket_); }

bool TcpClient::Send(const std::string& bytes) {
  return send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::size_t TcpClient::Flood(const std::string& bytes, std::size_t most) {
  std::size_t num_taken = 0;
  pollfd room{socket_, POLLOUT, 0};
  while (num_taken < most && poll(&room, 1, 500) == 1) {
    const std::size_t at = num_taken % bytes.size();
    const ssize_t count = send(socket_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count <= 0) break;
    num_taken += static_cast<std::size_t>(count);
  }
  return num_taken;
}

std::string TcpClient::Receive() {
  std::array<char, 65536> bytes;
  if (!AwaitReadable(socket_, kPatience)) return {};
  const ssize_t count = recv(socket_, bytes.data(), bytes.size(), 0);
  return count > 0 ? std::string(bytes.data(), static_cast<std::size_t>(count)) : std::string();
}

std::string TcpClient::ReceiveAll() {
  std::string all;
  for (std::string more = Receive(); !more.empty(); more = Receive()) all += more;
  return all;
}

bool TcpClient::IsClosed(std::chrono::milliseconds patience) {
  const auto give_up = std::chrono::steady_clock::now() + patience;
  std::array<char, 65536> ignored;
  while (std::chrono::steady_clock::now() < give_up) {
    if (AwaitReadable(socket_, std::chrono::milliseconds(20)) &&
        recv(socket_, ignored.data(), ignored.size(), 0) <= 0) {
      return true;
    }
  }
  return false;
}

std::string AskHttp(std::uint16_t port, const std::string& target, std::map<std::string, std::string> headers) {
  std::string request = fmt::format("GET {} HTTP/1.1\r\n", target);
  for (const auto& [name, value] : headers) request += fmt::format("{}: {}\r\n", name, value);
  TcpClient client(port);
  client.Send(request + "\r\n");
  return client.ReceiveAll();
}

WebSocketClient::WebSocketClient(std::uint16_t port, const std::string& target, const std::string& subprotocol,
                                 const std::string& more_headers)
    : tcp_(port) {
  tcp_.Send(
      fmt::format("GET {} HTTP/1.1\r\nHost: localhost:{}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                  "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                  "Sec-WebSocket-Protocol: {}\r\n{}\r\n",
                  target, port, subprotocol, more_headers));
  std::size_t end = std::string::npos;
  for (std::string more = tcp_.Receive(); !more.empty(); more = tcp_.Receive()) {
    buffer_ += more;
    end = buffer_.find("\r\n\r\n");
    if (end != std::string::npos) break;
  }
  if (end == std::string::npos) return;
  header_ = buffer_.substr(0, end);
  status_ = header_.substr(0, header_.find("\r\n"));
  buffer_.erase(0, end + 4);
}

std::optional<std::string> WebSocketClient::Take(std::size_t size) {
  while (buffer_.size() < size) {
    const std::string more = tcp_.Receive();
    if (more.empty()) return std::nullopt;
    buffer_ += more;
  }
  std::string taken = buffer_.substr(0, size);
  buffer_.erase(0, size);
  return taken;
}

std::optional<WebSocketClient::Message> WebSocketClient::Receive() {
  constexpr int kText = 1;
  constexpr int kBinary = 2;
  constexpr int kPing = 9;
  while (const auto start = Take(2)) {
    const int opcode = (*start)[0] & 0x0f;
    std::size_t size = (*start)[1] & 0x7f;
    if (size >= 126) {
      const auto longer = Take(size == 126 ? 2 : 8);
      if (!longer) return std::nullopt;
      size = 0;
      for (const char byte : *longer) size = size << 8 | static_cast<unsigned char>(byte);
    }
    auto payload = Take(size);
    if (!payload) return std::nullopt;
    if (opcode == kText || opcode == kBinary) return Message{opcode == kText, std::move(*payload)};
    if (opcode == kPing) SendFrame(0x8a, *payload);
  }
  return std::nullopt;
}

void WebSocketClient::SendFrame(std::uint8_t first_byte, const std::string& payload) {
  constexpr std::array<char, 4> kMask{0x12, 0x34, 0x56, 0x78};
  std::string frame{static_cast<char>(first_byte)};
  if (payload.size() < 126) {
    frame += static_cast<char>(0x80 | payload.size());
  } else {
    frame += static_cast<char>(0xff);
    for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(payload.size() >> shift & 0xff);
  }
  frame.append(kMask.begin(), kMask.end());
  for (std::size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ kMask[i % 4]);
  tcp_.Send(frame);
}

namespace {

std::vector<std::string> WithPort(std::vector<std::string> arguments) {
  if (std::find(arguments.begin(), arguments.end(), "--http") == arguments.end()) {
    arguments.insert(arguments.end(), {"--http", "127.0.0.1:0"});
  }
  return arguments;
}

}  // namespace

Viewer::Viewer(std::vector<std::string> arguments, const TemporaryFolder& folder)
    : process_("map_viewer", WithPort(std::move(arguments)), folder / "log") {}

std::uint16_t Viewer::port() const {
  std::smatch parts;
  const std::string said = process_.errors();
  if (!std::regex_search(said, parts, std::regex("http://[^/]*:([0-9]+)/")))
    throw std::runtime_error("no address: " + said);
  return static_cast<std::uint16_t>(std::stoi(parts[1]));
}

}  // namespace crsm
