// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/time/clock.hpp"
#include "fcu/control/control_cascade.hpp"
#include "fcu/control/wing_controller.hpp"
#include "fcu/core/airspeed_meter.hpp"
#include "fcu/core/battery.hpp"
#include "fcu/core/controller_description.hpp"
#include "fcu/core/fcu_config.hpp"
#include "fcu/core/home.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/core/pilot_input.hpp"
#include "fcu/estimation/estimator.hpp"
#include "fcu/estimation/sensor_figures.hpp"
#include "fcu/estimation/sensor_health.hpp"
#include "fcu/flight/commander.hpp"
#include "fcu/flight/failsafe.hpp"
#include "fcu/params/params.hpp"
#include "fcu/params/settings.hpp"
#include "mavlink/common/hil_gps.hpp"

namespace cas::fcu {

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

/// The newest of each sensor, and how it does.
struct SensorReadings {
  SensorHealth health;
  VibrationMeter vibration;
  AirspeedMeter airspeed;
  std::optional<mavlink::common::HilGps> gps;
  double pressure_hpa = 0;
  double temperature_degc = 0;
};

/// The parts of the flight controller. The flight loop runs them, commands command them, telemetry
/// reads them; every other unit gets those of them that it works with.
struct FcuCore {
  FcuCore(const FcuConfig& configuration, PacketSink send)
      : config(configuration),
        params(config.vehicle, sensor_figures(config.sensors).params, design_delay_s(config)),
        outbox({config.system_id, config.component_id}, std::move(send)),
        estimator({}, config.decimal_year),
        cascade(lifting_part(config.vehicle)),
        commander(texts, config.vehicle) {
    if (commander.airframe() != AirframeKind::kMulticopter) wing.emplace(config.vehicle);
  }

  /// Passes changed parameters on to the parts that use them.
  void apply_params();
  /// Input of a flight mode at this step.
  TaskContext context(base::RunTime now, double dt) const;
  ArmingInput arming_input(base::RunTime now) const;
  FailsafeInput failsafe_input(base::RunTime now) const;
  /// Restarts the estimator, as at start.
  void restart_estimate();
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
  WingParams wing_params;
  HilParams hil;
  std::uint64_t params_applied = ~0ULL;
  Outbox outbox;
  StatusTexts texts;
  Estimator estimator;
  ControlCascade cascade;                ///< of the rotors that lift
  std::optional<WingController> wing{};  ///< of a plane or VTOL
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
