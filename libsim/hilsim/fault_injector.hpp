// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "libsim/api/fault_order.hpp"
#include "libsim/api/topic_bus.hpp"
#include "libsim/core/run/sim_runner.hpp"

namespace cas::sim {

/// Passes faults that are ordered in flight to the vehicles' plugins `fault`.
class FaultInjector {
 public:
  /// Before the runner starts: afterwards nothing is wired.
  explicit FaultInjector(SimRunner& runner);

  /// On the simulation thread, between two steps.
  /// @param vehicle  its name @param fault  an entry of `faults` without `at_s` and `when`
  /// @throws base::ConfigError in one sentence: no such vehicle, no plugin that takes orders, or a
  /// fault that this vehicle cannot have
  void order(const std::string& vehicle, nlohmann::json fault) const;

 private:
  struct Entry {
    std::string vehicle;
    Publisher<FaultOrder> orders;
  };
  std::vector<Entry> entries_;
};

}  // namespace cas::sim
