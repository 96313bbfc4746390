// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/flight/flight_facts.hpp"
#include "hils/virtual/virtual_wire.hpp"
#include "libsim/core/run/sim_runner.hpp"

namespace cas::hils {

/// The simulator with its interface plugins on the topic bus, moved by the virtual clock: what
/// hilsim is, without the UDP sockets.
///
/// The step from t to t + dt is computed at t + dt, with the commands that had arrived by t.
class VirtualSimulator {
 public:
  using OnBytes = VirtualWire::OnBytes;

  /// @param on_bytes  for each vehicle of the configuration, in its order: hears what it sends
  /// @throws base::ConfigError
  VirtualSimulator(sim::SimConfig config, sim::SimOptions options, std::vector<OnBytes> on_bytes);
  VirtualSimulator(const VirtualSimulator&) = delete;
  VirtualSimulator& operator=(const VirtualSimulator&) = delete;

  /// Computes the step that ends now.
  void step(base::RunTime now);
  /// When the next step ends.
  base::RunTime next_event() const;
  /// What the flight is about, for the plugins.
  void set_flight_phase(std::string_view name);
  /// Writes the files of the run.
  void finish() { runner_.finish(); }

  VirtualWire& wire(std::size_t vehicle = 0) { return *wires_[vehicle]; }
  const VirtualWire& wire(std::size_t vehicle = 0) const { return *wires_[vehicle]; }
  /// True motion of a vehicle, counted from where it stood.
  Motion motion(std::size_t vehicle) const { return wire(vehicle).motion(runner_.world()); }

  /// Figures of its plugins, as `plugins` in what `hilsim --stats` writes.
  std::string stats_json() const;
  const sim::World& world() const { return runner_.world(); }
  base::SimTime time() const { return runner_.time(); }

 private:
  sim::SimRunner runner_;
  std::vector<std::unique_ptr<VirtualWire>> wires_;
  std::string phase_;
};

}  // namespace cas::hils
