// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_link.hpp"

#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/transport/udp_socket.hpp"

namespace cas::casd {
namespace {

class UdpWriter final : public PacketWriter {
 public:
  /// @param to  nothing for a connected socket
  UdpWriter(base::Descriptor descriptor, const SocketAddress& to)
      : descriptor_(std::move(descriptor)), to_(to) {}

  WriteResult write(std::span<const PacketRef> packets) override {
    const auto result =
        sender_.send(descriptor_.get(), packets, to_.size == 0 ? nullptr : to_.get(), to_.size);
    return {.packets = result.packets,
            .broken = result.error != 0 && result.error != EAGAIN,
            .done = base::steady_now()};
  }
  int descriptor() const override { return descriptor_.get(); }

 private:
  base::Descriptor descriptor_;
  SocketAddress to_;
  DatagramSender sender_;
};

// Everybody's address, or that of a subnet: the kernel knows which addresses are one, and connects
// to them only with SO_BROADCAST.
bool is_broadcast(const SocketAddress& remote) {
  if (remote.is_ipv4_broadcast()) return true;
  const base::Descriptor probe(::socket(remote.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0));
  return probe && ::connect(probe.get(), remote.get(), remote.size) != 0 && errno == EACCES;
}

// Hears the group and speaks to it on this device; with an empty name on the one that the routes
// lead to.
bool join_group(int fd, const SocketAddress& group, const std::string& interface) {
  const unsigned device = interface.empty() ? 0 : ::if_nametoindex(interface.c_str());
  if (group.family() == AF_INET) {
    ip_mreqn request{};
    request.imr_multiaddr = reinterpret_cast<const sockaddr_in&>(group.storage).sin_addr;
    request.imr_ifindex = static_cast<int>(device);
    const int only_joined = 0;
    ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &only_joined, sizeof only_joined);
    return ::setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0 &&
           (device == 0 ||
            ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request) == 0);
  }
  ipv6_mreq request{};
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(group.storage);
  request.ipv6mr_multiaddr = v6.sin6_addr;
  request.ipv6mr_interface = device != 0 ? device : v6.sin6_scope_id;
  const unsigned through = request.ipv6mr_interface;
  return ::setsockopt(fd, IPPROTO_IPV6, IPV6_JOIN_GROUP, &request, sizeof request) == 0 &&
         (through == 0 ||
          ::setsockopt(fd, IPPROTO_IPV6, IPV6_MULTICAST_IF, &through, sizeof through) == 0);
}

