// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/measure/ledger.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/flight_facts.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/topic_bus.hpp"
#include "libsim/api/world.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// One vehicle of the simulator as seen from outside: the packets that its interface plugin sends
/// and takes over the topic bus, and how the vehicle moves.
class VirtualWire {
 public:
  using OnBytes = std::function<void(std::span<const std::uint8_t>, base::RunTime)>;

  /// Before the bus is frozen.
  ///
  /// @param name  of the vehicle, the folder of its topics
  /// @param on_bytes  receives each packet of the simulator
  VirtualWire(sim::TopicBus& bus, const std::string& name, sim::VehicleId id, OnBytes on_bytes);
  VirtualWire(const VirtualWire&) = delete;
  VirtualWire& operator=(const VirtualWire&) = delete;

  /// Bytes for the vehicle.
  void write(std::span<const std::uint8_t> bytes, base::RunTime now);

  /// Begins the run: motion is counted from the vehicle's present place.
  void start(const sim::World& world);
  /// Hands over packets that had arrived by then. Packets that the vehicle sends from now on leave
  /// at `now`.
  void deliver(base::RunTime arrived_by, base::RunTime now);

  /// True motion, counted from where it stood.
  Motion motion(const sim::World& world) const;
  const std::vector<base::LedgerEntry>& ledger() const { return ledger_.entries(); }

 private:
  struct Arrival {
    base::RunTime at;
    sim::WirePacket packet;
  };
  void on_wire_out(const sim::WirePacket& packet);

  sim::VehicleId id_;
  sim::Publisher<sim::WirePacket> wire_in_;
  sim::Subscription wire_out_;
  OnBytes on_bytes_;
  mav::PacketParser sent_;
  mav::PacketParser received_;
  base::PacketLedger ledger_;
  std::deque<Arrival> arrived_;
  Eigen::Vector3d start_W_ = Eigen::Vector3d::Zero();
  base::RunTime now_{};
};

/// The simulator with its interface plugins on the topic bus, moved by the virtual clock: hilsim
/// without the UDP sockets.
///
/// The step from t to t + dt is computed at t + dt, with the commands that had arrived by t.
class VirtualSimulator {
 public:
  using OnBytes = VirtualWire::OnBytes;

  /// @param on_bytes  for each vehicle of the configuration, in its order: receives its bytes
  /// @throws base::ConfigError
  VirtualSimulator(sim::SimConfig config, sim::SimOptions options, std::vector<OnBytes> on_bytes);
  VirtualSimulator(const VirtualSimulator&) = delete;
  VirtualSimulator& operator=(const VirtualSimulator&) = delete;

  /// Computes the step that ends now.
  void step(base::RunTime now);
  /// When the next step ends.
  base::RunTime next_event() const;
  /// Phase of the flight, for the plugins.
  void set_flight_phase(std::string_view name) { runner_.set_flight_phase(name); }
  /// Writes the files of the run.
  void finish() { runner_.finish(); }

  VirtualWire& wire(std::size_t vehicle = 0) { return *wires_[vehicle]; }
  const VirtualWire& wire(std::size_t vehicle = 0) const { return *wires_[vehicle]; }
  /// True motion of a vehicle, counted from where it stood.
  Motion motion(std::size_t vehicle) const { return wire(vehicle).motion(runner_.world()); }

  /// Figures of its plugins, as `plugins` in the report of `hilsim --stats`.
  std::string stats_json() const;
  const sim::World& world() const { return runner_.world(); }
  base::SimTime time() const { return runner_.time(); }

 private:
  sim::SimRunner runner_;
  std::vector<std::unique_ptr<VirtualWire>> wires_;
};

}  // namespace cas::hils
