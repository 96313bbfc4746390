// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_server_link.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <span>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/packet/own_numbers.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {
namespace {

DropCause cause_of(int error) {
  const bool no_room = error == EAGAIN || error == EWOULDBLOCK || error == ENOBUFS;
  return no_room ? DropCause::kQueueFull : DropCause::kClosed;
}

/// Sends each packet to the peers that are to have it. What the socket does not take at once is
/// lost for that peer and counted: a queue per peer would only hold old packets. A packet that no
/// peer got is unsent.
class UdpServerWriter final : public PacketWriter {
 public:
  /// @param own_numbers  casd's own packets are numbered for each peer
  UdpServerWriter(std::vector<base::Descriptor> sockets, LinkId own,
                  std::shared_ptr<SharedPeers> peers, std::shared_ptr<LinkCounters> counters,
                  bool own_numbers);

  WriteResult write(std::span<const PacketRef> packets) override;
  int descriptor() const override { return sockets_.front().get(); }

 private:
  /// @return whether any of the peers was sent it
  bool send_to_each(const PacketRef& packet, SlotMask peers) CAS_REQUIRES(peers_->mutex);
  bool send_to_one(const PacketRef& packet, std::uint8_t peer) CAS_REQUIRES(peers_->mutex);
  bool send_bytes(const PacketRef& packet, std::uint8_t peer) CAS_REQUIRES(peers_->mutex);
  /// Leaves in masks_ the peers that were sent each packet.
  void send_by_peer(std::span<const PacketRef> packets) CAS_REQUIRES(peers_->mutex);
  void send_block(std::span<const PacketRef> packets, std::uint8_t peer)
      CAS_REQUIRES(peers_->mutex);
  void count_lost(const PacketRef& packet, int error);
  int socket_of(std::uint8_t peer) const CAS_REQUIRES(peers_->mutex) {
    return sockets_[std::min<std::size_t>(peers_->table.socket(peer), sockets_.size() - 1)].get();
  }
  /// Calls send(packets), with sequence numbers of this peer in casd's own packets.
  template <class Send>
  void numbered(std::span<const PacketRef> packets, std::uint8_t peer, Send&& send)
      CAS_REQUIRES(peers_->mutex);

  /// Sequence numbers of one peer. The serial number tells it from earlier peers of its slot.
  struct Numbers {
    std::uint32_t serial = 0;
    OwnNumbers numbers;
  };

  std::vector<base::Descriptor> sockets_;
  LinkId own_;
  std::shared_ptr<SharedPeers> peers_;
  std::shared_ptr<LinkCounters> counters_;
  bool own_numbers_;
  std::array<Numbers, PeerTable::kMaxPeers> numbers_;
  DatagramSender sender_;
  std::vector<SlotMask> masks_;       ///< peers of each packet
  std::vector<PacketRef> of_peer_;    ///< packets of one peer
  std::vector<std::size_t> indices_;  ///< of of_peer_ among all packets
  std::vector<Unsent> unsent_;
};

UdpServerWriter::UdpServerWriter(std::vector<base::Descriptor> sockets, LinkId own,
                                 std::shared_ptr<SharedPeers> peers,
                                 std::shared_ptr<LinkCounters> counters, bool own_numbers)
    : sockets_(std::move(sockets)),
      own_(own),
      peers_(std::move(peers)),
      counters_(std::move(counters)),
      own_numbers_(own_numbers) {}

WriteResult UdpServerWriter::write(std::span<const PacketRef> packets) {
  unsent_.clear();
  const base::MutexLock lock(peers_->mutex);
  if (packets.size() == 1) {
    const SlotMask peers = peers_->table.for_packet(*packets.front().info, own_);
    if (!send_to_each(packets.front(), peers)) unsent_.push_back({});
  } else {
    send_by_peer(packets);
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if (masks_[i] == 0) unsent_.push_back({.index = i, .cause = {}});
    }
  }
  return {.packets = packets.size(), .done = base::steady_now(), .unsent = unsent_};
}

