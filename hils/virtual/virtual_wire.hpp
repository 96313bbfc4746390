// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/measure/ledger.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/flight_facts.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/topic_bus.hpp"
#include "libsim/api/world.hpp"
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
  /// @param on_bytes  hears each packet that the simulator sends
  VirtualWire(sim::TopicBus& bus, const std::string& name, sim::VehicleId id, OnBytes on_bytes);
  VirtualWire(const VirtualWire&) = delete;
  VirtualWire& operator=(const VirtualWire&) = delete;

  /// Bytes for the vehicle.
  void write(std::span<const std::uint8_t> bytes, base::RunTime now);

  /// The run begins: the vehicle stands where its motion is counted from.
  void start(const sim::World& world);
  /// Hands over what had arrived by then. Packets that the vehicle sends from now on leave at
  /// `now`.
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

}  // namespace cas::hils
