// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/tcp_link.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>

#include <cerrno>
#include <chrono>
#include <utility>

#include "casd/transport/stream_writer.hpp"

namespace cas::casd {
namespace {

constexpr std::size_t kReadBytes = 64 * 1024;
constexpr auto kConnectPatience = std::chrono::seconds(3);
/// A peer that takes nothing so long is given up.
constexpr auto kStallPatience = std::chrono::seconds(5);

}  // namespace

void prepare_tcp(int fd) {
  const int on = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ::setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  const int probe_s = 2;
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &probe_s, sizeof probe_s);
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &probe_s, sizeof probe_s);
  const int probes = 3;
  ::setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
  const unsigned unacknowledged_ms = 10'000;  // a peer that stopped reading is ours to find first
  ::setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &unacknowledged_ms, sizeof unacknowledged_ms);
  // What lies in the kernel's buffer can be neither dropped nor overtaken: keep it small.
  const int buffer_bytes = 64 * 1024;
  ::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer_bytes, sizeof buffer_bytes);
  // Room is announced only once nearly all of it is on its way.
  const int unsent_bytes = 16 * 1024;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent_bytes, sizeof unsent_bytes);
}

TcpLink::TcpLink(LinkContext context)
    : core_(std::move(context)),
      port_(core_.make_port()),
      parser_(make_parser()),
      buffer_(kReadBytes) {}

void TcpLink::watch(PollSet& set, base::RunTime) {
  if (connecting_) {
    poll_entry_ = set.add(connecting_.get(), POLLOUT);
    return set.wake_by(connect_deadline_);
  }
  if (fd_ < 0) return set.wake_by(core_.backoff().next());
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(core_.next_second());
}

void TcpLink::serve(const PollSet& set, base::RunTime now) {
  if (connecting_) {
    if (set.revents(poll_entry_) != 0) return finish_connect(now);
    if (now >= connect_deadline_) {
      connecting_.reset();
      core_.went_down("no answer from " + core_.config().remote, now);
    }
    return;
  }
  if (fd_ < 0) {
    if (core_.backoff().due(now)) connect(now);
    return;
  }
  serve_connected(set.revents(poll_entry_), now);
}

void TcpLink::serve_connected(short events, base::RunTime now) {
  if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) read(now);
  if (fd_ >= 0 && port_->broken()) close("connection lost", now);
  if (fd_ >= 0 && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
  if (core_.second_due(now)) core_.on_second(now);
  const auto stuck = port_->stuck_since();
  if (fd_ >= 0 && stuck && now - *stuck > kStallPatience) close("the peer stopped reading", now);
}

void TcpLink::connect(base::RunTime now) {
  if (!looking_up_) remote_ = AddressLookup(core_.config().remote);
  looking_up_ = remote_.state() == AddressLookup::State::kPending;
  if (looking_up_) return core_.backoff().failed(now);
  if (remote_.state() == AddressLookup::State::kFailed) {
    return core_.went_down(remote_.error(), now);
  }
  const SocketAddress& address = remote_.address();
  connecting_ =
      base::Descriptor(::socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const std::string& interface = core_.config().interface;
  const bool bound = connecting_ && (interface.empty() ||
                                     ::setsockopt(connecting_.get(), SOL_SOCKET, SO_BINDTODEVICE,
                                                  interface.c_str(),
                                                  static_cast<socklen_t>(interface.size())) == 0);
  if (bound) prepare_tcp(connecting_.get());
  if (!bound ||
      (::connect(connecting_.get(), address.get(), address.size) != 0 && errno != EINPROGRESS)) {
    const int error = errno;
    connecting_.reset();
    return core_.went_down(core_.config().remote + ": " + error_text(error), now);
  }
  connect_deadline_ = now + kConnectPatience;
}

void TcpLink::finish_connect(base::RunTime now) {
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(connecting_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) {
    connecting_.reset();
    return core_.went_down(core_.config().remote + ": " + error_text(error), now);
  }
  base::Descriptor connected = std::move(connecting_);
  fd_ = connected.get();
  parser_.reset();
  port_->attach(std::make_unique<StreamWriter>(std::move(connected), StreamWriter::Kind::kSocket));
  core_.went_up(core_.config().remote);
}

void TcpLink::read(base::RunTime now) {
  const ssize_t count = ::recv(fd_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  if (count > 0) {
    core_.ingress().take(parser_, {buffer_.data(), static_cast<std::size_t>(count)}, now);
    core_.ingress().deliver(now);
    return;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  close(count == 0 ? "the peer closed" : error_text(errno), now);
}

void TcpLink::close(const std::string& reason, base::RunTime now) {
  fd_ = -1;
  port_->detach();
  core_.went_down(reason, now);
}

}  // namespace cas::casd
