// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/wing_task.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth/frames.hpp"

namespace cas::fcu {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kLifted_m = 0.5;      // above the ground it flies
constexpr double kClimbsFrom = 0.9;    // of the cruise airspeed
constexpr double kReached_m = 1.5;     // below the height of a take-off
constexpr double kLead_m = 60;         // level flight before the slope
constexpr double kLowRoll_rad = 0.15;  // near the ground: the wing tips stay off it
constexpr double kLow_m = 5;
constexpr double kOnWheels_m_s = 4;  // at the end of a landing the wheels carry it
constexpr double kStill_m_s = 0.7;
constexpr double kStill_s = 1;

Vector2d direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

double height_m(const TaskContext& context) { return context.ground_z - context.estimate.p_N.z(); }

}  // namespace

void WingTask::circle(const Vector3d& middle_N, double radius_m) {
  CirclePath* now = std::get_if<CirclePath>(&path_);
  CirclePath next = now != nullptr ? *now : CirclePath{};
  if (middle_N.head<2>().allFinite()) next.centre_N = middle_N.head<2>();
  if (std::isfinite(radius_m) && radius_m != 0) next.radius_m = radius_m;
  if (std::isfinite(middle_N.z())) z_m_ = middle_N.z();
  path_ = next;
}

void WingTask::activate(const TaskContext& context) {
  time_s_ = still_s_ = 0;
  if (mode_ == FlightMode::kTakeoff) {
    const Vector2d here = context.estimate.p_N.head<2>();
    stage_ = Stage::kRun;
    heading_rad_ = context.yaw_rad;
    path_ = LinePath{.from_N = here, .to_N = here + direction(heading_rad_)};
    z_m_ = takeoff_z_.value_or(context.ground_z - context.params.takeoff_altitude_m);
  } else if (mode_ == FlightMode::kLand || mode_ == FlightMode::kReturn) {
    begin_landing(context);
  } else {
    begin_circle(context);
  }
}

void WingTask::begin_circle(const TaskContext& context) {
  const bool climbed = stage_ == Stage::kClimb;  // to the height of the take-off
  stage_ = Stage::kCircle;
  path_ = CirclePath{.centre_N = context.estimate.p_N.head<2>(),
                     .radius_m = context.wing.loiter_radius_m};
  if (!climbed) z_m_ = context.estimate.p_N.z();
}

/// A circle that touches the line of the slope at its upper end, on the nearer side.
void WingTask::begin_landing(const TaskContext& context) {
  stage_ = Stage::kToSlope;
  const Vector2d here = context.estimate.p_N.head<2>();
  z_m_ = std::min(context.estimate.p_N.z(), context.ground_z - kLow_m);
  const double length_m = (context.ground_z - z_m_) / std::tan(context.wing.land_slope_rad);
  const Vector2d home = context.home_N.head<2>();
  slope_ = {home - direction(context.home_yaw_rad), home};
  const Vector2d ahead = slope_.direction();
  const Vector2d right(-ahead.y(), ahead.x());
  // The flare carries it as far beyond the slope's end as the slope begins it before that.
  slope_.to_N -= context.wing.flare_height_m / std::tan(context.wing.land_slope_rad) * ahead;
  slope_.from_N = slope_.to_N - (length_m + kLead_m) * ahead;
  heading_rad_ = std::atan2(ahead.y(), ahead.x());
  const double side = (here - slope_.from_N).dot(right) >= 0 ? 1 : -1;
  const double radius = std::abs(context.wing.loiter_radius_m);
  path_ = CirclePath{.centre_N = slope_.from_N + side * radius * right, .radius_m = side * radius};
}

bool WingTask::meets_slope(const TaskContext& context) const {
  constexpr double kCourse_rad = 0.3;
  const Vector2d v = context.estimate.v_N.head<2>();
  const double course = std::atan2(v.y(), v.x());
  const double radius = std::abs(std::get<CirclePath>(path_).radius_m);
  const Vector2d off = context.estimate.p_N.head<2>() - slope_.from_N;
  return std::abs(base::wrap_angle(course - heading_rad_)) < kCourse_rad && off.norm() < radius / 2;
}

