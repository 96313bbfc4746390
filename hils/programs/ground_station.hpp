// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/run/loopback_udp.hpp"
#include "hils/run/ticking_thread.hpp"
#include "mavlink/common/manual_control.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// The ids that ground stations use.
inline constexpr mav::Source kGroundStation{.system = 255, .component = 190};

/// How often the ground station of an experiment loads the parameter list.
inline constexpr base::Duration kParameterListPeriod = std::chrono::seconds(20);

/// The sticks as ground stations send them; the receiver's system is left to the caller.
mavlink::common::ManualControl manual_control(const Sticks& sticks);

/// The traffic of a ground station that is connected during an experiment: a heartbeat each second,
/// sticks (MANUAL_CONTROL, centred at first) for each vehicle 25 times a second, the whole
/// parameter list when it meets a vehicle and again every `list_period`. Pure: time and bytes come
/// in as arguments.
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
  /// Sends nothing from now on, or again.
  void silence(bool silent) { silent_ = silent; }
  /// The sticks of a vehicle from now on.
  void hold(std::uint8_t system, const Sticks& sticks);
  /// Sends no sticks from now on, or again.
  void lose_sticks(bool lost) { sticks_lost_ = lost; }

  static constexpr base::Duration kTickPeriod = std::chrono::milliseconds(20);

 private:
  struct Vehicle {
    std::uint8_t system = 0;
    bool heard = false;
    Sticks sticks{};
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
  bool silent_ = false;
  bool sticks_lost_ = false;
  base::RunTime last_tick_{};
  base::RunTime next_heartbeat_{};
};

/// A GroundStation on a UDP socket of its own, with a thread, for runs in real time.
class GroundStationThread {
 public:
  /// Binds 127.0.0.1 with a free port; sends to the peer that wrote last. @throws base::ConfigError
  explicit GroundStationThread(const std::vector<std::uint8_t>& systems);
  GroundStationThread(const GroundStationThread&) = delete;
  GroundStationThread& operator=(const GroundStationThread&) = delete;

  /// Calls `change` with the station between two of its packets.
  template <class Change>
  void with_station(Change&& change) {
    base::MutexLock lock(mutex_);
    change(station_);
  }
  std::uint16_t port() const { return socket_.port(); }

 private:
  void look();

  base::Mutex mutex_;
  LoopbackUdp socket_;
  GroundStation station_ CAS_GUARDED_BY(mutex_);
  TickingThread thread_;
};

}  // namespace cas::hils
