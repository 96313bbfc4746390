// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/control/wing_attitude.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"

namespace cas::fcu {

using Eigen::Vector3d;

namespace {

constexpr double kSteepest_rad = 1.2;  // of roll, for the rate of a turn
constexpr double kLeastAirspeed_m_s = 3;

}  // namespace

Vector3d turn_rates_rad_s(double roll_rad, double pitch_rad, double airspeed_m_s) {
  const double roll = std::clamp(roll_rad, -kSteepest_rad, kSteepest_rad);
  const double turn = base::kStandardGravity_m_s2 * std::tan(roll) / airspeed_m_s;
  return turn * Vector3d(-std::sin(pitch_rad), std::sin(roll) * std::cos(pitch_rad),
                         std::cos(roll) * std::cos(pitch_rad));
}

void WingAttitude::set_params(const WingParams& params) {
  params_ = params;
  rate_[0].set_gains(params.roll_rate);
  rate_[1].set_gains(params.pitch_rate);
  rate_[2].set_gains(params.yaw_rate);
}

Vector3d WingAttitude::update(const Input& in, double dt) {
  const Vector3d rpy = base::euler_rpy(in.q_ND);
  // How fast roll, pitch and heading are to change, seen in D.
  const double roll_rate = (in.roll_rad - rpy.x()) / params_.roll_time_s;
  const double pitch_rate = (in.pitch_rad - rpy.y()) / params_.pitch_time_s;
  const Vector3d change(roll_rate, pitch_rate * std::cos(rpy.x()),
                        -pitch_rate * std::sin(rpy.x()) + in.yaw_rate_rad_s);
  const double v = std::max(in.airspeed.true_m_s, kLeastAirspeed_m_s);
  const Vector3d limit = params_.rate_limit_rad_s;
  wanted_w_D_ = change.cwiseMax(-limit).cwiseMin(limit);
  if (in.integrate) wanted_w_D_ += turn_rates_rad_s(rpy.x(), rpy.y(), v);

  const double slowest = 0.5 * params_.airspeed_min_m_s;
  const double scale = params_.airspeed_trim_m_s / std::max(in.airspeed.equivalent_m_s, slowest);
  if (!in.integrate) reset();
  Vector3d out;
  for (int axis = 0; axis < 3; ++axis) {
    const Saturation stop{last_[axis] >= 1, last_[axis] <= -1};
    const double error = wanted_w_D_[axis] - in.w_D[axis];
    const double by_error = rate_[axis].update(error, 0, dt, stop);
    out[axis] =
        scale * scale * by_error + scale * params_.rate_feed_forward[axis] * wanted_w_D_[axis];
  }
  last_ = out.cwiseMax(-1).cwiseMin(1);
  return last_;
}

}  // namespace cas::fcu
