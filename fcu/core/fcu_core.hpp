// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "base/time/clock.hpp"
#include "fcu/control/control_cascade.hpp"
#include "fcu/core/fcu_config.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "fcu/estimation/sensor_health.hpp"
#include "fcu/flight/commander.hpp"
#include "fcu/flight/failsafe.hpp"
#include "fcu/flight/flight_status.hpp"
#include "fcu/params/param_binding.hpp"
#include "fcu/params/params.hpp"
#include "mavlink/common/hil_gps.hpp"

namespace cas::fcu {

/// Whom the vehicle may be flown by.
struct PilotInput {
  struct Heard {
    Sticks sticks;
    std::optional<base::RunTime> at;
  };
  Heard manual_control;  ///< MANUAL_CONTROL
  Heard radio;           ///< HIL_RC_INPUTS_RAW, RC_CHANNELS_OVERRIDE

  bool seen() const { return manual_control.at || radio.at; }
  /// Of the pilot who is heard now; nothing when there is none.
  std::optional<Sticks> sticks(const FlightParams& params, base::RunTime now) const;
};

/// How rough the ride is, for VIBRATION: deviation of the specific force from its own mean.
struct VibrationMeter {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    ///< specific force in D, m/s^2
  Eigen::Vector3d square = Eigen::Vector3d::Zero();  ///< of its deviation, m^2/s^4

  void update(const Eigen::Vector3d& accel_D) {
    constexpr double kShare = 0.002;
    const Eigen::Vector3d off = accel_D - mean;
    mean += kShare * off;
    square += kShare * (off.cwiseAbs2() - square);
  }
};

/// The battery that the controller flies by: what a BATTERY_STATUS of its simulator says. Until one
/// comes it makes one up, as PX4 does in HIL: full at start, falling linearly while armed, never
/// below a floor. One that has been measured and is no longer told of is unknown.
class Battery {
 public:
  /// What a power module measures.
  struct Reading {
    double voltage_v = 0;
    int cells = 1;            ///< that the voltage is told of; 1: the pack as a whole
    double current_a = 0;     ///< negative: unknown
    double remaining = 0;     ///< 0..1 of full
    double consumed_mah = 0;  ///< negative: unknown
  };
  struct Params {
    double drain_s = 900;  ///< from full to empty while armed
    double floor = 0.5;    ///< 0..1, where it stops
    int cells = 4;
  };

  void set_params(const Params& params) { params_ = params; }
  /// @param dt  s since the last call
  void update(bool armed, double dt) {
    age_s_ += dt;
    if (!armed || measured_) return;
    if (remaining_ > params_.floor) {
      remaining_ = std::max(params_.floor, remaining_ - dt / params_.drain_s);
    }
    consumed_mah_ += kCurrent_a * dt / 3.6;
  }

  /// From now on this one counts.
  void measure(const Reading& reading) {
    measured_ = reading;
    age_s_ = 0;
  }
  /// Back to the one that is made up: another simulation may measure none.
  void forget_measured() { measured_.reset(); }

  /// Nothing while it is unknown.
  std::optional<Reading> reading(bool armed) const {
    if (measured_) return unknown() ? std::nullopt : measured_;
    const double cell_v = kEmptyCell_v + (kFullCell_v - kEmptyCell_v) * remaining_;
    return Reading{.voltage_v = params_.cells * cell_v,
                   .cells = params_.cells,
                   .current_a = armed ? kCurrent_a : 0.2,
                   .remaining = remaining_,
                   .consumed_mah = consumed_mah_};
  }
  /// 0..1 of full; nothing while it is unknown.
  std::optional<double> remaining() const {
    if (unknown()) return std::nullopt;
    return measured_ ? measured_->remaining : remaining_;
  }

 private:
  /// PX4 calls a battery unhealthy after this long without news (batteryCheck.cpp).
  static constexpr double kPatience_s = 5;
  bool unknown() const { return measured_ && age_s_ > kPatience_s; }

  static constexpr double kFullCell_v = 4.05;  // PX4's BAT1_V_CHARGED
  static constexpr double kEmptyCell_v = 3.6;  // PX4's BAT1_V_EMPTY
  static constexpr double kCurrent_a = 10;     // as PX4 reports in HIL
  Params params_;
  double remaining_ = 1;
  double consumed_mah_ = 0;
  std::optional<Reading> measured_;
  double age_s_ = 0;  // of measured_
};

/// The newest of each sensor, and how it does.
struct SensorReadings {
  SensorHealth health;
  VibrationMeter vibration;
  std::optional<mavlink::common::HilGps> gps;
  double pressure_hpa = 0;
  double temperature_degc = 0;
};

/// The place to return to.
struct Home {
  bool set = false;
  Eigen::Vector3d p_N = Eigen::Vector3d::Zero();  ///< m
  double yaw_rad = 0;                             ///< heading when home was set
  double ground_z = 0;  ///< z (down) of the ground at the take-off place, m
};

/// The parts of the flight controller. The flight loop runs them, commands command them, telemetry
/// reads them; every other unit gets those of them that it works with.
struct FcuCore {
  FcuCore(const FcuConfig& configuration, PacketSink send)
      : config(configuration),
        params(config.vehicle, sensor_figures(config.sensors).params),
        outbox({config.system_id, config.component_id}, std::move(send)),
        estimator({}, config.decimal_year),
        cascade(config.vehicle),
        commander(texts) {}

  /// Passes changed parameters on to the parts that use them.
  void apply_params();
  /// What a flight mode sees now.
  TaskContext context(base::RunTime now, double dt) const;
  ArmingInput arming_input(base::RunTime now) const;
  FailsafeInput failsafe_input(base::RunTime now) const;
  /// Forgets the estimate and begins anew, as at start.
  void restart_estimate();
  /// Sets home to the present position.
  void set_home_here();
  /// Time since the start, as MAVLink's time_boot_ms has it.
  std::uint32_t time_boot_ms(base::RunTime now) const {
    return static_cast<std::uint32_t>((now - start).count() / 1'000'000);
  }
  /// The same in microseconds.
  std::uint64_t time_boot_us(base::RunTime now) const {
    return static_cast<std::uint64_t>((now - start).count() / 1000);
  }

  FcuConfig config;
  ParamStore params;
  FlightParams flight;
  HilParams hil;
  std::uint64_t params_applied = ~0ULL;
  Outbox outbox;
  StatusTexts texts;
  Estimator estimator;
  ControlCascade cascade;
  Commander commander;
  SensorReadings readings;
  Battery battery;
  PilotInput pilot;
  Home home;
  std::optional<base::RunTime> ground_station_heard;
  base::RunTime start;
  std::optional<base::SimTime> last_control;  ///< stamp of the newest control step
  std::uint64_t position_resets_seen = 0;
  bool reboot_wanted = false;
};

}  // namespace cas::fcu
