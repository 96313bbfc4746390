// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight_controller.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "base/error.hpp"
#include "fcu/core/fcu_core.hpp"
#include "fcu/protocols/ground_protocols.hpp"
#include "fcu/protocols/hil_messages.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/sequence_tracker.hpp"

namespace cas::fcu {

using base::RunTime;
using mavlink::common::BatteryStatus;
using mavlink::common::HilGps;
using mavlink::common::HilSensor;
using mavlink::common::Odometry;
using mavlink::common::table;

struct FlightController::Impl {
  Impl(const FcuConfig& config, PacketSink send);

  // The loop of [HILS] Fig. 8.
  void on_sensor(const HilSensor& m, RunTime now);
  void on_gps(const HilGps& m, RunTime now);
  void on_battery(const BatteryStatus& m, mav::Source from);
  void begin_new_run();
  Answer control(std::uint64_t time_usec, RunTime now);
  void send(const Answer& answer);
  double time_step(std::uint64_t time_usec);
  void settle_frame();
  ControlSetpoint next_setpoint(double dt, RunTime now);
  void fly_wing(const ControlSetpoint& setpoint, double dt, RunTime now);
  void tell_of_losses();

  // Around it.
  bool is_for_us(const mav::PacketView& packet) const;
  bool is_of_our_vehicle(mav::Source from) const;
  void on_packet(const mav::PacketView& packet, RunTime now);
  void tick(RunTime now);
  void begin(RunTime now);
  void watch_sensors(RunTime now);
  void update_status();

