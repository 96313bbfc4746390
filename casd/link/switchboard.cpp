// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/switchboard.hpp"

#include <utility>

#include "base/os/lack_of_memory.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {

DeliveryBatch::DeliveryBatch() {
  // The references point into these: they must never move.
  infos_.reserve(kMaxPackets);
  bytes_.reserve(kMaxPackets * mav::kMaxPacketBytes);
}

void DeliveryBatch::add(const PacketInfo& info, std::span<const std::uint8_t> bytes,
                        const LinkMask& to) {
  const std::size_t offset = bytes_.size();
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  infos_.push_back(info);
  const PacketRef packet{&infos_.back(), {bytes_.data() + offset, bytes.size()}};
  touched_ |= to;
  to.for_each([&](LinkId link) { by_link_[link].push_back(packet); });
}

std::size_t DeliveryBatch::deliver(const PortTable& ports, base::RunTime now) {
  std::size_t lost = 0;
  const auto hand_over = [&](LinkId link) {
    const auto give = [&] { ports[link]->deliver(by_link_[link], now); };
    if (ports[link] && !base::outlive_lack_of_memory("delivery", give)) {
      lost += by_link_[link].size();
    }
    by_link_[link].clear();
  };
  // casd's own station first: in lockstep it has heard all that came before an answer when the
  // simulator goes on.
  if (touched_.has(kLocalLink)) hand_over(kLocalLink);
  touched_.remove(kLocalLink);
  touched_.for_each(hand_over);
  touched_ = {};
  infos_.clear();
  bytes_.clear();
  return lost;
}

Switchboard::Switchboard(std::shared_ptr<const RoutingPlan> plan)
    : router_(std::move(plan), mav::public_table()), ports_(std::make_shared<PortTable>()) {}

void Switchboard::set_ports(std::shared_ptr<const PortTable> ports) {
  const base::MutexLock lock(mutex_);
  ports_ = std::move(ports);
  generation_.fetch_add(1, std::memory_order_release);
}

std::shared_ptr<const PortTable> Switchboard::ports_after(std::uint64_t& generation) {
  if (generation == generation_.load(std::memory_order_acquire)) return nullptr;
  const base::MutexLock lock(mutex_);
  generation = generation_.load(std::memory_order_relaxed);
  return ports_;
}

}  // namespace cas::casd
