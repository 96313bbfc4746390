// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/tcp_link.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "casd/transport/stream_writer.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {
namespace {

/// No text begins with either of the two bytes, nor do HTTP, WebSocket and TLS.
bool may_begin_packet(std::uint8_t byte) { return byte == mav::kStartV1 || byte == mav::kStartV2; }

constexpr std::size_t kReadBytes = 64 * 1024;
constexpr auto kConnectPatience = std::chrono::seconds(3);
/// A connection that ends sooner counts as a failed attempt: the back-off goes on.
constexpr auto kLeastUptime = std::chrono::seconds(1);
/// A peer that takes nothing so long is given up.
constexpr auto kStallPatience = std::chrono::seconds(5);
constexpr const char* kStopped = "stopped reading";
constexpr const char* kSilent = "never sent a packet: made room for another client";
constexpr const char* kNoMavlink =
    "begins with no MAVLink packet (a browser, perhaps): closed unread";

/// Options of every TCP connection: no delay, dead peers found within seconds.
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

}  // namespace

TcpLink::TcpLink(LinkContext context)
    : core_(std::move(context)),
      port_(core_.make_port()),
      parser_(make_parser()),
      buffer_(kReadBytes) {}

void TcpLink::watch(PollSet& set, base::RunTime) {
  if (connecting_) {
    poll_entry_ = set.add(fd_, POLLOUT);
    return set.wake_by(connect_deadline_);
  }
  if (!fd_) return set.wake_by(core_.backoff().next());
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(pause_.due());
  set.wake_by(core_.next_second());
}

void TcpLink::serve(const PollSet& set, base::RunTime now) {
  if (connecting_) {
    if (set.revents(poll_entry_) != 0) return finish_connect(now);
    if (now >= connect_deadline_) try_next("no answer from " + core_.config().remote, now);
    return;
  }
  if (!fd_) {
    if (core_.backoff().due(now)) connect(now);
    return;
  }
  serve_connected(set.revents(poll_entry_), now);
}

void TcpLink::serve_connected(short events, base::RunTime now) {
  if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) read(now);
  if (fd_ && port_->broken()) close("connection lost", now);
  if (fd_ && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
  if (pause_.due() <= now) {
    pause_.release(core_.ingress(), parser_, [&](const mav::PacketView& packet) {
      core_.ingress().take_packet(packet, now);
    });
    core_.ingress().deliver(now);
  }
  if (core_.second_due(now)) core_.on_second(now);
  const auto stuck = port_->stuck_since();
  if (fd_ && stuck && now - *stuck > kStallPatience) close("the peer stopped reading", now);
}

void TcpLink::connect(base::RunTime now) {
  if (!find_addresses(now)) return;
  tried_ = 0;
  connect_to(remote_.addresses().front(), now);
}

/// Looks the name up at each attempt, because it may stand for other addresses now.
bool TcpLink::find_addresses(base::RunTime now) {
  if (!looking_up_) remote_ = AddressLookup(core_.config().remote);
  const AddressLookup::State state = remote_.state();
  looking_up_ = state == AddressLookup::State::kPending;
  if (looking_up_) core_.backoff().failed(now);
  if (state == AddressLookup::State::kFailed) core_.went_down(remote_.error(), now);
  return state == AddressLookup::State::kFound;
}

void TcpLink::connect_to(const SocketAddress& address, base::RunTime now) {
  ++tried_;
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
    return try_next(core_.config().remote + ": " + base::error_text(errno), now);
  }
  fd_ = OpenDescriptor(connecting_.get());
  connect_deadline_ = now + kConnectPatience;
}

void TcpLink::finish_connect(base::RunTime now) {
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(connecting_.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) return try_next(core_.config().remote + ": " + base::error_text(error), now);
  base::Descriptor connected = std::move(connecting_);
  const OpenDescriptor opened = std::exchange(fd_, {});  // until the port has the connection
  parser_.reset();
  port_->attach(std::make_unique<StreamWriter>(std::move(connected), StreamWriter::Kind::kSocket),
                now);
  fd_ = opened;
  connected_at_ = now;
  before_connection_ = core_.backoff();
  core_.went_up(core_.config().remote);
}

