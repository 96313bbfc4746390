// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/pid.hpp"

#include <algorithm>

namespace cas::fcu {

void Pid::take_gains(double error, double measurement_rate) {
  // Without an integrator nothing would ever take the offset away again.
  if (started_ && next_.i > 0) {
    integral_ += (gains_.p - next_.p) * error - (gains_.d - next_.d) * measurement_rate;
  }
  gains_ = next_;
  started_ = true;
  if (gains_.i == 0) integral_ = 0;
}

double Pid::update(double error, double measurement_rate, double dt, Saturation saturation) {
  if (!(next_ == gains_) || !started_) take_gains(error, measurement_rate);
  const double step = gains_.i * error * dt;
  const bool winding_up = (step > 0 && saturation.up) || (step < 0 && saturation.down);
  if (!winding_up) integral_ += step;
  integral_ = std::clamp(integral_, -gains_.i_limit, gains_.i_limit);
  return gains_.p * error + integral_ - gains_.d * measurement_rate;
}

}  // namespace cas::fcu
