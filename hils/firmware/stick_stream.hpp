// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "hils/flight/flight_step.hpp"
#include "mavlink/common/manual_control.hpp"

namespace cas::hils {

/// The sticks of a remote control as MANUAL_CONTROL, on the vehicle's own clock. No I/O; the
/// vehicle's time comes in.
class StickStream {
 public:
  /// As often as ground stations send them.
  static constexpr double kRate_hz = 25;

  /// From now on these sticks, until the end of the flight: PX4 takes their end for a lost remote
  /// control.
  void hold(const Sticks& sticks);
  /// Sends none from now on, or again: the radio is lost. Their time goes on.
  void lose(bool lost) { lost_ = lost; }
  /// For how long these sticks have been held, by the vehicle's clock.
  base::Duration held_for() const { return since_ ? newest_ - *since_ : base::Duration{}; }

  /// The vehicle's clock has gone on. @return the message that is due
  std::optional<mavlink::common::ManualControl> update(base::Duration vehicle_time);

 private:
  std::optional<Sticks> sticks_;
  bool lost_ = false;
  base::RateGate gate_{kRate_hz};
  std::optional<base::Duration> since_;  ///< nullopt: they were not sent yet
  base::Duration newest_{};
};

}  // namespace cas::hils
