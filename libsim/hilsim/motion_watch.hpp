// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "libsim/core/run/sim_loop.hpp"

namespace cas::sim {

/// The newest motion of everything that moves, for `sim.watch`: poses, rotor speeds, beams, wind;
/// and of the lidars for `sim.clouds`.
///
///   simulation thread: publish --> newest rotor speeds and beams        take() --> sample
///   another thread:                                                     json(sample)
///
/// The simulation thread copies plain numbers; texts are made elsewhere.
class MotionWatch {
 public:
  struct Sample;

  /// Subscribes on the bus: before SimRunner::start(), which both must outlive.
  explicit MotionWatch(SimLoop& loop);
  ~MotionWatch();
  MotionWatch(const MotionWatch&) = delete;
  MotionWatch& operator=(const MotionWatch&) = delete;

  /// On the simulation thread, between two steps.
  std::shared_ptr<const Sample> take() const;
  /// On any thread: the answer to `sim.watch`.
  nlohmann::json json(const Sample& sample) const;
  /// On any thread: the answer to `sim.clouds`.
  static nlohmann::json clouds_json(const Sample& sample);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::sim
