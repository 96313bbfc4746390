// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "base/time/clock.hpp"

namespace cas::sim {

/// The way packets take out of and into the simulator. Never blocks apart from `wait`.
class HilPort {
 public:
  /// Bytes of one datagram, with the moment at which they reached this machine.
  using OnBytes = std::function<void(std::span<const std::uint8_t>, base::RunTime)>;

  virtual ~HilPort() = default;
  /// @return false when the packet was not taken (counted by the port)
  virtual bool send(std::span<const std::uint8_t> packet) = 0;
  /// Hands over all that has arrived.
  virtual void poll(const OnBytes& on_bytes) = 0;
  /// Waits until something has arrived. @return false after `timeout` or on a signal
  virtual bool wait(base::Duration timeout) = 0;
  /// The clock of the ledger: steady in real time, the simulation's on the bus.
  virtual base::RunTime now() const = 0;
  /// Sets the simulated time; called before each use in a step.
  virtual void set_sim_time(base::SimTime) {}
  /// Number of peers so far, one after the other; a connectionless port has one from the start.
  virtual std::uint64_t peers() const { return 1; }
  virtual bool connected() const { return true; }
  virtual std::string endpoint() const = 0;  ///< "udp 127.0.0.1:14560"
  /// Adds the port's counters to the figures of a run.
  virtual void add_figures(nlohmann::ordered_json& /*figures*/) const {}
};

}  // namespace cas::sim
