// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/datagram_link.hpp"

#include <poll.h>

#include <cerrno>
#include <utility>

#include "casd/counters/link_counters.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

DatagramLink::DatagramLink(LinkContext context)
    : core_(std::move(context)), port_(core_.make_port()) {}

void DatagramLink::watch(PollSet& set, base::RunTime) {
  if (!fd_) return set.wake_by(core_.backoff().next());
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(packets_.due());
  set.wake_by(core_.next_second());
}

void DatagramLink::serve(const PollSet& set, base::RunTime now) {
  if (!fd_) {
    if (core_.backoff().due(now)) open(now);
    return;
  }
  const short events = set.revents(poll_entry_);
  if ((events & (POLLIN | POLLERR)) != 0) read(now);
  if (fd_ && port_->broken()) close("sending failed", now);
  if (fd_ && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
  if (packets_.due() <= now) release_held(now);
  if (!core_.second_due(now)) return;
  core_.on_second(now);
  on_second(now);
}

void DatagramLink::begin(std::unique_ptr<PacketWriter> writer, base::RunTime now) {
  fd_ = OpenDescriptor(writer->descriptor());
  drops_seen_ = 0;
  reader_.reset();
  packets_.reset();
  port_->attach(std::move(writer), now);
  core_.went_up(to_text(local_address(fd_.get())));
}

void DatagramLink::read(base::RunTime now) {
  // More than one batch a turn only under a flood; then other links of this loop wait no longer
  // than these.
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const int count = reader_.read(fd_.get(), now);
    if (count < 0) return close(error_text(errno), now);
    core_.counters().count_tx_refused(reader_.take_refused());
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) take_datagram(i, now);
    core_.ingress().deliver(now);
    if (const std::uint64_t cut = reader_.take_cut_bytes(); cut > 0) [[unlikely]] {
      core_.counters().rx.skipped_bytes.add(cut);
    }
    if (reader_.kernel_drops() != drops_seen_) {
      core_.counters().rx.kernel_drops.add(reader_.kernel_drops() - drops_seen_);
      drops_seen_ = reader_.kernel_drops();
    }
    if (count < static_cast<int>(DatagramReader::kBatch)) return;
  }
}

void DatagramLink::release_held(base::RunTime now) {
  packets_.release(core_.ingress(), now,
                   [&](const SocketAddress& sender, const mav::PacketView& packet) {
                     take_held(sender, packet, now);
                   });
  core_.ingress().deliver(now);
}

void DatagramLink::close(const std::string& reason, base::RunTime now) {
  fd_ = {};
  port_->detach(now);
  core_.went_down(reason, now);
}

}  // namespace cas::casd