  FcuCore core;
  SensorInput sensors;
  GroundProtocols ground;
  mav::PacketParser parser;
  mav::SequenceTracker sequence;
  std::array<std::uint64_t, Outbox::kIds> received{};
  bool started = false;
  bool sensors_lost = false;
  FlightStatus status;
  HilObserver observer;
};

// The loop.

/// One sensor message on its way to the rotors:
///
///   HIL_SENSOR --> estimate --> setpoint --> position, altitude --> attitude --> rates --> mixer
///    HIL_GPS --------^          (Xr, Yr, Zr, yaw_r)                                           |
///   ODOMETRY, without fixes                                                                   |
///                                                     HIL_CONTROLS (u1, u2, u3, u4) <---------+
void FlightController::Impl::on_sensor(const HilSensor& m, RunTime now) {
  if (m.id != 0) return sensors.on_further_sensor(m, now);
  // Estimate attitude, velocity and position from every sample ...
  const SensorInput::Sample sample = sensors.accept(m.time_usec, now);
  if (sample == SensorInput::Sample::kStale) {
    if (core.config.pace != Pace::kLockstep) tick(now);  // there time stands still with the stamps
    return;
  }
  if (sample == SensorInput::Sample::kNewRun) begin_new_run();
  if (observer) observer(HilSensor::kId, m.time_usec, false);
  status.sensor_time_usec = m.time_usec;
  sensors.on_sensor(m, now);
  // ... and control at 400 Hz, on the sensor's clock.
  const bool due = sensors.control_due(m.time_usec, core.config.control_rate_hz);
  if (core.config.pace == Pace::kLockstep) {
    // The simulator goes on with the answer: what else there is to say comes before it, so that it
    // arrives before the next sensor message in each run.
    if (!due) return;
    const Answer answer = control(m.time_usec, now);
    tick(now);
    send(answer);
  } else {
    if (due) send(control(m.time_usec, now));
    tick(now);
  }
}

void FlightController::Impl::on_gps(const HilGps& m, RunTime now) {
  if (observer && m.id == 0) observer(HilGps::kId, m.time_usec, false);
  sensors.on_gps(m, now);
}

/// Whether a packet is of another component of the vehicle's system, as with PX4 that of its own
/// battery or odometry.
bool FlightController::Impl::is_of_our_vehicle(mav::Source from) const {
  return from.system == core.config.system_id && from.component != core.config.component_id;
}

void FlightController::Impl::on_battery(const BatteryStatus& m, mav::Source from) {
  if (!is_of_our_vehicle(from)) return;
  if (const auto reading = battery_reading(m)) core.battery.measure(*reading);
}

/// A new simulation: the estimator restarts and the rotors stop.
void FlightController::Impl::begin_new_run() {
  core.texts.warn("Sensor time went back: estimator restarted");
  core.commander.disarm(true);
  core.battery.forget_measured();
  core.readings.health.forget_fixes();
  core.restart_estimate();
}

Answer FlightController::Impl::control(std::uint64_t time_usec, RunTime now) {
  const double dt = time_step(time_usec);
  settle_frame();

  // Where to: the trajectory of the flight mode, or that of a failsafe.
  const ControlSetpoint setpoint = next_setpoint(dt, now);

  // How: position and altitude --> attitude --> rates --> rotor speeds within limits.
  const MixerResult& output = core.cascade.update(setpoint, core.estimator.state(), dt);
  fly_wing(setpoint, dt, now);
  tell_of_losses();

  status.u = output.u;

  // The answer carries the stamp of the sample that it was computed from.
  const Answer answer = make_answer({.result = output,
                                     .mixer = core.cascade.mixer(),
                                     .wing = core.wing ? &*core.wing : nullptr,
                                     .scales = core.config.vehicle.scales,
                                     .time_usec = time_usec,
                                     .armed = core.commander.armed(),
                                     .by_motor = core.hil.answer_by_motor});

  // For the next step.
  core.estimator.set_at_rest(!core.commander.flying());
  core.battery.update(core.commander.armed(), dt);
  return answer;
}

void FlightController::Impl::send(const Answer& answer) {
  std::visit(
      [this](const auto& message) {
        core.outbox.send(message);
        if (observer) observer(message.kId, message.time_usec, true);
      },
      answer);
}

/// Time since the last control step on the sensor's clock, s.
double FlightController::Impl::time_step(std::uint64_t time_usec) {
  const double period = 1.0 / core.config.control_rate_hz;
  const base::SimTime time = base::from_time_usec(time_usec);
  const auto last = std::exchange(core.last_control, time);
  if (!last) return period;
  return std::clamp(base::to_seconds(time - *last), 0.2 * period, 10 * period);
}

void FlightController::Impl::settle_frame() {
  // While disarmed, every fix improves the estimate of the place that becomes home.
  if (!core.commander.armed() && core.estimator.origin_final())
    core.home.set_here(core.estimator.state());
  // When the estimate jumps, the references jump with it: the vehicle stays where it is.
  if (core.estimator.position_resets() == core.position_resets_seen) return;
  core.position_resets_seen = core.estimator.position_resets();
  core.commander.on_position_reset(core.estimator.last_position_reset_N());
}

ControlSetpoint FlightController::Impl::next_setpoint(double dt, RunTime now) {
  FailsafeInput failsafe = core.failsafe_input(now);
  failsafe.offboard_alive = core.commander.offboard().alive(now, core.flight.offboard_timeout_s);
  const double hover_n = std::max(core.cascade.hover_thrust_n(), 1e-3);
  const ThrustRatio thrust{core.cascade.output().u[0] / hover_n,
                           core.cascade.attitude_setpoint().thrust_n / hover_n};
  ControlSetpoint setpoint = core.commander.update(core.context(now, dt), failsafe, thrust);
  setpoint.may_touch = core.commander.landed() != LandedState::kInAir;
  return setpoint;
}

/// Surfaces and forward rotors, of a vehicle with a wing.
void FlightController::Impl::fly_wing(const ControlSetpoint& setpoint, double dt, RunTime now) {
  if (!core.wing) return;
  if (!setpoint.wing) return core.wing->stop();
  const EstimatorState& estimate = core.estimator.state();
  const Airspeed airspeed =
      core.readings.airspeed.read(estimate.v_N.norm(), core.wing_params.use_airspeed, now);
  core.wing->update(*setpoint.wing, estimate, airspeed, dt);
}

void FlightController::Impl::tell_of_losses() {
  const std::optional<RotorLoss> loss = core.cascade.take_loss();
  if (!loss) return;
  const std::string rotor = "Rotor " + std::to_string(loss->rotor + 1);
  core.texts.critical(loss->left_out ? rotor + " lost: flying on without it"
                                     : rotor + " lost: the others cannot do without it");
  if (!loss->holds_heading) core.texts.critical("Heading given up: yaw to one side only");
}

// Around the loop.

namespace {

/// Whether the answer is HIL_ACTUATOR_CONTROLS.
bool answers_by_motor(const FcuConfig& config) {
  if (config.actuators == ActuatorMessage::kAuto) return !Mixer::is_eq3(config.vehicle);
  return config.actuators == ActuatorMessage::kHilActuatorControls;
}

GroundProtocols::View ground_view(FcuCore& core) {
  return {.core = core,
          .target = {.commander = core.commander,
                     .estimator = core.estimator,
                     .home = core.home,
                     .params = core.params,
                     .flight = core.flight,
                     .reboot_wanted = core.reboot_wanted,
                     .context = [&core](RunTime now) { return core.context(now, 0); },
                     .arming_input = [&core](RunTime now) { return core.arming_input(now); },
                     .reset_control = [&core] { core.cascade.reset(); },
                     .restart_estimate = [&core] { core.restart_estimate(); }},
          .outbox = core.outbox,
          .texts = core.texts,
          .pilot = core.pilot,
          .ground_station_heard = core.ground_station_heard,
          .apply_params = [&core] { core.apply_params(); }};
}

}  // namespace

FlightController::Impl::Impl(const FcuConfig& config, PacketSink send)
    : core(config, std::move(send)),
      sensors({core.estimator, core.cascade, core.readings, core.hil, core.start, core.texts}),
      ground(ground_view(core)),
      parser(table()) {
  for (const auto& [name, value] : config.params) {
    const ParamSetResult result = core.params.set(name, value);
    if (result == ParamSetResult::kUnknown) throw base::ConfigError("no parameter " + name);
    if (result != ParamSetResult::kOk) {
      throw base::ConfigError("parameter " + name + " is out of range");
    }
  }
  core.params.set("MAV_SYS_ID", config.system_id);
  core.params.set("MAV_COMP_ID", config.component_id);
  core.params.set("CAS_HIL_ACT", answers_by_motor(config) ? 1 : 0);
  core.params.set("CAS_STAMP_MODE", config.stamp == StampMode::kArrival ? 1 : 0);
  core.params.mark_start();
  core.apply_params();
  if (config.home_hint) core.estimator.set_origin(*config.home_hint);
}

void FlightController::Impl::begin(RunTime now) {
  if (!std::exchange(started, true)) core.start = now;
}

bool FlightController::Impl::is_for_us(const mav::PacketView& packet) const {
  const mav::MessageInfo* info = table().find(packet.message_id);
  if (info == nullptr) return false;
  const mav::Source target = mav::target_of(packet, *info);
  const bool system = target.system == 0 || target.system == core.config.system_id;
  const bool component = target.component == 0 || target.component == core.config.component_id;
  return system && component;
}

void FlightController::Impl::on_packet(const mav::PacketView& packet, RunTime now) {
  sequence.update(packet.source, packet.sequence);
  if (packet.message_id < Outbox::kIds) ++received[packet.message_id];
  if (!is_for_us(packet)) return;
  if (packet.message_id == HilSensor::kId) {
    if (const auto m = mav::decode<HilSensor>(packet)) on_sensor(*m, now);
  } else if (packet.message_id == HilGps::kId) {
    if (const auto m = mav::decode<HilGps>(packet)) on_gps(*m, now);
  } else if (packet.message_id == Odometry::kId) {
    const auto m = mav::decode<Odometry>(packet);
    if (m && is_of_our_vehicle(packet.source)) sensors.on_odometry(*m, now);
  } else if (packet.message_id == BatteryStatus::kId) {
    if (const auto m = mav::decode<BatteryStatus>(packet)) on_battery(*m, packet.source);
  } else {
    ground.on_packet(packet, now);
  }
}

void FlightController::Impl::tick(RunTime now) {
  watch_sensors(now);
  ground.update(now);
}

void FlightController::Impl::watch_sensors(RunTime now) {
  const SensorHealth& health = core.readings.health;
  const bool lost = health.seen(SensorHealth::kImu) && !health.alive(SensorHealth::kImu, now);
  if (lost && !sensors_lost) {
    const bool both = health.gyro_stuck() == health.accel_stuck();
    core.commander.on_sensors_lost(both                  ? "Gyro and accelerometer lost"
                                   : health.gyro_stuck() ? "Gyro stuck"
                                                         : "Accelerometer stuck");
  }
  sensors_lost = lost;
}

void FlightController::Impl::update_status() {
  FlightStatus& s = status;
  const EstimatorState& e = core.estimator.state();
  s.armed = core.commander.armed();
  s.mode = core.commander.mode();
  s.landed = core.commander.landed();
  s.on_wing = core.commander.on_wing();
  if (core.commander.airframe() == AirframeKind::kVtol) s.vtol = name(core.commander.vtol_state());
  s.estimator_ready = core.estimator.origin_final() && core.estimator.position_valid() &&
                      core.estimator.heading_valid();
  s.q_ND = e.q_ND;
  s.p_N = e.p_N;
  s.v_N = e.v_N;
  s.w_D = e.w_D;
  s.position_stddev_m = core.estimator.covariance().deviation(ErrorCovariance::kPosition);
  const ControlSetpoint& setpoint = core.commander.setpoint();
  s.reference_N = setpoint.trajectory ? setpoint.trajectory->p_N : unset3();
  if (setpoint.trajectory && std::isfinite(setpoint.trajectory->yaw_rad)) {
    s.yaw_reference_rad = setpoint.trajectory->yaw_rad;
  }
}

// Interface.

FlightController::FlightController(const FcuConfig& config, PacketSink send)
    : impl_(std::make_unique<Impl>(config, std::move(send))) {}
FlightController::~FlightController() = default;
FlightController::FlightController(FlightController&&) noexcept = default;
FlightController& FlightController::operator=(FlightController&&) noexcept = default;

void FlightController::on_bytes(std::span<const std::uint8_t> bytes, RunTime now) {
  impl_->parser.feed(bytes, [&](const mav::PacketView& packet) { on_packet(packet, now); });
}

void FlightController::on_bytes(std::span<const std::uint8_t> bytes, const PacketClock& now_of) {
  impl_->parser.feed(bytes,
                     [&](const mav::PacketView& packet) { on_packet(packet, now_of(packet)); });
}

void FlightController::on_packet(const mav::PacketView& packet, RunTime now) {
  impl_->begin(now);
  impl_->on_packet(packet, now);
  impl_->update_status();
}

void FlightController::tick(RunTime now) {
  impl_->begin(now);
  impl_->tick(now);
  impl_->update_status();
}

void FlightController::serve(mav::services::FtpStore& files) { impl_->ground.files().add(files); }

void FlightController::set_hil_observer(HilObserver observer) {
  impl_->observer = std::move(observer);
}

const FlightStatus& FlightController::status() const { return impl_->status; }

const Estimator& FlightController::estimator() const { return impl_->core.estimator; }

const ParamStore& FlightController::params() const { return impl_->core.params; }

FlightControllerStats FlightController::stats() const {
  FlightControllerStats stats;
  const auto named = [](const auto& counts, auto& out) {
    for (std::size_t id = 0; id < counts.size(); ++id) {
      if (counts[id] == 0) continue;
      const mav::MessageInfo* info = table().find(static_cast<std::uint32_t>(id));
      out[info != nullptr ? std::string(info->name) : std::to_string(id)] = counts[id];
    }
  };
  named(impl_->received, stats.received);
  named(impl_->core.outbox.counts(), stats.sent);
  stats.crc_errors = impl_->parser.stats().crc_errors;
  stats.sequence_gaps = impl_->sequence.lost();
  stats.stale_sensors = impl_->sensors.stale();
  stats.missed_controls = impl_->sensors.missed_controls();
  stats.sensor_age = impl_->sensors.age();
  return stats;
}

bool FlightController::set_param(std::string_view name, double value) {
  const bool good = impl_->core.params.set(name, value) == ParamSetResult::kOk;
  impl_->core.apply_params();
  return good;
}

std::string FlightController::params_text() const { return impl_->core.params.changed_text(); }

bool FlightController::take_reboot_request() {
  return std::exchange(impl_->core.reboot_wanted, false);
}

std::uint64_t FlightController::params_revision() const { return impl_->core.params.revision(); }

}  // namespace cas::fcu
