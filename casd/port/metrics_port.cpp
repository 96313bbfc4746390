// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/metrics_port.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <optional>
#include <set>
#include <utility>

#include "base/error.hpp"
#include "base/rpc/listener.hpp"

namespace cas::casd {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using base::rpc::Listener;
using Stream = beast::basic_stream<asio::generic::stream_protocol, asio::any_io_executor,
                                   beast::unlimited_rate_policy>;

constexpr std::size_t kMaxClients = 16;
constexpr std::size_t kMaxHeaderBytes = 8 * 1024;
constexpr auto kPatience = std::chrono::seconds(10);

/// One request, one answer, then the connection ends.
class HttpSession final : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Listener::StreamSocket socket, const MetricsPort::Text& text,
              std::function<void(HttpSession*)> on_end)
      : stream_(std::move(socket)), text_(text), on_end_(std::move(on_end)) {
    parser_.header_limit(kMaxHeaderBytes);
    parser_.body_limit(0);
  }
  ~HttpSession() { on_end_(this); }

  void start() {
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error) self->answer();
                     });
  }
  void close() { stream_.cancel(); }

 private:
  void answer() {
    const auto& request = parser_.get();
    response_.version(request.version());
    response_.keep_alive(false);
    response_.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      response_.result(http::status::method_not_allowed);
      response_.set(http::field::allow, "GET, HEAD");
    } else if (request.target() != "/metrics") {
      response_.result(http::status::not_found);
      response_.body() = "see /metrics\n";
    } else {
      response_.body() = text_();
    }
    response_.prepare_payload();
    if (request.method() == http::verb::head) response_.body().clear();
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code, std::size_t) {
                        beast::error_code ignored;
                        self->stream_.socket().shutdown(asio::socket_base::shutdown_send, ignored);
                      });
  }

  Stream stream_;
  const MetricsPort::Text& text_;
  std::function<void(HttpSession*)> on_end_;
  beast::flat_buffer buffer_{kMaxHeaderBytes};
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

struct MetricsPort::Impl : std::enable_shared_from_this<MetricsPort::Impl> {
  Impl(asio::io_context& context, Text body) : io(context), text(std::move(body)) {}

  void on_client(Listener::StreamSocket socket) {
    if (sessions.size() >= kMaxClients) return;  // closes it
    const auto end = [weak = weak_from_this()](HttpSession* session) {
      if (const auto self = weak.lock()) self->sessions.erase(session);
    };
    const auto session = std::make_shared<HttpSession>(std::move(socket), text, end);
    sessions.insert(session.get());
    session->start();
  }

  asio::io_context& io;
  Text text;
  std::shared_ptr<Listener> listener;
  std::set<HttpSession*> sessions;
};

MetricsPort::MetricsPort(asio::io_context& io, Text text)
    : impl_(std::make_shared<Impl>(io, std::move(text))) {}

MetricsPort::~MetricsPort() { close(); }

std::uint16_t MetricsPort::listen(const std::string& address, std::uint16_t port) {
  base::rpc::ListeningSocket socket = base::rpc::open_tcp(address, port);
  const std::uint16_t bound = socket.port;
  impl_->listener = std::make_shared<Listener>(
      impl_->io, std::move(socket),
      [this](Listener::StreamSocket client) { impl_->on_client(std::move(client)); });
  impl_->listener->start();
  return bound;
}

void MetricsPort::close() {
  if (impl_->listener) impl_->listener->close();
  for (HttpSession* session : impl_->sessions) session->close();
}

}  // namespace cas::casd