// The address that our packets to `remote` bear, with the port of `fd`.
SocketAddress source_towards(const SocketAddress& remote, int fd, const std::string& interface) {
  const base::Descriptor probe(open_udp_socket(remote.family(), interface));
  const int on = 1;
  ::setsockopt(probe.get(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  if (!probe || ::connect(probe.get(), remote.get(), remote.size) != 0) return {};
  SocketAddress source = local_address(probe.get());
  const SocketAddress bound = local_address(fd);
  if (source.family() == AF_INET) {
    reinterpret_cast<sockaddr_in&>(source.storage).sin_port =
        reinterpret_cast<const sockaddr_in&>(bound.storage).sin_port;
  } else {
    reinterpret_cast<sockaddr_in6&>(source.storage).sin6_port =
        reinterpret_cast<const sockaddr_in6&>(bound.storage).sin6_port;
  }
  return source;
}

/// Sends each packet to the peers that are to have it. What the socket does not take at once is
/// lost for that peer and counted: a queue per peer would only hold old packets.
class UdpServerWriter final : public PacketWriter {
 public:
  UdpServerWriter(base::Descriptor descriptor, LinkId own, std::shared_ptr<SharedPeers> peers,
                  std::shared_ptr<LinkCounters> counters);

  WriteResult write(std::span<const PacketRef> packets) override;
  int descriptor() const override { return descriptor_.get(); }

 private:
  void send_to_each(const PacketRef& packet, SlotMask peers) CAS_REQUIRES(peers_->mutex);
  void send_to_one(const PacketRef& packet, std::uint8_t peer) CAS_REQUIRES(peers_->mutex);
  void send_by_peer(std::span<const PacketRef> packets) CAS_REQUIRES(peers_->mutex);
  void count_lost(const PacketRef& packet);

  base::Descriptor descriptor_;
  LinkId own_;
  std::shared_ptr<SharedPeers> peers_;
  std::shared_ptr<LinkCounters> counters_;
  DatagramSender sender_;
  std::vector<SlotMask> masks_;
  std::vector<PacketRef> of_peer_;
};

UdpServerWriter::UdpServerWriter(base::Descriptor descriptor, LinkId own,
                                 std::shared_ptr<SharedPeers> peers,
                                 std::shared_ptr<LinkCounters> counters)
    : descriptor_(std::move(descriptor)),
      own_(own),
      peers_(std::move(peers)),
      counters_(std::move(counters)) {}

WriteResult UdpServerWriter::write(std::span<const PacketRef> packets) {
  const base::MutexLock lock(peers_->mutex);
  if (packets.size() == 1) {
    send_to_each(packets.front(), peers_->table.for_packet(*packets.front().info, own_));
  } else {
    send_by_peer(packets);
  }
  return {.packets = packets.size(), .done = base::steady_now()};
}

// One packet, many peers: one call for all of them.
void UdpServerWriter::send_to_each(const PacketRef& packet, SlotMask peers) {
  if (peers != 0 && (peers & (peers - 1)) == 0) {
    return send_to_one(packet, static_cast<std::uint8_t>(std::countr_zero(peers)));
  }
  std::array<mmsghdr, PeerTable::kMaxPeers> messages;
  iovec part{const_cast<std::uint8_t*>(packet.bytes.data()), packet.bytes.size()};
  unsigned count = 0;
  for_each_slot(peers, [&](std::uint8_t peer) CAS_REQUIRES(peers_->mutex) {
    messages[count] = {};
    msghdr& header = messages[count++].msg_hdr;
    header.msg_name = const_cast<sockaddr*>(peers_->table.address(peer));
    header.msg_namelen = peers_->table.address_size(peer);
    header.msg_iov = &part;
    header.msg_iovlen = 1;
  });
  for (unsigned done = 0; done < count;) {
    const int sent = ::sendmmsg(descriptor_.get(), messages.data() + done, count - done,
                                MSG_DONTWAIT | MSG_NOSIGNAL);
    // This peer's loss; on with the next.
    if (sent <= 0) count_lost(packet);
    done += sent > 0 ? static_cast<unsigned>(sent) : 1;
  }
}

void UdpServerWriter::send_to_one(const PacketRef& packet, std::uint8_t peer) {
  const auto sent = ::sendto(descriptor_.get(), packet.bytes.data(), packet.bytes.size(),
                             MSG_DONTWAIT | MSG_NOSIGNAL, peers_->table.address(peer),
                             peers_->table.address_size(peer));
  if (sent < 0) count_lost(packet);
}

void UdpServerWriter::count_lost(const PacketRef& packet) {
  counters_->count_dropped(*packet.info, DropCause::kQueueFull, base::steady_now());
}

// Many packets: one block for each peer.
void UdpServerWriter::send_by_peer(std::span<const PacketRef> packets) {
  masks_.clear();
  SlotMask wanted = 0;
  for (const PacketRef& packet : packets) {
    masks_.push_back(peers_->table.for_packet(*packet.info, own_));
    wanted |= masks_.back();
  }
  for_each_slot(wanted, [&](std::uint8_t peer) CAS_REQUIRES(peers_->mutex) {
    of_peer_.clear();
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if ((masks_[i] & slot_bit(peer)) != 0) of_peer_.push_back(packets[i]);
    }
    const auto result = sender_.send(descriptor_.get(), of_peer_, peers_->table.address(peer),
                                     peers_->table.address_size(peer));
    if (result.error == 0) return;
    for (std::size_t i = result.packets; i < of_peer_.size(); ++i) count_lost(of_peer_[i]);
  });
}

}  // namespace

