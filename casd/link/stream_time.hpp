// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "base/time/stream_clock.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Lockstep: the time that casd's own station runs on, taken from the HIL_SENSOR stream that
/// passes.
///
/// Each 50 ms of it the stream is held while the station has its turn (retries, heartbeats), so
/// that each packet of the station's comes between the same two sensor messages in every run,
/// however busy the machine is.
///
///   HIL_SENSOR -> turn due? -- yes --> older packets go out --> the station's turn -------+
///                    | no                                                                 |
///                    +--> routed and delivered <------------------------------------------+
class StreamTime {
 public:
  static constexpr base::Duration kTurnPeriod = std::chrono::milliseconds(50);
  /// Gives the station its turn at a moment of the stream, and returns when it is over.
  using Turn = std::function<void(base::RunTime)>;

  /// Before any link runs. Without it casd runs on the steady clock.
  void enable(Turn turn) { turn_ = std::move(turn); }
  bool enabled() const { return static_cast<bool>(turn_); }

  /// From any link's thread, for each packet before it is routed; `before_turn` is called when a
  /// turn is due, before it.
  template <class BeforeTurn>
  void on_packet(const mav::PacketView& packet, BeforeTurn&& before_turn) {
    if (!enabled() || !is_sensor(packet)) return;
    const base::MutexLock turn_lock(turn_mutex_);
    if (const std::optional<base::RunTime> turn = advance(packet)) {
      before_turn();
      turn_(*turn);
    }
  }

  /// From any thread: the stamp of the newest HIL_SENSOR; zero before the first.
  base::RunTime now() const;

 private:
  static bool is_sensor(const mav::PacketView& packet);
  /// @return the moment of the turn that is due, if any
  std::optional<base::RunTime> advance(const mav::PacketView& packet) CAS_REQUIRES(turn_mutex_);

  Turn turn_;
  base::Mutex turn_mutex_;  ///< one sensor message at a time
  mutable base::Mutex mutex_;
  base::StreamClock clock_ CAS_GUARDED_BY(mutex_);
  std::optional<base::RunTime> next_turn_ CAS_GUARDED_BY(mutex_);
};

}  // namespace cas::casd
