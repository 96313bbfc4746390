// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fcu/support/closed_loop.hpp"

#include <cmath>

#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/magnetic_field.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/table.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu::test {

using Eigen::Vector3d;
using namespace mavlink::common;  // NOLINT

namespace {

constexpr double kYear = 2026.5;
constexpr std::int64_t kStep_us = 1000;

base::Vehicle load_vehicle(const std::string& name) {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/" + name + ".yaml");
}

}  // namespace

SensorNoise table1_noise() { return {}; }

SensorNoise rtk_noise() {
  SensorNoise noise;
  // 7e-5 rad/s and 9.8e-4 m/s^2 per root Hz, sampled at 500 Hz.
  noise.gyro_rad_s = Vector3d::Constant(7e-5 * std::sqrt(500.0));
  noise.accel_m_s2 = Vector3d::Constant(9.8e-4 * std::sqrt(500.0));
  noise.gps_m = 0.01;
  noise.gps_velocity_m_s = 0.03;
  noise.mag_gauss = 0.002;
  return noise;
}

void assume(FcuConfig& config, const SensorNoise& noise) {
  const char* axes[] = {"X", "Y", "Z"};
  for (int i = 0; i < 3; ++i) {
    config.params.emplace_back(std::string("CAS_GYR_NOISE_") + axes[i], noise.gyro_rad_s[i]);
    config.params.emplace_back(std::string("CAS_ACC_NOISE_") + axes[i], noise.accel_m_s2[i]);
  }
  config.params.emplace_back("EKF2_GPS_P_NOISE", noise.gps_m);
  config.params.emplace_back("CAS_GPS_Z_NOISE", noise.gps_m);
  config.params.emplace_back("EKF2_GPS_V_NOISE", noise.gps_velocity_m_s);
  config.params.emplace_back("EKF2_MAG_NOISE", noise.mag_gauss);
}

ClosedLoop::ClosedLoop(const LoopOptions& options)
    : options_(options),
      vehicle_(options.airframe ? *options.airframe : load_vehicle(options.vehicle)),
      projection_(home_),
      field_N_(base::magnetic_field_N(home_, kYear)),
      multirotor_(vehicle_, options.mass_scale, options.yaw_rad),
      imu_random_(base::derive_seed(options.seed, "imu")),
      gps_random_(base::derive_seed(options.seed, "gps")),
      mag_random_(base::derive_seed(options.seed, "mag")),
      baro_random_(base::derive_seed(options.seed, "baro")),
      loss_random_(base::derive_seed(options.seed, "loss")),
      answers_(mavlink::common::table()) {
  FcuConfig& config = config_;
  config.vehicle = vehicle_;
  config.sensors = vehicle_.sensors;
  config.decimal_year = kYear;
  config.home_hint = home_;
  assume(config, options.noise);
  if (options.configure) options.configure(config);
  if (options.line.preset != "ideal" || options.line.extra_delay.count() > 0 ||
      options.line.packet_loss > 0) {
    up_ = std::make_unique<LineModel>(options.line, base::derive_seed(options.seed, "up"));
    down_ = std::make_unique<LineModel>(options.line, base::derive_seed(options.seed, "down"));
  }
  fcu_ = std::make_unique<FlightController>(
      config, [this](std::span<const std::uint8_t> packet) { on_fcu_bytes(packet); });
}

template <class Message>
void ClosedLoop::to_fcu(const Message& message) {
  const auto bytes = sim_encoder_(message);
  if (options_.tap) options_.tap(bytes, now());
  if (up_) {
    up_->write(bytes, now());
  } else {
    fcu_->on_bytes(bytes, now());
  }
}

void ClosedLoop::on_fcu_bytes(std::span<const std::uint8_t> bytes) {
  const auto packet = mav::view_packet(bytes);
  if (packet.message_id == HilControls::kId || packet.message_id == HilActuatorControls::kId) {
    if (down_) {
      down_->write(bytes, now());
    } else {
      on_answer(packet);
    }
    return;
  }
  if (down_) down_->write(bytes, now());
  if (keep_packets) from_fcu_.emplace_back(bytes.begin(), bytes.end());
}

