// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "mavlink/common/hil_state_quaternion.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "plugins/common/datagram_link.hpp"

namespace cas::sim {

/// Most packets of the true motion in a second of simulated time.
inline constexpr double kMostTruthHz = 250;

/// Shows a viewer the true motion of a vehicle, as PX4's own simulation in hardware (SIH) shows it
/// on UDP port 19410. It has its own socket: a flight controller never gets these packets.
class TruthViewer {
 public:
  /// @param node  key `viewer` of the plugin: remote (127.0.0.1:19410), rate_hz (50)
  /// @throws base::ConfigError
  TruthViewer(const base::ConfigNode& node, mav::Source self);

  bool due(base::SimTime now) { return rate_.due(now); }
  /// Never blocks: drops the packet if the socket is full.
  void show(const mavlink::common::HilStateQuaternion& truth);
  /// Back to time zero.
  void reset() { rate_.reset(); }
  nlohmann::ordered_json figures() const;

 private:
  mav::Source self_;
  DatagramLink sender_;
  base::RateGate rate_;
  std::array<std::uint8_t, mav::kMaxPacketBytes> packet_{};
  std::uint8_t sequence_ = 0;
};

}  // namespace cas::sim
