// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/measure/histogram.hpp"
#include "base/time/clock.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/load/sim_config.hpp"

namespace cas::sim {

/// Decides when a step may start. Reads no clock: time comes in as an argument.
///
/// realtime: step at simulated time t has the absolute deadline epoch + (t - t_epoch) / speed, so
/// that lateness never adds up. Steps delayed by a few milliseconds follow at once; after a longer
/// stall steps come at most `catch_up_rate` times as fast as ordered, never in a burst that would
/// flood a serial line. A lag above `max_lag` is given up: the epoch moves, and the real-time
/// factor falls. lockstep: as realtime while a peer does not answer yet, or when a speed was
/// ordered; else at once. free_run: at once.
class CAS_SIM_EXPORT Pacer {
 public:
  Pacer(const PaceConfig& config, base::Duration step);

  /// Ties simulated time `t` to `now`: at the start and after each pause.
  void restart(base::RunTime now, base::SimTime t);
  /// Lockstep: whether all peers answer. Call before start_of().
  void set_peers_in_step(bool in_step, base::RunTime now, base::SimTime t);
  /// Moment at which the step from simulated time `t` may start; not after `now` means at once.
  base::RunTime start_of(base::SimTime t) const;
  /// Books a step from `t` that starts at `now`.
  void on_start(base::RunTime now, base::SimTime t);

  /// Steps that started more than one step (of wall clock) behind their deadline.
  std::uint64_t late_steps() const { return late_steps_; }
  /// Wall clock given up because the lag passed `max_lag`.
  base::Duration given_up() const { return given_up_; }
  const base::Histogram& lateness() const { return lateness_; }
  void clear_figures();

 private:
  base::RunTime deadline(base::SimTime t) const;

  PaceConfig config_;
  base::Duration wall_step_;          // wall clock of one step at the ordered speed
  base::Duration shortest_interval_;  // between steps that catch up
  base::RunTime epoch_wall_{};
  base::SimTime epoch_sim_{};
  base::RunTime planned_{};  // start of the last step, had the thread been there in time
  bool started_ = false;
  bool by_clock_;  // else at once
  std::uint64_t late_steps_ = 0;
  base::Duration given_up_{};
  base::Histogram lateness_;
};

}  // namespace cas::sim
