// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "libsim/api/messages.hpp"

namespace cas::sim {

/// A receiver's report while noise covers its satellites.
///
/// C/N0 is `loss_db` lower. Satellites below kLeastCn0_db_hz are not used. The claimed accuracy is
/// worse by sqrt(10^(loss_db / 10)), as a code loop's noise, and by sqrt(satellites before / now),
/// as the geometry; the position has white noise of what was added to the claim. With fewer than
/// four satellites there is no fix. Velocity and the time that a receiver takes to find satellites
/// again are not modelled.
GpsSample jammed_sample(GpsSample sample, double loss_db, const base::LocalProjection& projection,
                        base::NormalRandom& random);

/// An error that is correlated in time: first order, Gauss-Markov, from its standing distribution
/// on. Samples may come at any time.
class CorrelatedError {
 public:
  /// @param stddev  standing deviation of each axis
  Eigen::Vector3d at(base::SimTime time, const Eigen::Vector3d& stddev, double time_constant_s,
                     base::NormalRandom& random);

 private:
  Eigen::Vector3d value_ = Eigen::Vector3d::Zero();
  std::optional<base::SimTime> at_;
};

}  // namespace cas::sim
