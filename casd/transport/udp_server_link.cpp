// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_server_link.hpp"

#include <cerrno>
#include <string>
#include <utility>

#include "casd/transport/udp_server_writer.hpp"

namespace cas::casd {

UdpServerLink::UdpServerLink(LinkContext context)
    : core_(std::move(context)),
      newest_only_(core_.config().type == LinkType::kUdp),
      peers_(std::make_shared<SharedPeers>(newest_only_ ? 1 : core_.config().max_peers,
                                           core_.config().expiry)),
      port_(core_.make_port()),
      parser_(make_parser()) {}

void UdpServerLink::watch(PollSet& set, base::RunTime) {
  if (fd_ < 0) return set.wake_by(core_.backoff().next());
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(core_.next_second());
}

void UdpServerLink::serve(const PollSet& set, base::RunTime now) {
  if (fd_ < 0) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  const short events = set.revents(poll_entry_);
  if ((events & (POLLIN | POLLERR)) != 0) read(now);
  if (fd_ >= 0 && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
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
  fd_ = socket.get();
  drops_seen_ = 0;
  reader_.reset();
  port_->attach(std::make_unique<UdpServerWriter>(std::move(socket), core_.id(), peers_,
                                                  core_.shared_counters()));
  core_.went_up(to_text(local_address(fd_)));
}

void UdpServerLink::read(base::RunTime now) {
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const int count = reader_.read(fd_);
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
  std::optional<std::uint8_t> peer = peers_->table.find(reader_.sender(index));
  const auto on_packet = [&](const mav::PacketView& packet) {
    if (!peer) peer = admit(index, now);
    if (!peer) return core_.counters().rx.foreign.add();
    peers_->table.heard(*peer, packet.source, now);
    core_.ingress().take_packet(packet, now, *peer);
  };
  core_.ingress().parse_datagram(parser_, reader_.datagram(index), on_packet);
}

std::optional<std::uint8_t> UdpServerLink::admit(std::size_t index, base::RunTime now) {
  const std::scoped_lock lock(peers_->mutex);
  if (newest_only_) peers_->table.clear();
  const auto peer = peers_->table.add(reader_.sender(index), reader_.sender_size(index), now);
  core_.counters().peers.set(static_cast<std::uint64_t>(peers_->table.count()));
  return peer;
}

void UdpServerLink::on_second(base::RunTime now) {
  core_.on_second(now);
  if (newest_only_) return;  // the one peer stays: it may only listen
  const std::scoped_lock lock(peers_->mutex);
  peers_->table.expire(now);
  core_.counters().peers.set(static_cast<std::uint64_t>(peers_->table.count()));
}

void UdpServerLink::close(const std::string& reason, base::RunTime now) {
  fd_ = -1;
  port_->detach();
  core_.went_down(reason, now);
}

}  // namespace cas::casd