/// Goes on with the name's next address; gives up after the last one.
void TcpLink::try_next(const std::string& reason, base::RunTime now) {
  connecting_.reset();
  fd_ = {};
  if (tried_ < remote_.addresses().size()) return connect_to(remote_.addresses()[tried_], now);
  close(reason, now);
}

void TcpLink::read(base::RunTime now) {
  const ssize_t count = ::recv(fd_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  if (count > 0) {
    core_.ingress().take(parser_, {buffer_.data(), static_cast<std::size_t>(count)}, now);
    core_.ingress().deliver(now);
    pause_.after_read(parser_, now);
    return;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  close(count == 0 ? "the peer closed" : base::error_text(errno), now);
}

void TcpLink::close(const std::string& reason, base::RunTime now) {
  fd_ = {};
  port_->detach(now);
  const auto since = std::exchange(connected_at_, std::nullopt);
  if (since && now - *since < kLeastUptime) core_.backoff() = before_connection_;
  core_.went_down(reason, now);
}

void TcpFanOut::deliver(std::span<const PacketRef> packets, base::RunTime now) {
  constexpr std::size_t kChunk = 256;
  const base::SharedLock lock(mutex_);
  if (present_ == 0) return;
  while (!packets.empty()) {
    const auto chunk = packets.first(std::min(packets.size(), kChunk));
    std::array<SlotMask, kChunk> wanted;
    SlotMask clients = 0;
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      clients |= wanted[i] = wanted_by(*chunk[i].info);
    }
    for_each_slot(clients, [&](std::uint8_t client) CAS_REQUIRES_SHARED(mutex_) {
      deliver_to(client, chunk, wanted, now);
    });
    packets = packets.subspan(chunk.size());
  }
}

// In runs of packets that this client is to have.
void TcpFanOut::deliver_to(std::uint8_t client, std::span<const PacketRef> packets,
                           std::span<const SlotMask> wanted, base::RunTime now) {
  const SlotMask own = slot_bit(client);
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= packets.size(); ++i) {
    if (i < packets.size() && (wanted[i] & own) != 0) continue;
    if (i > begin) clients_[client]->deliver(packets.subspan(begin, i - begin), now);
    begin = i + 1;
  }
}

void TcpFanOut::set_client(PeerId client, std::shared_ptr<TxPort> port) {
  const base::ExclusiveLock lock(mutex_);
  clients_[client.slot] = std::move(port);
  serials_[client.slot] = client.serial;
  present_ |= slot_bit(client.slot);
}

void TcpFanOut::remove_client(std::uint8_t client, DropCause cause) {
  const base::ExclusiveLock lock(mutex_);
  routes_.forget(client);
  clients_[client]->detach(base::steady_now(), cause);
  clients_[client].reset();
  present_ &= ~slot_bit(client);
}

SlotMask TcpFanOut::wanted_by(const PacketInfo& info) const {
  if (info.to_all_peers) return present_;
  SlotMask clients = present_ & routes_.links_to(info.target);
  if (info.from == own_ && info.from_peer < kSlots) clients &= ~slot_bit(info.from_peer);
  if (info.to_serial == 0) return clients;
  for_each_slot(clients, [&](std::uint8_t client) CAS_REQUIRES_SHARED(mutex_) {
    if (serials_[client] != info.to_serial) clients &= ~slot_bit(client);
  });
  return clients;
}

TcpServerLink::TcpServerLink(LinkContext context)
    : core_(std::move(context)),
      fan_out_(std::make_shared<TcpFanOut>(core_.id())),
      buffer_(kReadBytes) {}

TcpServerLink::~TcpServerLink() {
  for (const auto& client : clients_) fan_out_->remove_client(client->slot, DropCause::kClosed);
}

