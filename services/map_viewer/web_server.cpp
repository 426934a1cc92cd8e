#include "services/map_viewer/web_server.hpp"

#include <fmt/core.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <list>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace crsm {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Protocol = asio::generic::stream_protocol;
using Stream = beast::basic_stream<Protocol, asio::any_io_executor, beast::simple_rate_policy>;
using WebSocket = websocket::stream<Stream, false>;  // it never compresses
using Clock = std::chrono::steady_clock;

constexpr auto kLeastPause = std::chrono::milliseconds(16);  // between two messages: no screen shows more

/// What every answer says: nothing is fetched from elsewhere, and nobody puts the page into another one.
constexpr const char* kContentSecurityPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

WebRequest Describe(const http::request<http::empty_body>& header) {
  const auto Text = [](beast::string_view view) { return std::string(view.data(), view.size()); };
  WebRequest request{
      Text(header.method_string()), Text(header.target()), {}, {}, websocket::is_upgrade(header), {}, {}};
  // Of two headers that contradict each other neither is to be believed.
  if (header.count(http::field::host) == 1) request.host = Text(header[http::field::host]);
  if (header.count(http::field::origin) > 0) {
    request.origin = header.count(http::field::origin) == 1 ? Text(header[http::field::origin]) : "";
  }
  request.fetch_site = Text(header["Sec-Fetch-Site"]);
  for (const auto& word : http::token_list(header[http::field::sec_websocket_protocol])) {
    request.subprotocols.push_back(Text(word));
  }
  return request;
}

/// The header of every answer. A file_name is one to save it by.
std::string MakeHeader(unsigned status, const std::string& content_type, std::uint64_t size,
                       const std::string& file_name = "") {
  http::response<http::empty_body> response(static_cast<http::status>(status), 11);
  response.set(http::field::content_type, content_type);
  response.set("Content-Security-Policy", kContentSecurityPolicy);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(false);
  response.content_length(size);
  if (!file_name.empty()) {
    response.set(http::field::content_disposition, fmt::format("attachment; filename=\"{}\"", file_name));
  }
  std::ostringstream text;
  text << response.base();
  return text.str();
}

}  // namespace