UdpLink::UdpLink(LinkContext context)
    : core_(std::move(context)), port_(core_.make_port()), parser_(make_parser()) {}

void UdpLink::watch(PollSet& set, base::RunTime) {
  if (!fd_) return set.wake_by(core_.backoff().next());
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(core_.next_second());
}

void UdpLink::serve(const PollSet& set, base::RunTime now) {
  if (!fd_) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  const short events = set.revents(poll_entry_);
  if ((events & (POLLIN | POLLERR)) != 0) read(now);
  if (fd_ && port_->broken()) close("sending failed", now);
  if (fd_ && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
  if (core_.second_due(now)) core_.on_second(now);
}

void UdpLink::open(base::RunTime now) {
  if (!look_up(now)) return;
  const SocketAddress& remote = remote_.address();
  base::Descriptor socket(open_udp_socket(remote.family(), core_.config().interface));
  if (!socket || !prepare(socket.get(), remote)) {
    return core_.went_down(error_text(errno), now);
  }
  fd_ = OpenDescriptor(socket.get());
  drops_seen_ = 0;
  reader_.reset();
  const std::string endpoint = to_text(local_address(fd_.get()));
  port_->attach(std::make_unique<UdpWriter>(std::move(socket), to_many_ ? remote : SocketAddress{}),
                now);
  core_.went_up(endpoint);
}

// Addresses are looked up anew at each opening: names may move.
bool UdpLink::look_up(base::RunTime now) {
  using enum AddressLookup::State;
  if (!looking_up_) {
    remote_ = AddressLookup(core_.config().remote);
    if (!core_.config().local.empty()) local_ = AddressLookup(core_.config().local);
    looking_up_ = true;
  }
  const bool has_local = !core_.config().local.empty();
  for (const AddressLookup* lookup : {&remote_, has_local ? &local_ : &remote_}) {
    if (lookup->state() == kFound) continue;
    if (lookup->state() == kFailed) {
      looking_up_ = false;
      core_.went_down(lookup->error(), now);
    } else {
      core_.backoff().failed(now);
    }
    return false;
  }
  looking_up_ = false;
  return true;
}

bool UdpLink::prepare(int fd, const SocketAddress& remote) {
  to_many_ = remote.is_multicast() || is_broadcast(remote);
  const int on = 1;
  if (to_many_) ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (!core_.config().local.empty()) {
    const SocketAddress& local = local_.address();
    if (::bind(fd, local.get(), local.size) != 0) return false;
  }
  if (!to_many_) return ::connect(fd, remote.get(), remote.size) == 0;
  ::setsockopt(fd, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
  const std::string& interface = core_.config().interface;
  if (remote.is_multicast() && !join_group(fd, remote, interface)) return false;
  own_ = source_towards(remote, fd, interface);
  return true;
}

void UdpLink::read(base::RunTime now) {
  // More than one batch a turn only under a flood; then other links of this loop wait no longer
  // than these.
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const int count = reader_.read(fd_.get(), now);
    if (count < 0) return close(error_text(errno), now);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      if (is_own(i)) continue;
      core_.ingress().take_datagram(parser_, reader_.datagram(i), now, reader_.waited(i));
    }
    core_.ingress().deliver(now);
    if (reader_.kernel_drops() != drops_seen_) {
      core_.counters().rx.kernel_drops.add(reader_.kernel_drops() - drops_seen_);
      drops_seen_ = reader_.kernel_drops();
    }
    if (count < static_cast<int>(DatagramReader::kBatch)) return;
  }
}

bool UdpLink::is_own(std::size_t index) const {
  return to_many_ && own_.size > 0 &&
         std::memcmp(&own_.storage, &reader_.sender(index), own_.size) == 0;
}

void UdpLink::close(const std::string& reason, base::RunTime now) {
  fd_ = {};
  port_->detach(now);
  core_.went_down(reason, now);
}

