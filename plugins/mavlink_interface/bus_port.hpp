// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/mavlink_interface/hil_port.hpp"

namespace cas::sim {

/// Packets over the topic bus of the process: `wire_out` to the composer of the run, `wire_in`
/// back. Its clock is the simulation's.
class BusPort final : public HilPort {
 public:
  explicit BusPort(PluginContext& context)
      : out_(context.bus().advertise<WirePacket>(context.topic("wire_out"))),
        in_(context.bus().subscribe<WirePacket>(
            context.topic("wire_in"),
            [this](const WirePacket& packet) { arrived_.push_back(packet); })) {
    constexpr std::size_t kUsual = 16;  // more than arrive in one step
    arrived_.reserve(kUsual);
  }
  BusPort(const BusPort&) = delete;
  BusPort& operator=(const BusPort&) = delete;

  bool send(std::span<const std::uint8_t> bytes) override {
    packet_.size = bytes.size();
    std::copy(bytes.begin(), bytes.end(), packet_.bytes.begin());
    out_.publish(packet_);
    return true;
  }
  void poll(const OnBytes& on_bytes) override {
    for (const WirePacket& packet : arrived_) {
      on_bytes(std::span(packet.bytes).first(packet.size), now_);
    }
    arrived_.clear();
  }
  /// On the bus everything that will arrive has arrived.
  bool wait(base::Duration) override { return !arrived_.empty(); }
  base::RunTime now() const override { return now_; }
  void set_sim_time(base::SimTime time) override { now_ = base::RunTime(time.time_since_epoch()); }
  std::string endpoint() const override { return "bus"; }

 private:
  Publisher<WirePacket> out_;
  std::vector<WirePacket> arrived_;
  WirePacket packet_;
  base::RunTime now_;
  Subscription in_;
};

}  // namespace cas::sim