void ClosedLoop::on_answer(const mav::PacketView& packet) {
  if (const auto m = mav::decode<HilActuatorControls>(packet)) {
    ++controls_received;
    std::array<double, base::kMaxOutputs> outputs{};
    std::copy(m->controls.begin(), m->controls.end(), outputs.begin());
    multirotor_.command(outputs, (static_cast<unsigned>(m->mode) & 128U) != 0);
    return;
  }
  const auto m = mav::decode<HilControls>(packet);
  if (!m) return;
  ++controls_received;
  const auto& s = vehicle_.scales;
  const Eigen::Vector4d u(s.u1_max_n * static_cast<double>(m->throttle),
                          s.u2_max_nm * static_cast<double>(m->roll_ailerons),
                          s.u3_max_nm * static_cast<double>(m->pitch_elevator),
                          s.u4_max_nm * static_cast<double>(m->yaw_rudder));
  multirotor_.command(u, (static_cast<unsigned>(m->mode) & 128U) != 0);
}

void ClosedLoop::move_lines() {
  std::array<std::uint8_t, 512> buffer;
  while (const std::size_t n = up_->read(buffer, now())) {
    fcu_->on_bytes(std::span(buffer).first(n), now());
  }
  while (const std::size_t n = down_->read(buffer, now())) {
    answers_.feed(std::span(buffer).first(n),
                  [this](const mav::PacketView& packet) { on_answer(packet); });
  }
}

void ClosedLoop::sense() {
  const auto& truth = multirotor_.state();
  const auto& noise = options_.noise;
  const auto noisy = [](const Vector3d& value, const Vector3d& sigma, base::NormalRandom& random) {
    return Vector3d(value.x() + sigma.x() * random(), value.y() + sigma.y() * random(),
                    value.z() + sigma.z() * random());
  };
  const Eigen::Quaterniond q_DN = truth.q_ND.inverse();
  if (steps_ % 2 == 0) {
    HilSensor m{.time_usec = base::to_time_usec(time_)};
    using F = HilSensorUpdatedFlags;
    if (imu_on) {
      // The mean over the sample's period, as an integrating sensor gives it.
      Vector3d f =
          noisy(0.5 * (force_before_D_ + multirotor_.specific_force_D()) + noise.accel_bias_m_s2,
                noise.accel_m_s2, imu_random_);
      Vector3d w = noisy(truth.w_D + noise.gyro_bias_rad_s, noise.gyro_rad_s, imu_random_);
      if (gyro_stuck) w = last_rate_D_;
      if (accel_stuck) f = last_measured_force_D_;
      last_rate_D_ = w;
      last_measured_force_D_ = f;
      m.xacc = static_cast<float>(f.x());
      m.yacc = static_cast<float>(f.y());
      m.zacc = static_cast<float>(f.z());
      m.xgyro = static_cast<float>(w.x());
      m.ygyro = static_cast<float>(w.y());
      m.zgyro = static_cast<float>(w.z());
      m.fields_updated = F::kXacc | F::kYacc | F::kZacc | F::kXgyro | F::kYgyro | F::kZgyro;
    }
    if (mag_on && steps_ % 10 == 0) {
      const Vector3d b = noisy(q_DN * (field_N_ + noise.field_error_gauss) + noise.mag_bias_gauss,
                               Vector3d::Constant(noise.mag_gauss), mag_random_);
      m.xmag = static_cast<float>(b.x());
      m.ymag = static_cast<float>(b.y());
      m.zmag = static_cast<float>(b.z());
      m.fields_updated |= F::kXmag | F::kYmag | F::kZmag;
    }
    if (baro_on && steps_ % 20 == 0) {
      const double pressure = base::isa::pressure_pa(home_.alt_m - truth.p_N.z()) +
                              noise.baro_offset_pa + noise.baro_pa * baro_random_();
      m.abs_pressure = static_cast<float>(pressure / 100);
      m.fields_updated |= F::kAbsPressure | F::kPressureAlt | F::kTemperature;
    }
    const bool lost = options_.sensor_loss > 0 && loss_random_.uniform() < options_.sensor_loss;
    if (!lost) to_fcu(m);
  }
  if (gps_on && steps_ % 200 == 0) {
    const Vector3d p =
        noisy(truth.p_N + noise.gps_offset_m, Vector3d::Constant(noise.gps_m), gps_random_);
    const Vector3d v = noisy(truth.v_N + noise.gps_velocity_offset_m_s,
                             Vector3d::Constant(noise.gps_velocity_m_s), gps_random_);
    const base::Geodetic place = projection_.to_geodetic(p);
    HilGps g{.time_usec = base::to_time_usec(time_),
             .fix_type = 3,
             .lat = static_cast<std::int32_t>(std::llround(place.lat_deg * 1e7)),
             .lon = static_cast<std::int32_t>(std::llround(place.lon_deg * 1e7)),
             .alt = static_cast<std::int32_t>(std::llround(place.alt_m * 1e3)),
             .vn = static_cast<std::int16_t>(std::lround(v.x() * 100)),
             .ve = static_cast<std::int16_t>(std::lround(v.y() * 100)),
             .vd = static_cast<std::int16_t>(std::lround(v.z() * 100))};
    g.eph = g.epv = 100;
    g.satellites_visible = 12;
    if (gps_frozen) {
      last_fix_.time_usec = g.time_usec;
      g = last_fix_;
    }
    if (gps_time_stands) g.time_usec = last_fix_.time_usec;
    last_fix_ = g;
    if (noise.gps_delay_s <= 0) {
      to_fcu(g);
    } else {
      const auto bytes = sim_encoder_(g);
      late_fixes_.push_back(
          {time_ + base::from_seconds(noise.gps_delay_s), {bytes.begin(), bytes.end()}});
    }
  }
  while (!late_fixes_.empty() && late_fixes_.front().due <= time_) {
    fcu_->on_bytes(late_fixes_.front().packet, now());
    late_fixes_.erase(late_fixes_.begin());
  }
}