/// A client, from its first byte to its last. It lives as long as something is under way for it.
class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Protocol::socket socket, const WebServer::Answer& answer, Counters& counters)
      : websocket_(Stream(std::move(socket))), answer_(answer), counters_(counters) {}

  void Start() {
    parser_.header_limit(WebServer::kMostHeaderBytes);
    parser_.body_limit(0);
    // Fragments without a byte make up no message that could be counted, nor one that is too large.
    stream().rate_policy().read_limit(WebServer::kMostBytesPerSecond);
    stream().expires_after(WebServer::kRequestPatience);
    http::async_read_header(stream(), buffer_, parser_,
                            [self = shared_from_this()](beast::error_code error, std::size_t) { self->Begin(error); });
  }

  bool is_fed() const { return feed_ && websocket_.is_open(); }

  /// Tells what is new, unless the message before is still under way, or went a moment ago.
  void Offer() {
    if (!is_fed() || writing_ || Clock::now() < next_offer_) return;
    auto message = feed_->Next();
    if (!message) return;
    next_offer_ = feed_->has_more() ? Clock::now() : Clock::now() + kLeastPause;
    outgoing_ = std::move(message->bytes);
    writing_ = true;
    counters_.Add("messages_sent");
    counters_.Add("bytes_sent", static_cast<std::int64_t>(outgoing_.size()));
    websocket_.text(message->is_text);
    websocket_.async_write(asio::buffer(outgoing_), [self = shared_from_this()](beast::error_code error, std::size_t) {
      self->writing_ = false;
      if (!error) self->Offer();
    });
  }

  void Close() { stream().close(); }

 private:
  Stream& stream() { return websocket_.next_layer(); }

  void Begin(beast::error_code error) {
    if (error == http::error::header_limit || error == http::error::body_limit) {
      return Respond({error == http::error::body_limit ? 413u : 431u, {}, "too large\n"});
    }
    if (error) return counters_.Add("requests_malformed");
    if (parser_.content_length().value_or(0) > 0 || parser_.chunked()) return Respond({413, {}, "too large\n"});
    WebAnswer answer = answer_(Describe(parser_.get()));
    if (auto* page = std::get_if<WebPage>(&answer)) return Respond(std::move(*page));
    if (auto* file = std::get_if<WebFile>(&answer)) return Respond(std::move(*file));
    if (auto* later = std::get_if<WebLater>(&answer)) return AwaitReply(std::move(*later));
    Upgrade(std::get<WebFeed>(std::move(answer)));
  }

  /// Looks for a reply until it is there, or the client is gone.
  void AwaitReply(WebLater later) {
    constexpr auto kLookEvery = std::chrono::milliseconds(50);
    stream().expires_never();
    timer_.expires_after(kLookEvery);
    timer_.async_wait([self = shared_from_this(), later = std::move(later)](beast::error_code error) mutable {
      if (error || self->IsGone()) return;
      auto reply = later.poll();
      if (!reply) return self->AwaitReply(std::move(later));
      std::visit([&](auto& answer) { self->Respond(std::move(answer)); }, *reply);
    });
  }

  bool IsGone() {
    char byte = 0;
    auto& socket = stream().socket();
    return !socket.is_open() || recv(socket.native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
  }

  void Respond(WebFile file) {
    counters_.Add("files_served");
    outgoing_ = MakeHeader(200, file.content_type, file.bytes->size(), file.name);
    if (!wants_header_only()) file_ = std::move(file.bytes);
    Send();
  }

  bool wants_header_only() const { return parser_.get().method() == http::verb::head; }

  /// Piece by piece: a file need not fit into memory, and a slow client has time for each piece.
  void SendRestOfFile() {
    constexpr std::uint64_t kPieceBytes = 1 << 16;
    if (!file_ || file_sent_ == file_->size()) return Shutdown();
    outgoing_.resize(std::min(kPieceBytes, file_->size() - file_sent_));
    try {
      file_->Read(file_sent_, {reinterpret_cast<std::uint8_t*>(outgoing_.data()), outgoing_.size()});
    } catch (const std::runtime_error&) {
      return Close();  // the client sees that bytes are missing
    }
    file_sent_ += outgoing_.size();
    counters_.Add("bytes_sent", static_cast<std::int64_t>(outgoing_.size()));
    Send();
  }

  /// What is outgoing, and then what is left of a file.
  void Send() {
    stream().expires_after(WebServer::kRequestPatience);
    asio::async_write(stream(), asio::buffer(outgoing_),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        error ? self->Close() : self->SendRestOfFile();
                      });
  }

  void Shutdown() {
    beast::error_code ignored;
    stream().socket().shutdown(asio::socket_base::shutdown_both, ignored);
  }

  void Respond(WebPage page) {
    counters_.Add(page.status < 400 ? "pages_served" : "requests_refused");
    if (page.content_type.empty()) page.content_type = WebPage().content_type;
    outgoing_ = MakeHeader(page.status, page.content_type, page.body.size());
    if (!wants_header_only()) outgoing_ += page.body;
    Send();
  }

  void Upgrade(WebFeed accepted) {
    stream().expires_never();  // the WebSocket has limits of its own
    websocket::stream_base::timeout limits;
    limits.handshake_timeout = WebServer::kRequestPatience;
    limits.idle_timeout = WebServer::kSilencePatience;
    limits.keep_alive_pings = true;
    websocket_.set_option(limits);
    websocket_.set_option(
        websocket::stream_base::decorator([subprotocol = accepted.subprotocol](websocket::response_type& response) {
          response.set(http::field::sec_websocket_protocol, subprotocol);
        }));
    websocket_.read_message_max(WebServer::kMostMessageBytes);
    websocket_.auto_fragment(false);
    feed_ = std::move(accepted.feed);
    // A client that floods with pings is no better than one that floods with messages.
    websocket_.control_callback([this](websocket::frame_type, beast::string_view) {
      if (!IsTooFast()) return;
      asio::post(websocket_.get_executor(), [self = shared_from_this()] { self->SendAway(); });
    });
    websocket_.async_accept(parser_.get(), [self = shared_from_this()](beast::error_code error) {
      if (error) return self->End();
      self->counters_.Add("clients_accepted");
      self->Offer();
      self->Hear();
    });
  }

  void Hear() {
    websocket_.async_read(incoming_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return self->End();
      const auto message = beast::buffers_to_string(self->incoming_.data());
      self->incoming_.consume(self->incoming_.size());
      if (self->IsTooFast() || !self->feed_->Hear(message, self->websocket_.got_text())) return self->SendAway();
      self->Offer();
      self->Hear();
    });
  }

  bool IsTooFast() {
    const auto now = Clock::now();
    if (now - second_began_ > std::chrono::seconds(1)) {
      second_began_ = now;
      num_heard_ = 0;
    }
    return ++num_heard_ > WebServer::kMostMessagesPerSecond;
  }

  void SendAway() {
    counters_.Add("clients_sent_away");
    Close();
    End();
  }

  void End() { feed_.reset(); }

  WebSocket websocket_;
  const WebServer::Answer& answer_;
  Counters& counters_;
  beast::flat_buffer buffer_{WebServer::kMostHeaderBytes + 1024};
  http::request_parser<http::empty_body> parser_;
  asio::steady_timer timer_{websocket_.get_executor()};
  std::shared_ptr<const Download> file_;
  std::uint64_t file_sent_ = 0;  ///< bytes
  std::unique_ptr<Feed> feed_;
  beast::flat_buffer incoming_;
  std::string outgoing_;
  bool writing_ = false;
  Clock::time_point next_offer_{};
  Clock::time_point second_began_{};
  int num_heard_ = 0;
};

