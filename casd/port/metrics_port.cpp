// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/metrics_port.hpp"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>
#include <list>
#include <memory>
#include <utility>
#include <vector>

#include "base/os/thread.hpp"
#include "base/rpc/io_thread.hpp"
#include "base/rpc/listener.hpp"
#include "base/time/clock.hpp"

namespace cas::casd {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using base::rpc::Listener;
using Stream = beast::basic_stream<asio::generic::stream_protocol, asio::any_io_executor,
                                   beast::unlimited_rate_policy>;

/// Takes the page, now or later.
using TakePage = std::function<void(const std::string& page)>;
using AskPage = std::function<void(TakePage)>;

constexpr std::size_t kMaxClients = 16;
constexpr double kMaxClients_s = 1000;  // and as many at once
/// How long a page is used again.
constexpr auto kPageLife = std::chrono::milliseconds(250);
constexpr auto kAnswerTime = std::chrono::seconds(2);
constexpr std::size_t kMaxHeaderBytes = 8 * 1024;
constexpr auto kPatience = std::chrono::seconds(10);

/// One request, one answer, then the connection ends.
class HttpSession final : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Listener::StreamSocket socket, AskPage ask_page,
              std::function<void(HttpSession*)> on_end)
      : stream_(std::move(socket)), ask_page_(std::move(ask_page)), on_end_(std::move(on_end)) {
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
      return ask_page_([self = shared_from_this()](const std::string& page) {
        self->response_.body() = page;
        self->send();
      });
    }
    send();
  }

  void send() {
    response_.prepare_payload();
    if (parser_.get().method() == http::verb::head) response_.body().clear();
    stream_.expires_after(kPatience);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code, std::size_t) {
                        beast::error_code ignored;
                        self->stream_.socket().shutdown(asio::socket_base::shutdown_send, ignored);
                      });
  }

  Stream stream_;
  AskPage ask_page_;
  std::function<void(HttpSession*)> on_end_;
  beast::flat_buffer buffer_{kMaxHeaderBytes};
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

/// Everything runs on the thread of `io`, but for listen() before it starts.
struct MetricsPort::Impl : std::enable_shared_from_this<MetricsPort::Impl> {
  explicit Impl(Ask ask_figures) : ask(std::move(ask_figures)) {}

  void on_client(Listener::StreamSocket socket) {
    // The oldest is slow to ask or to read: it gives way.
    if (sessions.size() >= kMaxClients) {
      sessions.front()->close();
      sessions.pop_front();
    }
    const auto end = [weak = weak_from_this()](HttpSession* session) {
      if (const auto self = weak.lock()) self->sessions.remove(session);
    };
    const auto ask_page = [weak = weak_from_this()](TakePage take) {
      if (const auto self = weak.lock()) self->answer(std::move(take));
    };
    const auto session = std::make_shared<HttpSession>(std::move(socket), ask_page, end);
    sessions.push_back(session.get());
    session->start();
  }

  /// Answers with the current page, or with the next one once it is made.
  void answer(TakePage take) {
    if (base::steady_now() < page_ends) return take(page);
    waiting.push_back(std::move(take));
    const base::RunTime now = base::steady_now();
    if (waiting.size() > 1 && now < ask_again) return;
    ask_again = now + kAnswerTime;
    ask([weak = weak_from_this()](MetricsSource figures) {
      const auto self = weak.lock();
      if (!self) return;
      asio::post(self->io.context(), [weak, figures = std::move(figures)] {
        if (const auto port = weak.lock()) port->make_page(figures);
      });
    });
  }

  void make_page(const MetricsSource& figures) {
    page = metrics_text(figures);
    page_ends = base::steady_now() + kPageLife;
    for (const TakePage& take : std::exchange(waiting, {})) take(page);
  }

  Ask ask;
  base::rpc::IoThread io;
  std::shared_ptr<Listener> listener;
  std::list<HttpSession*> sessions;  ///< in the order in which they came
  std::string page;
  base::RunTime page_ends{};
  base::RunTime ask_again{};  ///< an answer that has not come by then will not come
  std::vector<TakePage> waiting;
};

MetricsPort::MetricsPort(Ask ask) : impl_(std::make_shared<Impl>(std::move(ask))) {}

MetricsPort::~MetricsPort() { close(); }

std::uint16_t MetricsPort::listen(const std::string& address, std::uint16_t port) {
  base::rpc::ListeningSocket socket = base::rpc::open_tcp(address, port);
  const std::uint16_t bound = socket.port;
  impl_->listener = std::make_shared<Listener>(
      impl_->io.context(), std::move(socket),
      [impl = impl_.get()](Listener::StreamSocket client) { impl->on_client(std::move(client)); },
      kMaxClients_s);
  impl_->io.start([] { base::lower_this_thread("metrics"); },
                  [impl = impl_.get()] { impl->listener->start(); });
  return bound;
}

void MetricsPort::close() {
  if (!impl_->io.started()) return;
  impl_->io.finish([impl = impl_.get()] {
    impl->listener->close();
    for (HttpSession* session : impl->sessions) session->close();
    impl->waiting.clear();
    impl->io.context().stop();
  });
}

}  // namespace cas::casd
