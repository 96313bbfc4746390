// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/ledger.hpp"
#include "hils/flight_facts.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/core/sim_runner.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// The simulator with its interface plugin on the topic bus, moved by the virtual clock: what
/// hilsim is, without the UDP socket.
///
/// The step from t to t + dt is computed at t + dt, with the commands that had arrived by t.
class VirtualSimulator {
 public:
  using OnBytes = std::function<void(std::span<const std::uint8_t>, base::RunTime)>;

  /// `on_bytes` hears each packet that the simulator sends. @throws base::ConfigError
  VirtualSimulator(sim::SimConfig config, sim::SimOptions options, const std::string& vehicle,
                   OnBytes on_bytes);
  VirtualSimulator(const VirtualSimulator&) = delete;
  VirtualSimulator& operator=(const VirtualSimulator&) = delete;

  /// Bytes for the simulator.
  void write(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Computes the step that ends now.
  void step(base::RunTime now);
  /// When the next step ends.
  base::RunTime next_event() const;
  /// What the flight is about, for the plugins.
  void set_flight_phase(std::string_view name);
  /// Writes the files of the run.
  void finish() { runner_.finish(); }

  /// Figures of its plugins, as `plugins` in what `hilsim --stats` writes.
  std::string stats_json() const;
  const sim::World& world() const { return runner_.world(); }
  base::SimTime time() const { return runner_.time(); }
  /// True motion of the vehicle, counted from where it stood.
  Motion motion() const;
  const std::vector<base::LedgerEntry>& ledger() const { return ledger_.entries(); }

 private:
  struct Arrival {
    base::RunTime at;
    sim::WirePacket packet;
  };
  void on_wire_out(const sim::WirePacket& packet);

  sim::SimRunner runner_;
  sim::Publisher<sim::WirePacket> wire_in_;
  sim::Subscription wire_out_;
  OnBytes on_bytes_;
  mav::PacketParser sent_;
  mav::PacketParser received_;
  base::PacketLedger ledger_;
  std::deque<Arrival> arrived_;
  Eigen::Vector3d start_W_ = Eigen::Vector3d::Zero();
  std::string phase_;
  base::RunTime now_{};
};

}  // namespace cas::hils