void TcpServerLink::watch(PollSet& set, base::RunTime now) {
  if (listeners_.empty()) return set.wake_by(core_.backoff().next());
  for (Listener& listener : listeners_) {
    listener.poll_entry =
        set.add(now < accept_again_ ? OpenDescriptor() : listener.watched, POLLIN);
  }
  for (const auto& client : clients_) {
    const bool wants_room = client->port->wants_room();
    client->poll_entry =
        set.add(client->fd, static_cast<short>(POLLIN | (wants_room ? POLLOUT : 0)));
    set.wake_by(client->port->due());
    set.wake_by(client->pause.due());
  }
  set.wake_by(core_.next_second());
}

void TcpServerLink::serve(const PollSet& set, base::RunTime now) {
  if (listeners_.empty()) {
    if (core_.backoff().due(now)) listen(now);
    return;
  }
  for (std::size_t i = clients_.size(); i-- > 0;) {
    const auto trouble = serve_client(*clients_[i], set.revents(clients_[i]->poll_entry), now);
    if (trouble) remove(i, *trouble, now);
  }
  for (const Listener& listener : listeners_) {
    if ((set.revents(listener.poll_entry) & POLLIN) != 0) accept(listener.socket.get(), now);
  }
  if (!core_.second_due(now)) return;
  core_.on_second(now);
  for (const auto& client : clients_) fan_out_->routes().expire(client->slot, now);
}

void TcpServerLink::listen(base::RunTime now) {
  if (!looking_up_) local_ = AddressLookup(core_.config().local);
  looking_up_ = local_.state() == AddressLookup::State::kPending;
  if (looking_up_) return core_.backoff().failed(now);
  if (local_.state() == AddressLookup::State::kFailed) return core_.went_down(local_.error(), now);

  OpenSockets open = open_at_each(
      local_.addresses(), [&](const SocketAddress& address) { return open_listener(address); });
  if (open.sockets.empty()) {
    return core_.went_down(core_.config().local + ": " + base::error_text(open.error), now);
  }
  core_.went_up(to_text(numbers_of(open.sockets)));
  for (base::Descriptor& socket : open.sockets) {
    const OpenDescriptor watched(socket.get());
    listeners_.push_back({.socket = std::move(socket), .watched = watched});
  }
}