class WebServer::Impl {
 public:
  Impl(const HttpAddress& address, Answer answer, Counters& counters)
      : address_(address), answer_(std::move(answer)), counters_(counters), acceptor_(context_) {
    try {
      while (!Listen({asio::ip::make_address(address_.address), address_.port})) ++address_.port;
    } catch (const boost::system::system_error& error) {
      throw std::runtime_error(fmt::format("--http {}: {}", FormatAuthority(address), error.code().message()));
    }
    address_.port = acceptor_.local_endpoint().port();
    Accept();
  }

  ~Impl() {
    for (const auto& client : LivingClients()) client->Close();
    context_.poll();  // what was under way ends
  }

  const HttpAddress& address() const { return address_; }

  std::size_t num_feeds() {
    const auto clients = LivingClients();
    return static_cast<std::size_t>(
        std::count_if(clients.begin(), clients.end(), [](const auto& client) { return client->is_fed(); }));
  }

  void Serve(std::chrono::milliseconds duration) {
    for (const auto& client : LivingClients()) client->Offer();
    context_.restart();
    duration.count() > 0 ? context_.run_for(duration) : context_.poll();
  }

  void Adopt(Protocol::socket socket) {
    if (!MakeRoom()) return counters_.Add("connections_refused");  // which closes it
    auto client = std::make_shared<Client>(std::move(socket), answer_, counters_);
    clients_.push_back(client);
    client->Start();
  }

  void Adopt(int descriptor) { Adopt(Protocol::socket(context_, Protocol(AF_UNIX, 0), descriptor)); }

 private:
  /// False if other programs use this port, and the next one may be free.
  bool Listen(const asio::ip::tcp::endpoint& endpoint) {
    constexpr std::uint16_t kLastPort = 65535;
    boost::system::error_code error;
    acceptor_.open(endpoint.protocol());
    acceptor_.set_option(asio::socket_base::reuse_address(true));
    if (endpoint.address() == asio::ip::address_v6::any()) acceptor_.set_option(asio::ip::v6_only(false));
    acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (!error) return true;
    acceptor_.close();
    if (error != asio::error::address_in_use || endpoint.port() == kLastPort) {
      throw boost::system::system_error(error);
    }
    return false;
  }

  void Accept() {
    acceptor_.async_accept([this](beast::error_code error, asio::ip::tcp::socket socket) {
      if (!error) {
        beast::error_code ignored;
        socket.set_option(asio::ip::tcp::no_delay(true), ignored);
        Adopt(std::move(socket));
        return Accept();
      }
      // No descriptors are left, say: the next moment may have some.
      pause_.expires_after(std::chrono::milliseconds(50));
      pause_.async_wait([this](beast::error_code) { Accept(); });
    });
  }

  /// Who connects and asks for nothing has to go before who asks at once. False where all are fed.
  bool MakeRoom() {
    const auto clients = LivingClients();
    if (clients.size() < kMostConnections) return true;
    const auto oldest =
        std::find_if(clients.begin(), clients.end(), [](const auto& client) { return !client->is_fed(); });
    if (oldest == clients.end()) return false;
    counters_.Add("connections_dropped");
    (*oldest)->Close();
    return true;
  }

  std::vector<std::shared_ptr<Client>> LivingClients() {
    std::vector<std::shared_ptr<Client>> living;
    std::erase_if(clients_, [&](const std::weak_ptr<Client>& client) {
      if (auto alive = client.lock()) return living.push_back(std::move(alive)), false;
      return true;
    });
    return living;
  }

  HttpAddress address_;
  Answer answer_;
  Counters& counters_;
  asio::io_context context_{1};
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer pause_{context_};
  std::list<std::weak_ptr<Client>> clients_;
};

WebServer::WebServer(const HttpAddress& address, Answer answer, Counters& counters)
    : impl_(std::make_unique<Impl>(address, std::move(answer), counters)) {}

WebServer::~WebServer() = default;
const HttpAddress& WebServer::address() const { return impl_->address(); }
std::size_t WebServer::num_feeds() const { return impl_->num_feeds(); }
void WebServer::Serve(std::chrono::milliseconds duration) { impl_->Serve(duration); }
void WebServer::Adopt(int descriptor) { impl_->Adopt(descriptor); }

}  // namespace crsm
