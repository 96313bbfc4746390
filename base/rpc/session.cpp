// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/session.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>
#include <vector>

namespace cas::base::rpc {
namespace {

namespace asio = boost::asio;
using AsioError = boost::system::error_code;

constexpr std::size_t kLinesPerWrite = 32;            // gathered into one system call
constexpr auto kFlushTime = std::chrono::seconds(5);  // for a client that ends without reading
constexpr auto kDrainTime = std::chrono::seconds(1);

/// Cost of reading a line and writing its answer, beside the call itself.
constexpr Duration kSocketCost = std::chrono::microseconds(30);

/// CPU time that the calling thread has used.
Duration processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + Duration(time.tv_nsec);
}

struct PeerAddress {
  std::string name;  // "127.0.0.1:40412", "[::1]:40412", or the user of a Unix socket
  ClientOrigin origin;
};

PeerAddress unix_peer(int fd) {
  ucred user{};
  socklen_t size = sizeof user;
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &user, &size) != 0) {
    return {"unix", {.share = "uid ?", .over_unix = true}};
  }
  return {"unix:uid " + std::to_string(user.uid), unix_origin(user.uid, ::geteuid())};
}

PeerAddress peer_address(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getpeername(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return {"?", {.share = "?"}};
  }
  if (address.ss_family == AF_UNIX) return unix_peer(fd);
  const ClientOrigin origin = tcp_origin(reinterpret_cast<const sockaddr&>(address));
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  if (::getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(),
                    static_cast<socklen_t>(host.size()), port.data(),
                    static_cast<socklen_t>(port.size()), NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return {"?", origin};
  }
  const bool v6 = address.ss_family == AF_INET6;
  return {(v6 ? "[" : "") + std::string(host.data()) + (v6 ? "]:" : ":") + port.data(), origin};
}

}  // namespace

Session::Session(StreamSocket socket, std::shared_ptr<Dispatcher> dispatcher,
                 const ServerLimits& limits, std::shared_ptr<ServeBudget> budget,
                 std::function<void(const std::shared_ptr<Session>&)> on_closed)
    : socket_(std::move(socket)),
      deadline_(socket_.get_executor()),
      dispatcher_(std::move(dispatcher)),
      limits_(limits),
      pause_(socket_.get_executor()),
      rate_(limits.max_lines_s, steady_now()),
      budget_(std::move(budget)),
      on_closed_(std::move(on_closed)) {
  PeerAddress peer = peer_address(socket_.native_handle());
  name = std::move(peer.name);
  origin_ = std::move(peer.origin);
  proof.endpoint = server_endpoint(socket_.native_handle(), Prover::kServer);
}

void Session::start() {
  await_first_request();
  do_read();
}

// A silent client must not keep its place.
void Session::await_first_request() {
  deadline_.expires_after(limits_.first_request_time);
  deadline_.async_wait(guarded([](Session& self, const AsioError& error) {
    if (error || self.closed_ || self.finishing_ || self.asked_) return;
    if (self.authorised) {
      self.refuse(Refusal::kNoRequest, "no request came in time");
    } else {
      self.refuse(Refusal::kNoRequest, "no token came in time", kNotAuthorised);
    }
  }));
}

void Session::refuse(Refusal why, const std::string& message, int code) {
  refusal = why;
  deliver(Dispatcher::error_line(code, message));
  finish();
}

void Session::do_read() {
  asio::async_read_until(socket_, asio::dynamic_buffer(rx_, limits_.max_line_bytes), '\n',
                         guarded([](Session& self, const AsioError& error, std::size_t size) {
                           if (self.closed_ || self.finishing_) return;
                           if (error) return self.on_read_end(error == asio::error::not_found);
                           self.on_line(size);
                           if (!self.closed_ && !self.finishing_) self.read_at_rate();
                         }));
}

// A client above its rate is read more slowly and slows down no other. While all together exceed
// their share, each waits for its turn.
void Session::read_at_rate() {
  const RunTime now = steady_now();
  const Duration wait = std::max(rate_.take(now), budget_->spend(cost_, now));
  if (wait == Duration::zero()) return do_read();
  budget_->wait_begins();
  pause_.expires_after(wait);
  pause_.async_wait(guarded([](Session& self, const AsioError& error) {
    self.budget_->wait_ends();
    if (!error && !self.closed_ && !self.finishing_) self.do_read();
  }));
}

