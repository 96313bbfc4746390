// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/local_endpoint.hpp"

#include <utility>

#include "base/os/lack_of_memory.hpp"
#include "casd/packet/intervention.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {

LocalEndpoint::LocalEndpoint(Switchboard& switchboard, mav::Source self)
    : self_(self),
      counters_(std::make_shared<LinkCounters>("casd", LinkType::kUdp)),
      ingress_(kLocalLink, switchboard, counters_),
      waiting_(kQueueBytes),
      dispatching_(kQueueBytes) {}

void LocalEndpoint::deliver(std::span<const PacketRef> packets, base::RunTime) {
  bool wakes = false;
  const base::MutexLock lock(mutex_);
  for (const PacketRef& packet : packets) {
    if (!concerns_us(*packet.info)) continue;
    wakes = wakes || wakes_for_all_ || packet.info->target.system != 0;
    waiting_.push(*packet.info, packet.bytes);  // full: lost, as on a line
  }
  if (!wakes) return;
  signal_.raise();
  raised_ = true;
}

void LocalEndpoint::wake_for_all(bool all) {
  const base::MutexLock lock(mutex_);
  wakes_for_all_ = all;
}

void LocalEndpoint::dispatch(Station& station, base::RunTime now) {
  {
    const base::MutexLock lock(mutex_);
    // deliver() raises the signal under the same mutex: without `raised_` the eventfd is empty.
    if (std::exchange(raised_, false)) signal_.lower();
    std::swap(waiting_, dispatching_);
  }
  for (; !dispatching_.empty(); dispatching_.pop()) {
    const QueuedPacket packet = dispatching_.front();
    const Origin origin{{packet.info.from, packet.info.from_serial}, packet.info.from_group};
    const auto hear = [&] { station.on_packet(origin, mav::view_packet(packet.bytes), now); };
    base::outlive_lack_of_memory("casd's station", hear);
  }
}

bool LocalEndpoint::send(std::span<const std::uint8_t> packet, std::span<const Path> to,
                         base::RunTime now) {
  bool sent = false;
  const auto take = [&](const mav::PacketView& view) {
    if (view.bytes.size() != packet.size()) return;
    if (to.empty()) {
      ingress_.take_packet(view, now);
    } else {
      ingress_.take_addressed(view, to, now);
    }
    sent = true;
  };
  base::outlive_lack_of_memory("casd's station", [&] { make_parser().feed(packet, take); });
  ingress_.deliver(now);
  return sent;
}

bool LocalEndpoint::concerns_us(const PacketInfo& info) const {
  if (info.target.system == 0 || may_be_act(info.message_id)) return true;
  if (info.target.system != self_.system) return false;
  return info.target.component == 0 || info.target.component == self_.component;
}

}  // namespace cas::casd
