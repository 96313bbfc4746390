// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>

#include "base/clock.hpp"
#include "base/rate_gate.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// How often the ground station of an experiment loads the parameter list.
inline constexpr base::Duration kParameterListPeriod = std::chrono::seconds(20);

/// The traffic of a ground station that is connected during an experiment: a heartbeat each second,
/// centred sticks (MANUAL_CONTROL) 25 times a second, the whole parameter list when it meets the
/// vehicle and again every `list_period`. Pure: time and bytes come in as arguments.
class GroundStation {
 public:
  using Send = std::function<void(std::span<const std::uint8_t>)>;

  GroundStation(std::uint8_t vehicle_system, base::Duration list_period, Send send);

  void on_bytes(std::span<const std::uint8_t> bytes);
  /// Call it at least every `kTickPeriod`.
  void tick(base::RunTime now);

  /// Sends so many packets a second besides; 0: none.
  void flood(double packets_hz) { flood_ = base::RateGate(packets_hz); }

  static constexpr base::Duration kTickPeriod = std::chrono::milliseconds(20);

  std::uint64_t received() const { return received_; }           ///< packets
  std::size_t parameters() const { return parameters_.size(); }  ///< different ones, so far

 private:
  void on_packet(const mav::PacketView& packet);
  void send_flood(base::RunTime last, base::RunTime now);

  std::uint8_t vehicle_system_;
  base::Duration list_period_;
  Send send_;
  mav::Encoder encode_;
  mav::PacketParser parser_;
  std::uint64_t received_ = 0;
  bool vehicle_heard_ = false;
  base::RateGate flood_;
  base::RunTime last_tick_{};
  std::set<std::uint16_t> parameters_;
  base::RunTime next_heartbeat_{};
  base::RunTime next_sticks_{};
  std::optional<base::RunTime> next_list_;
};

}  // namespace cas::hils
