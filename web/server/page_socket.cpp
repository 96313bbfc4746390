// SPDX-License-Identifier: BSD-3-Clause
#include <utility>  // Boost 1.74 counts on it under GCC 12

#include "web/server/page_socket.hpp"

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <deque>
#include <string>

#include "base/rpc/line_rate.hpp"
#include "base/time/clock.hpp"

namespace cas::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using Error = beast::error_code;

constexpr std::size_t kMaxFrame = 64 * 1024;  // from a page
constexpr std::size_t kMaxWaiting = 1024;     // frames to a page
constexpr std::size_t kMaxWaitingBytes = 1 << 20;
constexpr double kMaxFrames_s = 200;
constexpr auto kHelloTime = std::chrono::seconds(10);
constexpr auto kIdleTime = std::chrono::seconds(40);  // a ping goes at half of it
constexpr auto kHandshakeTime = std::chrono::seconds(10);
constexpr auto kCloseTime = std::chrono::seconds(2);  // for the other end to close as well
constexpr auto kWrongTokenTime = std::chrono::seconds(1);
constexpr int kWrongToken = 4403;

/// One page. Everything on the thread of its socket; no lock.
///
///   do_read --> client --> send() --> do_write <-+
///      ^----------+                      +-------+
class Session final : public std::enable_shared_from_this<Session> {
 public:
  Session(Stream stream, std::shared_ptr<StrangerPlaces::Place> place)
      : socket_(std::move(stream)),
        place_(std::move(place)),
        deadline_(socket_.get_executor()),
        pause_(socket_.get_executor()),
        rate_(kMaxFrames_s, base::steady_now()) {}

  void start(const Request& upgrade, PageHub& hub, const PageAccess& access) {
    const std::weak_ptr<Session> weak = weak_from_this();
    place_->leave = [weak] {
      if (const auto self = weak.lock()) self->end();
    };
    client_ = std::make_shared<PageClient>(
        hub, access, std::string(upgrade[beast::http::field::host]),
        PageClient::Socket{[weak](PageClient::Text text) {
                             if (const auto self = weak.lock()) self->send(std::move(text));
                           },
                           [weak](int code, const std::string& reason) {
                             if (const auto self = weak.lock()) self->close(code, reason);
                           },
                           [weak] {
                             if (const auto self = weak.lock()) self->refuse_token();
                           }});
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has its own deadlines
    socket_.set_option(websocket::stream_base::timeout{kHandshakeTime, kIdleTime, true});
    socket_.read_message_max(kMaxFrame);
    socket_.auto_fragment(false);  // a message is a frame
    socket_.async_accept(upgrade, [self = shared_from_this()](Error error) {
      if (error) return;
      self->open_ = true;
      self->await_hello();
      self->do_read();
    });
  }

 private:
  void await_hello() {
    deadline_.expires_after(kHelloTime);
    deadline_.async_wait([self = shared_from_this()](Error error) {
      if (!error && !self->client_->greeted()) self->close(websocket::policy_error, "no hello");
    });
  }

  void do_read() {
    socket_.async_read(rx_, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return self->end();
      self->on_frame();
    });
  }

  void on_frame() {
    if (!socket_.got_text()) {
      close(websocket::unknown_data, "text only");
      return do_read();  // for the other end's close
    }
    if (!closing_) client_->on_text(beast::buffers_to_string(rx_.data()));
    if (client_->greeted()) place_.reset();
    rx_.consume(rx_.size());
    const base::Duration wait = rate_.take(base::steady_now());
    if (wait <= base::Duration::zero() || closing_) return do_read();
    pause_.expires_after(std::chrono::duration_cast<asio::steady_timer::duration>(wait));
    pause_.async_wait([self = shared_from_this()](Error error) {
      if (!error) self->do_read();
    });
  }

  void send(PageClient::Text text) {
    if (!open_ || closing_) return;
    const bool waits = !tx_.empty();  // one long answer alone is no backlog
    if (tx_.size() >= kMaxWaiting || (waits && tx_bytes_ + text->size() > kMaxWaitingBytes)) {
      return close(websocket::try_again_later, "the page does not read");
    }
    tx_bytes_ += text->size();
    tx_.push_back(std::move(text));
    if (tx_.size() == 1) do_write();
  }

  void do_write() {
    socket_.text(true);
    socket_.async_write(asio::buffer(*tx_.front()),
                        [self = shared_from_this()](Error error, std::size_t) {
                          if (error) return self->end();
                          self->tx_bytes_ -= self->tx_.front()->size();
                          self->tx_.pop_front();
                          if (!self->tx_.empty() && !self->closing_) self->do_write();
                        });
  }

  void refuse_token() {
    deadline_.expires_after(kWrongTokenTime);
    deadline_.async_wait([self = shared_from_this()](Error error) {
      if (!error) self->close(kWrongToken, "the token is wrong");
    });
  }

  /// A page that does not close as well is gone after two seconds.
  void close(int code, const std::string& reason) {
    if (std::exchange(closing_, true)) return;
    socket_.async_close({static_cast<websocket::close_code>(code), reason},
                        [self = shared_from_this()](Error) { self->end(); });
    deadline_.expires_after(kCloseTime);
    deadline_.async_wait([self = shared_from_this()](Error error) {
      if (!error) self->end();
    });
  }

  void end() {
    closing_ = true;
    deadline_.cancel();
    pause_.cancel();
    beast::get_lowest_layer(socket_).close();
  }

  websocket::stream<Stream> socket_;
  std::shared_ptr<StrangerPlaces::Place> place_;
  std::shared_ptr<PageClient> client_;
  asio::steady_timer deadline_;  // of hello, then of the end
  asio::steady_timer pause_;     // until the next frame may be read
  base::rpc::LineRate rate_;
  beast::flat_buffer rx_;
  std::deque<PageClient::Text> tx_;
  std::size_t tx_bytes_ = 0;
  bool open_ = false;
  bool closing_ = false;
};

}  // namespace

void serve_page(Stream stream, const Request& upgrade, PageHub& hub, const PageAccess& access,
                std::shared_ptr<StrangerPlaces::Place> place) {
  std::make_shared<Session>(std::move(stream), std::move(place))->start(upgrade, hub, access);
}

}  // namespace cas::web