void WingTask::advance(const TaskContext& context) {
  const Stage before = stage_;
  const double height = height_m(context);
  time_s_ += context.dt;
  const bool quick = context.airspeed.equivalent_m_s > kClimbsFrom * context.wing.airspeed_trim_m_s;
  if (stage_ == Stage::kRun && height > kLifted_m && quick) stage_ = Stage::kClimb;
  if (stage_ == Stage::kToSlope && meets_slope(context)) {
    stage_ = Stage::kSlope;
    path_ = slope_;
  }
  if (stage_ == Stage::kSlope && height < context.wing.flare_height_m) stage_ = Stage::kFlare;
  if (stage_ != before) time_s_ = 0;
  const bool still = stage_ == Stage::kFlare && context.estimate.v_N.norm() < kStill_m_s;
  still_s_ = still ? still_s_ + context.dt : 0;
}

bool WingTask::landed() const { return still_s_ > kStill_s; }

bool WingTask::done(const TaskContext& context) const {
  return stage_ == Stage::kClimb && context.estimate.p_N.z() - z_m_ < kReached_m;
}

ControlSetpoint WingTask::update(const TaskContext& context) {
  advance(context);
  WingSetpoint out;
  out.path = path_;
  out.z_m = z_m_;
  out.airspeed_m_s = context.wing.airspeed_trim_m_s;
  if (height_m(context) < kLow_m) out.roll_limit_rad = kLowRoll_rad;
  if (stage_ == Stage::kRun) run(context, out);
  if (stage_ == Stage::kSlope) descend(context, out);
  if (stage_ == Stage::kFlare) flare(context, out);
  ControlSetpoint setpoint;
  setpoint.wing = out;
  return setpoint;
}

/// Straight ahead, on the wheels and then above them, until it is fast enough to climb.
void WingTask::run(const TaskContext& context, WingSetpoint& out) const {
  const WingParams& p = context.wing;
  out.roll_rad = 0;
  out.pitch_rad = p.runway_pitch_rad;
  out.heading_rad = heading_rad_;
  out.throttle = p.runway_throttle * std::min(time_s_ / std::max(p.runway_ramp_s, 0.01), 1.0);
  out.unloaded = true;
}

void WingTask::descend(const TaskContext& context, WingSetpoint& out) const {
  const double tangent = std::tan(context.wing.land_slope_rad);
  const double left_m = std::max(0.0, -slope_.beyond_m(context.estimate.p_N.head<2>()));
  const double on_slope = context.ground_z - left_m * tangent;
  out.airspeed_m_s = context.wing.land_airspeed_m_s;
  out.z_m = std::max(z_m_, on_slope);
  if (on_slope <= z_m_) return;
  out.climb_m_s = -tangent * context.estimate.v_N.head<2>().norm();
}

/// The sink rate falls with the height, to that of the touchdown.
void WingTask::flare(const TaskContext& context, WingSetpoint& out) const {
  const WingParams& p = context.wing;
  const double begin_m_s = std::tan(p.land_slope_rad) * p.land_airspeed_m_s;
  const double sink = begin_m_s * height_m(context) / std::max(p.flare_height_m, 0.1);
  out.by_climb_alone = true;
  out.climb_m_s = -std::max(sink, p.flare_sink_m_s);
  out.airspeed_m_s = p.land_airspeed_m_s;
  out.throttle = 0;
  if (context.estimate.v_N.norm() > kOnWheels_m_s) return;
  out.roll_rad = 0;
  out.pitch_rad = 0;
  out.unloaded = true;
}

void WingTask::shift(const Vector3d& by_N) {
  const auto move = [&by_N](LinePath& line) {
    line.from_N += by_N.head<2>();
    line.to_N += by_N.head<2>();
  };
  if (auto* line = std::get_if<LinePath>(&path_)) move(*line);
  if (auto* circle = std::get_if<CirclePath>(&path_)) circle->centre_N += by_N.head<2>();
  move(slope_);
  z_m_ += by_N.z();
}

}  // namespace cas::fcu
