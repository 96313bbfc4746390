// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/fault_injector.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"

namespace cas::sim {

FaultInjector::FaultInjector(SimRunner& runner) {
  for (const VehicleConfig& vehicle : std::as_const(runner).config().vehicles) {
    const std::string topic = vehicle.name + "/" + std::string(kFaultOrders);
    entries_.push_back({vehicle.name, runner.bus().advertise<FaultOrder>(topic)});
  }
}

void FaultInjector::order(const std::string& vehicle, nlohmann::json fault) const {
  const auto entry = std::ranges::find(entries_, vehicle, &Entry::vehicle);
  if (entry == entries_.end()) throw base::ConfigError("there is no vehicle '" + vehicle + "'");
  if (!entry->orders.has_subscribers()) {
    throw base::ConfigError("vehicle '" + vehicle +
                            "' has no plugin fault with by_hand: it takes no faults in flight");
  }
  if (fault.contains("at_s") || fault.contains("when")) {
    throw base::ConfigError("a fault by hand begins at once: it takes neither at_s nor when");
  }
  fault["at_s"] = 0;
  const std::string text = fault.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  FaultOrder order;
  if (text.size() >= order.script.size()) {
    throw base::ConfigError("a fault by hand has at most 1000 characters");
  }
  std::ranges::copy(text, order.script.begin());
  entry->orders.publish(order);
}

}  // namespace cas::sim
