#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "services/base/status.hpp"
#include "services/map_viewer/access.hpp"
#include "services/map_viewer/download.hpp"
#include "services/map_viewer/feed.hpp"

namespace crsm {

/// What a client asks for, as its header says it.
struct WebRequest {
  std::string method;
  std::string target;
  std::string host;
  std::optional<std::string> origin;
  bool is_upgrade = false;                ///< to WebSocket
  std::vector<std::string> subprotocols;  ///< of it, that the client knows
  std::string fetch_site = {};            ///< Sec-Fetch-Site, which says whose page asks; empty where it is not said
};

/// A page, a file of it, or what is wrong with a request.
struct WebPage {
  unsigned status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::string body;
};

/// What is wrong with a request, in a line.
inline WebPage Refuse(unsigned status, const std::string& why) { return {status, WebPage().content_type, why + "\n"}; }

/// A client that is told things from now on, by WebSocket.
struct WebFeed {
  std::string subprotocol;
  std::unique_ptr<Feed> feed;
};

/// A file that a client is to keep.
struct WebFile {
  std::string name;
  std::string content_type;
  std::shared_ptr<const Download> bytes;
};

using WebReply = std::variant<WebPage, WebFile>;

/// A reply that takes its time, and is made elsewhere. It is asked for now and then, as long as the client is there.
struct WebLater {
  std::function<std::optional<WebReply>()> poll;
};

using WebAnswer = std::variant<WebPage, WebFile, WebLater, WebFeed>;

/// Serves pages by HTTP and feeds by WebSocket, on one port and in the thread that calls Serve. It believes nobody:
/// connections, sizes and times are limited, and who does not take what is sent is told the newest later or is closed.
class WebServer {
 public:
  static constexpr std::size_t kMostConnections = 64;
  static constexpr std::size_t kMostHeaderBytes = 8192;
  static constexpr std::size_t kMostMessageBytes = 65536;     ///< from a client
  static constexpr int kMostMessagesPerSecond = 200;          ///< from a client
  static constexpr std::size_t kMostBytesPerSecond = 131072;  ///< that are read of a client: more has to wait
  static constexpr auto kRequestPatience = std::chrono::seconds(5);
  static constexpr auto kSilencePatience = std::chrono::seconds(10);  ///< with a client that answers no ping

  using Answer = std::function<WebAnswer(const WebRequest&)>;

  /// Throws std::runtime_error that names --http where nothing can listen there. Counts into `counters`.
  WebServer(const HttpAddress& address, Answer answer, Counters& counters);
  ~WebServer();

  /// Where it listens; the port is known now.
  const HttpAddress& address() const;

  /// How many clients are fed.
  std::size_t num_feeds() const;

  /// Tells the clients what is new, and answers requests as they come, for as long; 0: those that are there.
  void Serve(std::chrono::milliseconds duration);

  /// Takes over a socket whose other end is a client.
  void Adopt(int descriptor);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace crsm
