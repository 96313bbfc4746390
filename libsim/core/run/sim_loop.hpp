// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "base/measure/histogram.hpp"
#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "libsim/core/export.hpp"
#include "libsim/core/run/pacer.hpp"
#include "libsim/core/run/sim_runner.hpp"

namespace cas::sim {

/// Figures of a loop between two steps.
struct LoopFigures {
  base::SimTime time{};
  std::uint64_t steps = 0;
  bool paused = false;
  double wall_s = 0;            ///< time spent running, pauses left out
  double real_time_factor = 0;  ///< simulated over wall time since the start or the last reset
  std::uint64_t late_steps = 0;
  std::uint64_t lockstep_timeouts = 0;
  double given_up_s = 0;  ///< lag that was not caught up
};

/// Runs a SimRunner by the wall clock, by lockstep or freely, and takes orders between steps.
///
///   other threads: post(order) ----> run(): orders -> wait for the moment -> step -> ...
class CAS_SIM_EXPORT SimLoop {
 public:
  SimLoop(SimRunner& runner, const PaceConfig& pace);

  /// Steps until stop() or `until` (simulated time). On the calling thread.
  void run(std::optional<base::SimTime> until = std::nullopt);

  /// From any thread: runs `order` on the loop's thread between two steps.
  void post(std::function<void()> order);
  /// From any thread, also from a signal handler's thread: ends run() after the current step.
  void stop();

  // Orders: on the loop's thread only, inside post().

  /// In lockstep after a few more steps, when nothing is on its way to or from the controllers.
  void pause();
  void resume();
  /// Pauses, then makes `count` steps at once; `done` is called after the last.
  void step(std::uint64_t count, std::function<void()> done);
  /// Runs at the ordered pace and pauses at the first step that ends at or after `time` (lockstep:
  /// see pause()).
  void run_until(base::SimTime time, std::function<void()> done);
  void reset();
  void set_flight_phase(std::string_view name) { runner_.set_flight_phase(name); }

  LoopFigures figures() const;
  const base::Histogram& step_times() const { return step_times_; }
  const base::Histogram& lateness() const { return pacer_.lateness(); }
  const SimRunner& runner() const { return runner_; }
  SimRunner& runner() { return runner_; }

 private:
  void take_orders();
  void wait_for_order();
  bool wait_until(base::RunTime moment);
  void make_step();
  void step_once();
  void settle();
  void reach(std::function<void()>& done);
  void start_clock();
  void stop_clock();

  SimRunner& runner_;
  Pacer pacer_;
  base::Histogram step_times_;

  bool paused_ = false;
  std::uint64_t steps_left_ = 0;           // of step()
  std::optional<base::SimTime> pause_at_;  // of run_until()
  std::function<void()> done_;             // answers step() or run_until()
  base::RunTime now_{};
  bool clock_runs_ = false;
  base::RunTime clock_started_{};
  base::Duration wall_{};

  base::Mutex mutex_;
  std::condition_variable_any wake_;
  std::vector<std::function<void()>> orders_ CAS_GUARDED_BY(mutex_);
  std::atomic<bool> has_orders_{false};
  std::atomic<bool> stopping_{false};
};

}  // namespace cas::sim
