// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_server_writer.hpp"

#include <array>
#include <bit>
#include <utility>

namespace cas::casd {

UdpServerWriter::UdpServerWriter(base::Descriptor descriptor, LinkId own,
                                 std::shared_ptr<SharedPeers> peers,
                                 std::shared_ptr<LinkCounters> counters)
    : descriptor_(std::move(descriptor)),
      own_(own),
      peers_(std::move(peers)),
      counters_(std::move(counters)) {}

WriteResult UdpServerWriter::write(std::span<const PacketRef> packets) {
  const std::scoped_lock lock(peers_->mutex);
  if (packets.size() == 1) {
    send_to_each(packets.front(), peers_->table.for_packet(*packets.front().info, own_));
  } else {
    send_by_peer(packets);
  }
  return {.packets = packets.size()};
}

// One packet, many peers: one call for all of them.
void UdpServerWriter::send_to_each(const PacketRef& packet, LinkMask peers) {
  std::array<mmsghdr, PeerTable::kMaxPeers> messages{};
  iovec part{const_cast<std::uint8_t*>(packet.bytes.data()), packet.bytes.size()};
  unsigned count = 0;
  for (LinkMask left = peers; left != 0; left &= left - 1) {
    const auto peer = static_cast<std::uint8_t>(std::countr_zero(left));
    msghdr& header = messages[count++].msg_hdr;
    header.msg_name = const_cast<sockaddr*>(peers_->table.address(peer));
    header.msg_namelen = peers_->table.address_size(peer);
    header.msg_iov = &part;
    header.msg_iovlen = 1;
  }
  for (unsigned done = 0; done < count;) {
    const int sent = ::sendmmsg(descriptor_.get(), messages.data() + done, count - done,
                                MSG_DONTWAIT | MSG_NOSIGNAL);
    // This peer's loss; on with the next.
    if (sent <= 0) counters_->count_dropped(*packet.info, DropCause::kQueueFull);
    done += sent > 0 ? static_cast<unsigned>(sent) : 1;
  }
}

// Many packets: one block for each peer.
void UdpServerWriter::send_by_peer(std::span<const PacketRef> packets) {
  masks_.clear();
  LinkMask wanted = 0;
  for (const PacketRef& packet : packets) {
    masks_.push_back(peers_->table.for_packet(*packet.info, own_));
    wanted |= masks_.back();
  }
  for (LinkMask left = wanted; left != 0; left &= left - 1) {
    const auto peer = static_cast<std::uint8_t>(std::countr_zero(left));
    of_peer_.clear();
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if ((masks_[i] & bit(peer)) != 0) of_peer_.push_back(packets[i]);
    }
    const auto result = sender_.send(descriptor_.get(), of_peer_, peers_->table.address(peer),
                                     peers_->table.address_size(peer));
    if (result.error == 0) continue;
    for (std::size_t i = result.packets; i < of_peer_.size(); ++i) {
      counters_->count_dropped(*of_peer_[i].info, DropCause::kQueueFull);
    }
  }
}

}  // namespace cas::casd
