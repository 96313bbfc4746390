// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "fcu/control/saturation.hpp"

namespace cas::fcu {

/// Gains of one loop, in units of its output (u) and of its error (e).
struct PidGains {
  double p = 0;          ///< u per e
  double i = 0;          ///< u per e and second
  double d = 0;          ///< u per change of e in a second
  double i_limit = 1e9;  ///< largest part of the integrator in u

  friend bool operator==(const PidGains&, const PidGains&) = default;
};

/// u = p e + integral(i e) - d dm/dt. The derivative is that of the measurement, so that a step of
/// the setpoint gives no kick. The integrator stops while the actuator is saturated, and absorbs
/// the jump of the output that a change of the other gains would cause.
class Pid {
 public:
  /// Gains for the next update().
  void set_gains(const PidGains& gains) { next_ = gains; }

  /// @param error             setpoint minus measurement
  /// @param measurement_rate  d(measurement)/dt
  /// @param dt                s
  double update(double error, double measurement_rate, double dt, Saturation saturation = {}) {
    if (!(next_ == gains_) || !started_) take_gains(error, measurement_rate);
    const double step = gains_.i * error * dt;
    const bool winding_up = (step > 0 && saturation.up) || (step < 0 && saturation.down);
    if (!winding_up) integral_ += step;
    integral_ = std::clamp(integral_, -gains_.i_limit, gains_.i_limit);
    return gains_.p * error + integral_ - gains_.d * measurement_rate;
  }

  /// @param integral  part of the output that the integrator starts with
  void reset(double integral = 0) { integral_ = integral; }
  /// The integrator's part of the output.
  double integral() const { return integral_; }

 private:
  void take_gains(double error, double measurement_rate) {
    // Without an integrator nothing would ever take the offset away again.
    if (started_ && next_.i > 0) {
      integral_ += (gains_.p - next_.p) * error - (gains_.d - next_.d) * measurement_rate;
    }
    gains_ = next_;
    started_ = true;
    if (gains_.i == 0) integral_ = 0;
  }

  PidGains gains_;
  PidGains next_;
  bool started_ = false;
  double integral_ = 0;
};

}  // namespace cas::fcu