/// @return empty with errno
base::Descriptor TcpServerLink::open_listener(const SocketAddress& address) const {
  base::Descriptor socket(
      ::socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int on = 1;
  const std::string& interface = core_.config().interface;
  const bool bound = socket &&
                     ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
                     (interface.empty() ||
                      ::setsockopt(socket.get(), SOL_SOCKET, SO_BINDTODEVICE, interface.c_str(),
                                   static_cast<socklen_t>(interface.size())) == 0) &&
                     ::bind(socket.get(), address.get(), address.size) == 0 &&
                     ::listen(socket.get(), SOMAXCONN) == 0;
  return bound ? std::move(socket) : base::Descriptor();
}

void TcpServerLink::accept(int listener, base::RunTime now) {
  SocketAddress from;
  from.size = sizeof from.storage;
  base::Descriptor socket(::accept4(listener, reinterpret_cast<sockaddr*>(&from.storage),
                                    &from.size, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket) {
    // Out of descriptors or memory: who waits at the door must not keep us busy.
    if (errno != EAGAIN && errno != ECONNABORTED) accept_again_ = now + std::chrono::seconds(1);
    return;
  }
  const std::string name = to_text(from);
  if (!make_place(now)) {
    core_.counters().rx.foreign.add();
    return log_thinned(name + " finds no room", now);
  }
  prepare_tcp(socket.get());
  clients_.reserve(clients_.size() + 1);
  auto client = std::make_unique<Client>();
  client->slot = static_cast<std::uint8_t>(std::countr_one(slots_));
  client->serial = ++serials_;
  client->fd = OpenDescriptor(socket.get());
  client->name = name;
  client->port = core_.make_port();
  client->port->attach(
      std::make_unique<StreamWriter>(std::move(socket), StreamWriter::Kind::kSocket), now);
  slots_ |= slot_bit(client->slot);
  fan_out_->set_client({client->slot, client->serial}, client->port);
  clients_.push_back(std::move(client));
  core_.counters().peers.set(clients_.size());
  log_thinned(name + " connected", now);
}

bool TcpServerLink::make_place(base::RunTime now) {
  if (static_cast<int>(clients_.size()) < core_.config().max_peers) return true;
  const auto silent =
      std::ranges::find_if(clients_, [](const auto& client) { return !client->was_heard; });
  if (silent == clients_.end()) return false;
  core_.counters().rx.foreign.add();
  remove(static_cast<std::size_t>(silent - clients_.begin()), kSilent, now);
  return true;
}

std::optional<std::string> TcpServerLink::serve_client(Client& client, short events,
                                                       base::RunTime now) {
  if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) {
    if (auto trouble = read(client, now)) return trouble;
  }
  if (client.port->broken()) return "connection lost";
  if (client.pause.due() <= now) {
    client.pause.release(core_.ingress(), client.parser,
                         [&](const mav::PacketView& packet) { take_packet(client, packet, now); });
    core_.ingress().deliver(now);
  }
  if ((events & POLLOUT) != 0 || client.port->due() <= now) client.port->carry_on(now);
  const auto stuck = client.port->stuck_since();
  if (stuck && now - *stuck > kStallPatience) return kStopped;
  return std::nullopt;
}

std::optional<std::string> TcpServerLink::read(Client& client, base::RunTime now) {
  const ssize_t count = ::recv(client.fd.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  if (count > 0) {
    const std::span bytes(buffer_.data(), static_cast<std::size_t>(count));
    if (!client.speaks_mavlink && !may_begin_packet(bytes.front())) return kNoMavlink;
    client.speaks_mavlink = true;
    core_.ingress().parse_stream(client.parser, bytes, [&](const mav::PacketView& packet) {
      take_packet(client, packet, now);
    });
    core_.ingress().deliver(now);
    client.pause.after_read(client.parser, now);
    return std::nullopt;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  return count == 0 ? std::string("closed") : base::error_text(errno);
}

void TcpServerLink::take_packet(Client& client, const mav::PacketView& packet, base::RunTime now) {
  client.was_heard = true;
  fan_out_->routes().learn(client.slot, packet.source, now, comes_rarely(packet.message_id));
  core_.ingress().take_packet(packet, now, {client.slot, client.serial});
}

void TcpServerLink::remove(std::size_t index, const std::string& reason, base::RunTime now) {
  const Client& client = *clients_[index];
  const bool stalled = reason == kStopped;
  fan_out_->remove_client(client.slot, stalled ? DropCause::kStalled : DropCause::kClosed);
  slots_ &= ~slot_bit(client.slot);
  log_removal(client.name, reason, now);
  clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(index));
  core_.counters().peers.set(clients_.size());
}

/// Clients that speak no MAVLink get one line in all: a page can open many.
void TcpServerLink::log_removal(const std::string& client, const std::string& reason,
                                base::RunTime now) {
  const std::string line = client + " " + reason;
  if (reason != kNoMavlink) return log_thinned(line, now);
  core_.counters().rx.foreign.add();
  const std::string whole = "link " + core_.config().name + ": " + line;
  if (std::exchange(told_of_strangers_, true)) return base::log::debug(whole);
  base::log::warn(whole + "; more of them are only counted (foreign)");
}

void TcpServerLink::log_thinned(const std::string& line, base::RunTime now) {
  const std::string whole = "link " + core_.config().name + ": " + line;
  switch (thinning_.on_line(now)) {
    case LogThinning::Verdict::kWrite:
      return base::log::info(whole);
    case LogThinning::Verdict::kLast:
      return base::log::info(whole +
                             "; clients come and go: more lines of this minute are left out");
    case LogThinning::Verdict::kLeaveOut:
      return base::log::debug(whole);
  }
}

}  // namespace cas::casd