template <class Send>
void UdpServerWriter::numbered(std::span<const PacketRef> packets, std::uint8_t peer, Send&& send) {
  if (!own_numbers_ || std::ranges::none_of(packets, OwnNumbers::is_own)) return send(packets);
  Numbers& of_peer = numbers_[peer];
  const std::uint32_t serial = peers_->table.id(peer).serial;
  if (std::exchange(of_peer.serial, serial) != serial) of_peer.numbers = {};
  send(of_peer.numbers.number(packets));
  of_peer.numbers.sent(packets);
}

// One packet, many peers: one call for all of them, if it is the same for all and there is one
// socket.
bool UdpServerWriter::send_to_each(const PacketRef& packet, SlotMask peers) {
  if (peers != 0 && (peers & (peers - 1)) == 0) {
    return send_to_one(packet, static_cast<std::uint8_t>(std::countr_zero(peers)));
  }
  if (sockets_.size() > 1 || (own_numbers_ && OwnNumbers::is_own(packet))) {
    bool any = false;
    for_each_slot(peers, [&](std::uint8_t peer)
                             CAS_REQUIRES(peers_->mutex) { any |= send_to_one(packet, peer); });
    return any;
  }
  std::array<mmsghdr, PeerTable::kMaxPeers> messages;
  iovec part{const_cast<std::uint8_t*>(packet.bytes.data()), packet.bytes.size()};
  unsigned count = 0;
  bool any_sent = false;
  for_each_slot(peers, [&](std::uint8_t peer) CAS_REQUIRES(peers_->mutex) {
    messages[count] = {};
    msghdr& header = messages[count++].msg_hdr;
    header.msg_name = const_cast<sockaddr*>(peers_->table.address(peer));
    header.msg_namelen = peers_->table.address_size(peer);
    header.msg_iov = &part;
    header.msg_iovlen = 1;
  });
  for (unsigned done = 0; done < count;) {
    const int sent =
        ::sendmmsg(descriptor(), messages.data() + done, count - done, MSG_DONTWAIT | MSG_NOSIGNAL);
    // This peer's loss; on with the next.
    if (sent <= 0) count_lost(packet, errno);
    if (sent > 0) counters_->note_send(0);
    any_sent |= sent > 0;
    done += sent > 0 ? static_cast<unsigned>(sent) : 1;
  }
  return any_sent;
}

bool UdpServerWriter::send_to_one(const PacketRef& packet, std::uint8_t peer) {
  bool sent = false;
  numbered({&packet, 1}, peer, [&](std::span<const PacketRef> as_seen) CAS_REQUIRES(peers_->mutex) {
    sent = send_bytes(as_seen.front(), peer);
  });
  return sent;
}

bool UdpServerWriter::send_bytes(const PacketRef& packet, std::uint8_t peer) {
  const auto sent = ::sendto(socket_of(peer), packet.bytes.data(), packet.bytes.size(),
                             MSG_DONTWAIT | MSG_NOSIGNAL, peers_->table.address(peer),
                             peers_->table.address_size(peer));
  if (sent < 0) count_lost(packet, errno);
  if (sent >= 0) counters_->note_send(0);
  return sent >= 0;
}

void UdpServerWriter::count_lost(const PacketRef& packet, int error) {
  counters_->note_send(error);
  counters_->count_dropped(*packet.info, cause_of(error), base::steady_now());
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
    indices_.clear();
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if ((masks_[i] & slot_bit(peer)) == 0) continue;
      of_peer_.push_back(packets[i]);
      indices_.push_back(i);
    }
    numbered(of_peer_, peer, [&](std::span<const PacketRef> as_seen) CAS_REQUIRES(peers_->mutex) {
      send_block(as_seen, peer);
    });
  });
}

