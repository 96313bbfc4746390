// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/switchboard.hpp"

#include <utility>

#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {

Switchboard::Switchboard(std::shared_ptr<const RoutingPlan> plan, base::Duration route_lifetime)
    : router_(std::move(plan), mav::public_table(), route_lifetime),
      ports_(std::make_shared<PortTable>()) {}

void Switchboard::set_ports(std::shared_ptr<const PortTable> ports) {
  const std::scoped_lock lock(mutex_);
  ports_ = std::move(ports);
  generation_.fetch_add(1, std::memory_order_release);
}

std::shared_ptr<const PortTable> Switchboard::ports_after(std::uint64_t& generation) {
  if (generation == generation_.load(std::memory_order_acquire)) return nullptr;
  const std::scoped_lock lock(mutex_);
  generation = generation_.load(std::memory_order_relaxed);
  return ports_;
}

}  // namespace cas::casd
