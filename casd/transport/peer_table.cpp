// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/peer_table.hpp"

#include <cstring>

namespace cas::casd {

namespace {

/// Whether both are addresses of one machine, whatever their ports.
bool same_host(const sockaddr_storage& a, const sockaddr_storage& b) {
  if (a.ss_family != b.ss_family) return false;
  if (a.ss_family == AF_INET) {
    return reinterpret_cast<const sockaddr_in&>(a).sin_addr.s_addr ==
           reinterpret_cast<const sockaddr_in&>(b).sin_addr.s_addr;
  }
  return std::memcmp(&reinterpret_cast<const sockaddr_in6&>(a).sin6_addr,
                     &reinterpret_cast<const sockaddr_in6&>(b).sin6_addr, sizeof(in6_addr)) == 0;
}

}  // namespace

PeerTable::PeerTable(int max_peers, base::Duration expiry)
    : max_peers_(max_peers), expiry_(expiry), routes_(expiry) {}

std::optional<std::uint8_t> PeerTable::find(const sockaddr_storage& address) const {
  const auto same = [&](std::uint8_t peer) {
    return (present_ & slot_bit(peer)) != 0 &&
           std::memcmp(&peers_[peer].address, &address, peers_[peer].size) == 0;
  };
  if (same(newest_)) return newest_;
  for (SlotMask left = present_; left != 0; left &= left - 1) {
    const auto peer = static_cast<std::uint8_t>(std::countr_zero(left));
    if (same(peer)) return newest_ = peer;
  }
  return std::nullopt;
}

std::optional<std::uint8_t> PeerTable::add(const sockaddr_storage& address, socklen_t size,
                                           base::RunTime now, std::uint8_t socket) {
  if (count() >= max_peers_ && expire(now) == 0 && !make_room(address)) return std::nullopt;
  const auto peer = static_cast<std::uint8_t>(std::countr_one(present_));
  peers_[peer] = {address, size, now, ++serials_, socket, false};
  present_ |= slot_bit(peer);
  return peer;
}

int PeerTable::count_of_host(const sockaddr_storage& address) const {
  int of_host = 0;
  for_each_slot(present_, [&](std::uint8_t peer) {
    of_host += same_host(peers_[peer].address, address) ? 1 : 0;
  });
  return of_host;
}

bool PeerTable::make_room(const sockaddr_storage& address) {
  int most = count_of_host(address) + 1;  // no gain in a mere exchange of places
  std::optional<std::uint8_t> newest;
  for_each_slot(present_, [&](std::uint8_t peer) {
    const int of_host = count_of_host(peers_[peer].address);
    if (of_host < most || (of_host == most && !newest)) return;
    if (of_host == most && peers_[*newest].serial > peers_[peer].serial) return;
    most = of_host;
    newest = peer;
  });
  if (newest) remove(*newest);
  return newest.has_value();
}

void PeerTable::heard(std::uint8_t peer, mav::Source source, base::RunTime now, bool rarely) {
  peers_[peer].last = now;
  peers_[peer].rarely |= rarely;
  routes_.learn(peer, source, now, rarely);
}

int PeerTable::expire(base::RunTime now) {
  int gone = 0;
  for_each_slot(present_, [&](std::uint8_t peer) {
    if (now - peers_[peer].last <= silence_of(expiry_, peers_[peer].rarely)) {
      routes_.expire(peer, now);
      return;
    }
    remove(peer);
    ++gone;
  });
  return gone;
}

void PeerTable::clear() {
  for_each_slot(present_, [this](std::uint8_t peer) { remove(peer); });
}

SlotMask PeerTable::for_packet(const PacketInfo& info, LinkId own) const {
  if (info.to_all_peers) return present_;
  SlotMask peers = present_ & routes_.links_to(info.target);
  if (info.from == own && info.from_peer < kMaxPeers) peers &= ~slot_bit(info.from_peer);
  if (info.to_serial == 0) return peers;
  for_each_slot(peers, [&](std::uint8_t peer) {
    if (peers_[peer].serial != info.to_serial) peers &= ~slot_bit(peer);
  });
  return peers;
}

void PeerTable::remove(std::uint8_t peer) {
  routes_.forget(peer);
  present_ &= ~slot_bit(peer);
  peers_[peer] = Peer{};
}

}  // namespace cas::casd