void Session::on_line(std::size_t size) {
  const std::string line = rx_.substr(0, size);
  rx_.erase(0, size);
  spoke_ = true;
  const std::shared_ptr<Dispatcher> dispatcher = dispatcher_;  // a method may close the server
  weight = 0;
  const Duration before = processor_time();
  const bool requests = dispatcher->handle(line, shared_from_this());
  const Duration spent = processor_time() - before + kSocketCost;
  cost_ = from_seconds(to_seconds(spent) * (weight > 0 ? weight : 1));
  if (asked_ || !requests || !authorised || closed_ || finishing_) return;
  asked_ = true;
  deadline_.cancel();
}

// The client has sent all it had (it may still read), broke off, or sent an endless line.
void Session::on_read_end(bool line_too_long) {
  if (line_too_long) {
    return refuse(Refusal::kNotJsonRpc,
                  "a line is longer than " + std::to_string(limits_.max_line_bytes) + " bytes",
                  kParseError);
  }
  if (!rx_.empty()) on_line(rx_.size());  // a last line without its newline
  finish();
}

void Session::deliver(std::string line) {
  line += '\n';
  deliver_shared(std::make_shared<const std::string>(std::move(line)));
}

std::size_t Session::room() const {
  const std::size_t taken = tx_bytes_ + held_bytes;
  return taken >= limits_.max_queued_bytes ? 0 : limits_.max_queued_bytes - taken;
}

void Session::deliver_shared(Line line) {
  if (closed_ || draining_) return;
  // A client that never reads pays alone.
  if (tx_.size() >= limits_.max_queued_replies || line->size() > room()) return close();
  tx_bytes_ += line->size();
  tx_.push_back(std::move(line));
  if (!writing_) do_write();
}

void Session::do_write() {
  writing_ = true;
  std::vector<asio::const_buffer> buffers;
  for (const Line& line : tx_) {
    if (buffers.size() == kLinesPerWrite) break;
    buffers.push_back(asio::buffer(*line));
  }
  const std::size_t lines = buffers.size();
  asio::async_write(socket_, buffers,
                    guarded([lines](Session& self, const AsioError& error, std::size_t) {
                      if (self.closed_) return;
                      if (error) return self.close();
                      self.on_written(lines);
                    }));
}

void Session::on_written(std::size_t lines) {
  for (std::size_t i = 0; i < lines; ++i) {
    tx_bytes_ -= tx_.front()->size();
    tx_.pop_front();
  }
  writing_ = false;
  if (!tx_.empty()) return do_write();
  end_when_idle();
}

void Session::on_call_ended() { end_when_idle(); }

void Session::finish() {
  if (closed_) return;
  finishing_ = true;
  topics.clear();
  end_when_idle();
}

void Session::end_when_idle() {
  if (closed_ || draining_ || !finishing_ || calls > 0) return;
  if (writing_) {
    if (!std::exchange(flushing_, true)) close_after(kFlushTime);
    return;
  }
  // Closing a socket that holds unread bytes would reset it and lose the last answer.
  draining_ = true;
  AsioError ignored;
  socket_.shutdown(asio::socket_base::shutdown_send, ignored);
  close_after(kDrainTime);
  do_drain();
}

void Session::close_after(std::chrono::seconds time) {
  deadline_.expires_after(time);
  deadline_.async_wait(guarded([](Session& self, const AsioError& error) {
    if (!error) self.close();
  }));
}

// A read of a line may still be under way, into rx_.
void Session::do_drain() {
  socket_.async_read_some(asio::buffer(drained_),
                          guarded([](Session& self, const AsioError& error, std::size_t) {
                            if (self.closed_) return;
                            if (error) return self.close();
                            self.do_drain();
                          }));
}

void Session::close() {
  if (std::exchange(closed_, true)) return;
  AsioError ignored;
  socket_.close(ignored);
  deadline_.cancel();
  pause_.cancel();
  topics.clear();
  batches.clear();
  dispatcher_ = nullptr;
  if (const auto on_closed = std::exchange(on_closed_, nullptr)) on_closed(shared_from_this());
}

}  // namespace cas::base::rpc
