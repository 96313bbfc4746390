// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/datagram_link.hpp"

#include <poll.h>

#include <cerrno>
#include <utility>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

DatagramLink::DatagramLink(LinkContext context)
    : core_(std::move(context)), port_(core_.make_port()) {}

void DatagramLink::watch(PollSet& set, base::RunTime) {
  if (!is_open()) return set.wake_by(core_.backoff().next());
  short events = static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0));
  for (const auto& socket : sockets_) {
    socket->poll_entry = set.add(socket->fd, std::exchange(events, POLLIN));
  }
  set.wake_by(port_->due());
  set.wake_by(packets_.due());
  set.wake_by(core_.next_second());
}

void DatagramLink::serve(const PollSet& set, base::RunTime now) {
  if (!is_open()) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  bool room = false;
  for (std::size_t i = 0; i < sockets_.size(); ++i) {
    const short events = set.revents(sockets_[i]->poll_entry);
    room |= (events & POLLOUT) != 0;
    if ((events & (POLLIN | POLLERR)) != 0) read(*sockets_[i], now);
  }
  if (is_open() && port_->broken()) close("sending failed", now);
  if (is_open() && (room || port_->due() <= now)) port_->carry_on(now);
  if (packets_.due() <= now) release_held(now);
  if (!core_.second_due(now)) return;
  core_.on_second(now);
  judge_sending(now);
  on_second(now);
}

void DatagramLink::begin(std::unique_ptr<PacketWriter> writer, std::span<const int> sockets,
                         base::RunTime now) {
  replace(std::move(writer), sockets, now);
  core_.went_up(to_text(sockets));
}

void DatagramLink::replace(std::unique_ptr<PacketWriter> writer, std::span<const int> sockets,
                           base::RunTime now) {
  closed_arrivals_ = arrivals();
  sockets_.clear();
  std::vector<std::unique_ptr<Socket>> opened;
  for (const int fd : sockets) {
    opened.push_back(std::make_unique<Socket>(fd, static_cast<std::uint8_t>(opened.size())));
  }
  packets_.reset();
  denied_ = 0;
  core_.counters().note_send(0);
  port_->attach(std::move(writer), now);
  sockets_ = std::move(opened);
}

Arrivals DatagramLink::arrivals() const {
  Arrivals all = closed_arrivals_;
  for (const auto& socket : sockets_) {
    const Arrivals of_socket = socket->reader.arrivals();
    all.packets += of_socket.packets;
    all.waited += of_socket.waited;
  }
  return all;
}

void DatagramLink::read(Socket& socket, base::RunTime now) {
  // More than one batch a turn only under a flood; then other links of this loop wait no longer
  // than these.
  constexpr int kMaxRounds = 4;
  DatagramReader& reader = socket.reader;
  for (int round = 0; round < kMaxRounds; ++round) {
    const int count = reader.read(socket.fd.get(), now);
    if (count < 0) return close(base::error_text(errno), now);
    core_.counters().count_tx_refused(reader.take_refused());
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const auto take = [&] { take_datagram(reader, i, now); };
      if (!base::outlive_lack_of_memory(core_.counters().name, take)) {
        core_.counters().rx.no_memory.add();
      }
    }
    core_.ingress().deliver(now);
    if (const std::uint64_t cut = reader.take_cut_bytes(); cut > 0) [[unlikely]] {
      core_.counters().rx.skipped_bytes.add(cut);
    }
    if (reader.kernel_drops() != socket.drops_seen) {
      core_.counters().rx.kernel_drops.add(reader.kernel_drops() - socket.drops_seen);
      socket.drops_seen = reader.kernel_drops();
    }
    if (count < static_cast<int>(DatagramReader::kBatch)) return;
  }
}

void DatagramLink::judge_sending(base::RunTime now) {
  const LinkCounters& counters = core_.counters();
  const std::uint64_t sent = counters.tx.packets.get();
  const bool any_sent = std::exchange(sent_, sent) != sent;
  const int denied = any_sent ? 0 : counters.send_denied.load(std::memory_order_relaxed);
  if (denied == std::exchange(denied_, denied)) return;
  if (denied != 0) {
    return core_.went_down("nothing may be sent: " + base::error_text(denied) +
                               " (a firewall, or the service's IPAddressAllow)",
                           now);
  }
  std::vector<int> numbers;
  for (const auto& socket : sockets_) numbers.push_back(socket->fd.get());
  core_.went_up(to_text(numbers));
}

void DatagramLink::release_held(base::RunTime now) {
  packets_.release(core_.ingress(), now,
                   [&](const PeerAddress& sender, const mav::PacketView& packet) {
                     take_held(sender, packet, now);
                   });
  core_.ingress().deliver(now);
}

void DatagramLink::let_go(base::RunTime now) {
  closed_arrivals_ = arrivals();
  sockets_.clear();
  port_->detach(now);
}

void DatagramLink::close(const std::string& reason, base::RunTime now) {
  let_go(now);
  core_.went_down(reason, now);
}

}  // namespace cas::casd
