// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/sim_loop.hpp"

#include <utility>

namespace cas::sim {

namespace {

using SteadyPoint = std::chrono::time_point<std::chrono::steady_clock, base::Duration>;

/// Most that a pause in lockstep waits for a sensor message that is answered.
constexpr base::Duration kLongestSettling = std::chrono::milliseconds(200);

/// RunTime is CLOCK_MONOTONIC, as is steady_clock.
SteadyPoint to_steady(base::RunTime t) { return SteadyPoint(t.time_since_epoch()); }

}  // namespace

SimLoop::SimLoop(SimRunner& runner, const PaceConfig& pace)
    : runner_(runner), pacer_(pace, runner.step_size()) {
  runner_.set_interrupt(&stopping_);
}

void SimLoop::run(std::optional<base::SimTime> until) {
  now_ = base::steady_now();
  start_clock();
  while (!stopping_.load(std::memory_order_relaxed)) {
    if (has_orders_.load(std::memory_order_acquire)) take_orders();
    if (until && runner_.time() >= *until) break;
    pacer_.set_peers_in_step(runner_.peers_in_step(), now_, runner_.time());
    if (paused_ && steps_left_ == 0) {
      wait_for_order();
    } else if (steps_left_ > 0 || wait_until(pacer_.start_of(runner_.time()))) {
      make_step();
    }
  }
  stop_clock();
}

/// One step and the actions at its end.
void SimLoop::make_step() {
  if (steps_left_ == 0) pacer_.on_start(now_, runner_.time());
  step_once();
  if (steps_left_ > 0 && --steps_left_ == 0) reach(done_);
  if (pause_at_ && runner_.time() >= *pause_at_) {
    pause_at_.reset();
    pause();
    reach(done_);
  }
}

void SimLoop::step_once() {
  runner_.step();
  const base::RunTime end = base::steady_now();
  step_times_.add(end - now_);
  now_ = end;
}

void SimLoop::reach(std::function<void()>& done) {
  if (const auto answer = std::exchange(done, nullptr)) answer();
}

/// @return false when something else has to be done first
bool SimLoop::wait_until(base::RunTime moment) {
  if (moment <= now_) return true;
  base::MutexLock lock(mutex_);
  wake_.wait_until(lock, to_steady(moment),
                   [this]() CAS_REQUIRES(mutex_) { return !orders_.empty() || stopping_; });
  now_ = base::steady_now();
  return now_ >= moment && orders_.empty() && !stopping_;
}

void SimLoop::wait_for_order() {
  base::MutexLock lock(mutex_);
  wake_.wait(lock, [this]() CAS_REQUIRES(mutex_) { return !orders_.empty() || stopping_; });
  now_ = base::steady_now();
}

void SimLoop::take_orders() {
  std::vector<std::function<void()>> orders;
  {
    const base::MutexLock lock(mutex_);
    orders.swap(orders_);
    has_orders_ = false;
  }
  for (const auto& order : orders) order();
  now_ = base::steady_now();
}

void SimLoop::post(std::function<void()> order) {
  {
    const base::MutexLock lock(mutex_);
    orders_.push_back(std::move(order));
    has_orders_ = true;
  }
  wake_.notify_one();
}

void SimLoop::stop() {
  {
    const base::MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
}

void SimLoop::pause() {
  if (paused_) return;
  settle();
  stop_clock();
  paused_ = true;
}

/// Lockstep: steps on until the newest sensors have been answered, so that nothing is in flight
/// while the simulation is paused, and a command given then always falls between the same two
/// packets.
void SimLoop::settle() {
  const base::SimTime latest = runner_.time() + kLongestSettling;
  while (!runner_.settled() && runner_.time() < latest && !stopping_) step_once();
}

void SimLoop::resume() {
  if (!paused_) return;
  paused_ = false;
  start_clock();
}

void SimLoop::step(std::uint64_t count, std::function<void()> done) {
  pause();
  reach(done_);
  steps_left_ = count;
  done_ = std::move(done);
  if (count == 0) reach(done_);
}

void SimLoop::run_until(base::SimTime time, std::function<void()> done) {
  reach(done_);
  done_ = std::move(done);
  if (runner_.time() >= time) {
    pause();
    return reach(done_);
  }
  pause_at_ = time;
  steps_left_ = 0;
  resume();
}

void SimLoop::reset() {
  runner_.reset();
  pacer_.clear_figures();
  step_times_.clear();
  pause_at_.reset();
  steps_left_ = 0;
  wall_ = {};
  reach(done_);
  if (!paused_) start_clock();
}

void SimLoop::start_clock() {
  now_ = base::steady_now();
  clock_started_ = now_;
  clock_runs_ = true;
  pacer_.restart(now_, runner_.time());
}

void SimLoop::stop_clock() {
  if (!std::exchange(clock_runs_, false)) return;
  wall_ += base::steady_now() - clock_started_;
}

LoopFigures SimLoop::figures() const {
  LoopFigures f;
  f.time = runner_.time();
  f.steps = runner_.steps();
  f.paused = paused_;
  base::Duration wall = wall_;
  if (clock_runs_) wall += base::steady_now() - clock_started_;
  f.wall_s = base::to_seconds(wall);
  f.real_time_factor = f.wall_s > 0 ? base::to_seconds(f.time) / f.wall_s : 0;
  f.late_steps = pacer_.late_steps();
  f.lockstep_timeouts = runner_.lockstep_timeouts();
  f.given_up_s = base::to_seconds(pacer_.given_up());
  return f;
}

}  // namespace cas::sim