/// Sends the packets of of_peer_. @param packets  the same, numbered for the peer
void UdpServerWriter::send_block(std::span<const PacketRef> packets, std::uint8_t peer) {
  const auto result = sender_.send(socket_of(peer), packets, peers_->table.address(peer),
                                   peers_->table.address_size(peer));
  const auto lost = [&](std::size_t i, int error) {
    count_lost(packets[i], error);
    masks_[indices_[i]] &= ~slot_bit(peer);
  };
  if (result.packets > result.refused.size()) counters_->note_send(0);
  for (const std::size_t i : result.refused) lost(i, result.refusal);
  for (std::size_t i = result.packets; i < packets.size(); ++i) lost(i, result.error);
}

}  // namespace

UdpServerLink::UdpServerLink(LinkContext context)
    : DatagramLink(std::move(context)),
      newest_only_(core_.config().type == LinkType::kUdp),
      peers_(std::make_shared<SharedPeers>(newest_only_ ? 1 : core_.config().max_peers,
                                           core_.config().expiry)) {}

void UdpServerLink::open(base::RunTime now) {
  if (!looking_up_) local_ = AddressLookup(core_.config().local);
  looking_up_ = local_.state() == AddressLookup::State::kPending;
  if (looking_up_) return core_.backoff().failed(now);
  if (local_.state() == AddressLookup::State::kFailed) return core_.went_down(local_.error(), now);

  OpenSockets open = open_at_each(local_.addresses(), [&](const SocketAddress& address) {
    base::Descriptor socket(open_udp_socket(address.family(), core_.config().interface));
    if (socket && ::bind(socket.get(), address.get(), address.size) == 0) return socket;
    return base::Descriptor();
  });
  if (open.sockets.empty()) {
    return core_.went_down(core_.config().local + ": " + base::error_text(open.error), now);
  }
  const std::vector<int> numbers = numbers_of(open.sockets);
  begin(std::make_unique<UdpServerWriter>(std::move(open.sockets), core_.id(), peers_,
                                          core_.shared_counters(), core_.config().group.empty()),
        numbers, now);
}

void UdpServerLink::take_datagram(const DatagramReader& reader, std::size_t index,
                                  base::RunTime now) {
  const PeerAddress& sender = reader.sender(index);
  std::optional<std::uint8_t> peer = peers_->own_table().find(sender.address.storage);
  packets_.take(
      core_.ingress(), sender, [&] { return peer.has_value(); }, reader.datagram(index), now,
      [&](const mav::PacketView& packet) {
        take_packet(peer, sender, packet, now, reader.waited(index));
      });
}

void UdpServerLink::take_held(const PeerAddress& sender, const mav::PacketView& packet,
                              base::RunTime now) {
  std::optional<std::uint8_t> peer = peers_->own_table().find(sender.address.storage);
  take_packet(peer, sender, packet, now, {});
}

// Only who sends a whole packet becomes a peer.
void UdpServerLink::take_packet(std::optional<std::uint8_t>& peer, const PeerAddress& sender,
                                const mav::PacketView& packet, base::RunTime now,
                                base::Duration waited) {
  PeerTable& table = peers_->own_table();
  if (!peer) peer = admit(sender, now);
  if (!peer) return core_.counters().rx.foreign.add();
  table.heard(*peer, packet.source, now, comes_rarely(packet.message_id));
  core_.ingress().take_packet(packet, now, table.id(*peer), waited);
}

std::optional<std::uint8_t> UdpServerLink::admit(const PeerAddress& sender, base::RunTime now) {
  const base::MutexLock lock(peers_->mutex);
  if (newest_only_) peers_->table.clear();
  const auto peer =
      peers_->table.add(sender.address.storage, sender.address.size, now, sender.socket);
  core_.counters().peers.set(static_cast<std::uint64_t>(peers_->table.count()));
  return peer;
}

void UdpServerLink::on_second(base::RunTime now) {
  if (newest_only_) return;  // the one peer stays: it may only listen
  const base::MutexLock lock(peers_->mutex);
  peers_->table.expire(now);
  core_.counters().peers.set(static_cast<std::uint64_t>(peers_->table.count()));
}

}  // namespace cas::casd
