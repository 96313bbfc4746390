// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/pacer.hpp"

#include <algorithm>
#include <cmath>

namespace cas::sim {

namespace {

base::Duration divided(base::Duration d, double by) {
  return base::Duration(std::llround(static_cast<double>(d.count()) / by));
}

bool goes_by_clock(const PaceConfig& config, bool peers_in_step) {
  if (config.mode != PaceMode::kLockstep) return config.mode == PaceMode::kRealtime;
  return config.speed_given || !peers_in_step;
}

}  // namespace

Pacer::Pacer(const PaceConfig& config, base::Duration step)
    : config_(config),
      wall_step_(divided(step, config.speed)),
      shortest_interval_(divided(step, config.speed * config.catch_up_rate)),
      by_clock_(goes_by_clock(config, true)) {}

void Pacer::set_peers_in_step(bool in_step, base::RunTime now, base::SimTime t) {
  const bool by_clock = goes_by_clock(config_, in_step);
  if (by_clock == by_clock_) return;
  by_clock_ = by_clock;
  restart(now, t);
}

void Pacer::restart(base::RunTime now, base::SimTime t) {
  epoch_wall_ = now;
  epoch_sim_ = t;
  started_ = false;
}

base::RunTime Pacer::deadline(base::SimTime t) const {
  if (config_.speed == 1.0) return epoch_wall_ + (t - epoch_sim_);
  return epoch_wall_ + divided(t - epoch_sim_, config_.speed);
}

base::RunTime Pacer::start_of(base::SimTime t) const {
  if (!by_clock_) return base::RunTime::min();
  const base::RunTime due = deadline(t);
  return started_ ? std::max(due, planned_ + shortest_interval_) : due;
}

void Pacer::on_start(base::RunTime now, base::SimTime t) {
  if (!by_clock_) return;
  const base::RunTime planned = start_of(t);
  const base::Duration lateness = std::max(base::Duration::zero(), now - deadline(t));
  lateness_.add(lateness);
  if (lateness > wall_step_) ++late_steps_;
  if (lateness > config_.max_lag) {
    epoch_wall_ += lateness;
    given_up_ += lateness;
  }
  planned_ = std::max(planned, now - config_.largest_burst);
  started_ = true;
}

void Pacer::clear_figures() {
  late_steps_ = 0;
  given_up_ = {};
  lateness_.clear();
}

}  // namespace cas::sim