UdpServerLink::UdpServerLink(LinkContext context)
    : core_(std::move(context)),
      newest_only_(core_.config().type == LinkType::kUdp),
      peers_(std::make_shared<SharedPeers>(newest_only_ ? 1 : core_.config().max_peers,
                                           core_.config().expiry)),
      port_(core_.make_port()),
      parser_(make_parser()) {}

void UdpServerLink::watch(PollSet& set, base::RunTime) {
  if (!fd_) return set.wake_by(core_.backoff().next());
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(core_.next_second());
}

void UdpServerLink::serve(const PollSet& set, base::RunTime now) {
  if (!fd_) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  const short events = set.revents(poll_entry_);
  if ((events & (POLLIN | POLLERR)) != 0) read(now);
  if (fd_ && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
  if (core_.second_due(now)) on_second(now);
}

void UdpServerLink::open(base::RunTime now) {
  if (!looking_up_) local_ = AddressLookup(core_.config().local);
  looking_up_ = local_.state() == AddressLookup::State::kPending;
  if (looking_up_) return core_.backoff().failed(now);
  if (local_.state() == AddressLookup::State::kFailed) return core_.went_down(local_.error(), now);

  const SocketAddress& address = local_.address();
  base::Descriptor socket(open_udp_socket(address.family(), core_.config().interface));
  if (!socket || ::bind(socket.get(), address.get(), address.size) != 0) {
    return core_.went_down(core_.config().local + ": " + error_text(errno), now);
  }
  fd_ = OpenDescriptor(socket.get());
  drops_seen_ = 0;
  reader_.reset();
  port_->attach(std::make_unique<UdpServerWriter>(std::move(socket), core_.id(), peers_,
                                                  core_.shared_counters()),
                now);
  core_.went_up(to_text(local_address(fd_.get())));
}

void UdpServerLink::read(base::RunTime now) {
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const int count = reader_.read(fd_.get(), now);
    if (count < 0) return close(error_text(errno), now);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) take_datagram(i, now);
    core_.ingress().deliver(now);
    if (reader_.kernel_drops() != drops_seen_) {
      core_.counters().rx.kernel_drops.add(reader_.kernel_drops() - drops_seen_);
      drops_seen_ = reader_.kernel_drops();
    }
    if (count < static_cast<int>(DatagramReader::kBatch)) return;
  }
}

// Only who sends a whole packet becomes a peer.
void UdpServerLink::take_datagram(std::size_t index, base::RunTime now) {
  PeerTable& table = peers_->own_table();
  std::optional<std::uint8_t> peer = table.find(reader_.sender(index));
  const auto on_packet = [&](const mav::PacketView& packet) {
    if (!peer) peer = admit(index, now);
    if (!peer) return core_.counters().rx.foreign.add();
    table.heard(*peer, packet.source, now);
    core_.ingress().take_packet(packet, now, table.id(*peer), reader_.waited(index));
  };
  core_.ingress().parse_datagram(parser_, reader_.datagram(index), on_packet);
}

std::optional<std::uint8_t> UdpServerLink::admit(std::size_t index, base::RunTime now) {
  const base::MutexLock lock(peers_->mutex);
  if (newest_only_) peers_->table.clear();
  const auto peer = peers_->table.add(reader_.sender(index), reader_.sender_size(index), now);
  core_.counters().peers.set(static_cast<std::uint64_t>(peers_->table.count()));
  return peer;
}

void UdpServerLink::on_second(base::RunTime now) {
  core_.on_second(now);
  if (newest_only_) return;  // the one peer stays: it may only listen
  const base::MutexLock lock(peers_->mutex);
  peers_->table.expire(now);
  core_.counters().peers.set(static_cast<std::uint64_t>(peers_->table.count()));
}

void UdpServerLink::close(const std::string& reason, base::RunTime now) {
  fd_ = {};
  port_->detach(now);
  core_.went_down(reason, now);
}

}  // namespace cas::casd