void ClosedLoop::run(double seconds, const std::function<void()>& each) {
  const auto steps = static_cast<std::int64_t>(std::llround(seconds * 1e6 / kStep_us));
  const double dt = kStep_us * 1e-6;
  for (std::int64_t i = 0; i < steps; ++i) {
    force_before_D_ = multirotor_.specific_force_D();
    multirotor_.step(dt);
    ++steps_;
    time_ += std::chrono::microseconds(kStep_us);
    sense();
    if (up_) move_lines();
    if (steps_ % 10 == 0) fcu_->tick(now());
    if (each) each();
  }
}

bool ClosedLoop::run_until(const std::function<bool()>& condition, double at_most_s) {
  const double end = time_s() + at_most_s;
  while (!condition()) {
    if (time_s() >= end) return false;
    run(0.01);
  }
  return true;
}

MavResult ClosedLoop::command(MavCmd id, std::array<float, 7> params) {
  CommandLong m{.target_system = 1,
                .target_component = 1,
                .command = id,
                .param1 = params[0],
                .param2 = params[1],
                .param3 = params[2],
                .param4 = params[3],
                .param5 = params[4],
                .param6 = params[5],
                .param7 = params[6]};
  const std::size_t before = received<CommandAck>().size();
  send(m);
  const auto acks = received<CommandAck>();
  return acks.size() > before ? acks.back().result : MavResult::kInProgress;
}

bool ClosedLoop::arm() { return command(MavCmd::kComponentArmDisarm, {1}) == MavResult::kAccepted; }

bool ClosedLoop::take_off(double height_m) {
  return command(MavCmd::kNavTakeoff,
                 {0, 0, 0, NAN, NAN, NAN, static_cast<float>(home_.alt_m + height_m)}) ==
         MavResult::kAccepted;
}

bool ClosedLoop::fly_to_hover(double height_m) {
  if (!run_until([this] { return fcu_->status().estimator_ready; }, 20)) return false;
  if (!arm() || !take_off(height_m)) return false;
  return run_until([this] { return fcu_->status().landed == LandedState::kInAir; }, 20);
}

void ClosedLoop::go_to(double north_m, double east_m, double up_m, float yaw_rad) {
  const base::Geodetic place = projection_.to_geodetic({north_m, east_m, -up_m});
  CommandInt m{.target_system = 1,
               .target_component = 1,
               .frame = MavFrame::kGlobalInt,
               .command = MavCmd::kDoReposition,
               .param1 = -1,
               .param2 = 1,
               .param4 = yaw_rad,
               .x = static_cast<std::int32_t>(std::llround(place.lat_deg * 1e7)),
               .y = static_cast<std::int32_t>(std::llround(place.lon_deg * 1e7)),
               .z = static_cast<float>(place.alt_m)};
  send(m);
}

double ClosedLoop::yaw() const { return base::euler_rpy(multirotor_.state().q_ND).z(); }

std::vector<std::string> ClosedLoop::texts() const {
  std::vector<std::string> out;
  for (const auto& m : received<Statustext>()) out.emplace_back(mav::text(m.text));
  return out;
}

bool ClosedLoop::said(const std::string& part) const {
  for (const std::string& text : texts()) {
    if (text.find(part) != std::string::npos) return true;
  }
  return false;
}

}  // namespace cas::fcu::test
