// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// How often the ground station of an experiment loads the parameter list.
inline constexpr base::Duration kParameterListPeriod = std::chrono::seconds(20);

/// The traffic of a ground station that is connected during an experiment: a heartbeat each second,
/// centred sticks (MANUAL_CONTROL) for each vehicle 25 times a second, the whole parameter list
/// when it meets a vehicle and again every `list_period`. Pure: time and bytes come in as
/// arguments.
class GroundStation {
 public:
  using Send = std::function<void(std::span<const std::uint8_t>)>;

  /// @param systems  the vehicles
  GroundStation(const std::vector<std::uint8_t>& systems, base::Duration list_period, Send send);

  void on_bytes(std::span<const std::uint8_t> bytes);
  /// Call it at least every `kTickPeriod`.
  void tick(base::RunTime now);

  /// Sends so many packets a second besides, to the vehicles in turn; 0: none.
  void flood(double packets_hz) { flood_ = base::RateGate(packets_hz); }

  static constexpr base::Duration kTickPeriod = std::chrono::milliseconds(20);

 private:
  struct Vehicle {
    std::uint8_t system = 0;
    bool heard = false;
    base::RunTime next_sticks{};
    std::optional<base::RunTime> next_list{};
  };
  void on_packet(const mav::PacketView& packet);
  void attend(Vehicle& vehicle, base::RunTime now);
  void send_flood(base::RunTime last, base::RunTime now);

  std::vector<Vehicle> vehicles_;
  base::Duration list_period_;
  Send send_;
  mav::Encoder encode_;
  mav::PacketParser parser_;
  base::RateGate flood_;
  base::RunTime last_tick_{};
  base::RunTime next_heartbeat_{};
};

}  // namespace cas::hils
