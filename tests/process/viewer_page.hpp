#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "catch.hpp"
#include "map_viewer/page_client.hpp"
#include "services/map_viewer/page_feed.hpp"
#include "services/wire/conversions.hpp"
#include "web_client.hpp"

namespace crsm {

/// A page of one robot.
class Page {
 public:
  explicit Page(std::uint16_t port, const std::string& query = "robot=0")
      : socket_(port, "/live?" + query, PageFeed::kSubprotocol) {
    REQUIRE(socket_.status() == "HTTP/1.1 101 Switching Protocols");
  }

  /// Takes what comes until `condition` holds. False if it does not in time.
  bool Await(const std::function<bool()>& condition) {
    const auto give_up = std::chrono::steady_clock::now() + kPatience;
    while (!condition() && std::chrono::steady_clock::now() < give_up) {
      const auto message = socket_.Receive();
      if (!message) return false;
      num_bytes_ += message->bytes.size();
      client_.Take(message->bytes);
    }
    return condition();
  }

  const PageClient& operator*() const { return client_; }
  const PageClient* operator->() const { return &client_; }
  std::size_t num_bytes() const { return num_bytes_; }
  WebSocketClient& socket() { return socket_; }

 private:
  WebSocketClient socket_;
  PageClient client_;
  std::size_t num_bytes_ = 0;
};

inline scan_match_t MatchOf(std::int64_t utime) {
  ScanMatch match;
  match.utime = utime;
  match.fitness = 0.75;
  match.state = MatchState::kOk;
  return ToMessage(match);
}

}  // namespace crsm
