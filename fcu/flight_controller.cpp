// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight_controller.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

#include "base/error.hpp"
#include "base/frames.hpp"
#include "fcu/command_handler.hpp"
#include "fcu/fcu_core.hpp"
#include "fcu/mission_protocol.hpp"
#include "fcu/param_protocol.hpp"
#include "fcu/sensor_input.hpp"
#include "fcu/setpoint_messages.hpp"
#include "fcu/telemetry.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/mission_request.hpp"
#include "mavlink/common/mission_request_int.hpp"
#include "mavlink/common/ping.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink/common/timesync.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/sequence_tracker.hpp"

namespace cas::fcu {

using base::RunTime;
using namespace mavlink::common;  // NOLINT: a dispatcher over its messages

namespace {

/// Time between two values of a parameter list: what the line has left beside the HIL stream.
base::Duration param_interval(const LineConfig& line) {
  constexpr double kBytesPerValue = 40;
  constexpr double kHilAndStreams_b_s = 28'000;
  if (line.baud <= 0) return std::chrono::milliseconds(1);
  const double left = std::max(line.baud / 10 - kHilAndStreams_b_s, 2'000.0);
  return base::from_seconds(kBytesPerValue / (0.5 * left));
}

}  // namespace

struct FlightController::Impl {
  Impl(const FcuConfig& config, Sink send)
      : core(config, std::move(send)),
        params(param_interval(config.line)),
        commands(telemetry),
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
    core.params.set("CAS_HIL_ACT",
                    config.actuators == ActuatorMessage::kHilActuatorControls ? 1 : 0);
    core.params.set("CAS_STAMP_MODE", config.stamp == StampMode::kArrival ? 1 : 0);
    core.apply_params();
    if (config.home_hint) core.estimator.set_origin(*config.home_hint);
  }

  void begin(RunTime now) {
    if (core.started) return;
    core.started = true;
    core.start = now;
  }

  bool is_for_us(const mav::PacketView& packet) const {
    const mav::MessageInfo* info = table().find(packet.message_id);
    if (info == nullptr) return false;
    const mav::Source target = mav::target_of(packet, *info);
    const bool system = target.system == 0 || target.system == core.config.system_id;
    const bool component = target.component == 0 || target.component == core.config.component_id;
    return system && component;
  }

  template <class Message, class Handler>
  void handle(const mav::PacketView& packet, Handler&& handler) {
    if (const auto message = mav::decode<Message>(packet)) handler(*message);
  }

  void dispatch(const mav::PacketView& packet, RunTime now);
  void dispatch_mission(const mav::PacketView& packet, RunTime now);
  void on_heartbeat(const Heartbeat& m, RunTime now);
  void on_timesync(const Timesync& m, const mav::PacketView& packet, RunTime now);
  void on_ping(const Ping& m, const mav::PacketView& packet);
  void tick(RunTime now);
  void watch_sensors(RunTime now);
  void say();
  void update_status();

  FcuCore core;
  Telemetry telemetry;
  ParamProtocol params;
  CommandHandler commands;
  MissionProtocol missions;
  SensorInput sensors;
  mav::PacketParser parser;
  mav::SequenceTracker sequence;
  std::array<std::uint64_t, Outbox::kIds> received{};
  bool sensors_lost = false;
  bool was_armed = false;
  FlightMode was_mode = FlightMode::kHold;
  LandedState was_landed = LandedState::kOnGround;
};

void FlightController::Impl::on_heartbeat(const Heartbeat& m, RunTime now) {
  if (m.type != MavType::kGcs) return;
  core.ground_station_seen = true;
  core.ground_station_last = now;
}

void FlightController::Impl::on_timesync(const Timesync& m, const mav::PacketView& packet,
                                         RunTime now) {
  if (m.tc1 != 0) return;  // an answer; we ask nobody
  Timesync answer;
  answer.tc1 = (now - core.start).count();
  answer.ts1 = m.ts1;
  answer.target_system = packet.source.system;
  answer.target_component = packet.source.component;
  core.outbox.reply(answer, packet.version);
}

void FlightController::Impl::on_ping(const Ping& m, const mav::PacketView& packet) {
  if (m.target_system != 0 || m.target_component != 0) return;
  core.outbox.reply(Ping{m.time_usec, m.seq, packet.source.system, packet.source.component},
                    packet.version);
}

void FlightController::Impl::dispatch(const mav::PacketView& packet, RunTime now) {
  const int version = packet.version;
  const mav::Source from = packet.source;
  switch (packet.message_id) {
    case HilSensor::kId:
      return handle<HilSensor>(packet, [&](const auto& m) {
        sensors.on_sensor(m, core, now);
        tick(now);
      });
    case HilGps::kId:
      return handle<HilGps>(packet, [&](const auto& m) { sensors.on_gps(m, core, now); });
    case Heartbeat::kId:
      return handle<Heartbeat>(packet, [&](const auto& m) { on_heartbeat(m, now); });
    case CommandLong::kId:
      return handle<CommandLong>(
          packet, [&](const auto& m) { commands.on_long(m, from, version, core, now); });
    case CommandInt::kId:
      return handle<CommandInt>(
          packet, [&](const auto& m) { commands.on_int(m, from, version, core, now); });
    case SetMode::kId:
      return handle<SetMode>(
          packet, [&](const auto& m) { commands.on_set_mode(m, from, version, core, now); });
    case ParamRequestList::kId:
      return params.on_list(version);
    case ParamRequestRead::kId:
      return handle<ParamRequestRead>(packet,
                                      [&](const auto& m) { params.on_read(m, core, version); });
    case ParamSet::kId:
      return handle<ParamSet>(packet, [&](const auto& m) {
        params.on_set(m, core, version);
        core.apply_params();
      });
    case SetPositionTargetLocalNed::kId:
      return handle<SetPositionTargetLocalNed>(
          packet, [&](const auto& m) { on_position_target(m, core, now); });
    case SetPositionTargetGlobalInt::kId:
      return handle<SetPositionTargetGlobalInt>(
          packet, [&](const auto& m) { on_global_target(m, core, now); });
    case SetAttitudeTarget::kId:
      return handle<SetAttitudeTarget>(packet,
                                       [&](const auto& m) { on_attitude_target(m, core, now); });
    case ManualControl::kId:
      return handle<ManualControl>(packet, [&](const auto& m) { on_manual_control(m, core, now); });
    case HilRcInputsRaw::kId:
      return handle<HilRcInputsRaw>(packet, [&](const auto& m) { on_rc_inputs(m, core, now); });
    case RcChannelsOverride::kId:
      return handle<RcChannelsOverride>(packet,
                                        [&](const auto& m) { on_rc_override(m, core, now); });
    case Timesync::kId:
      return handle<Timesync>(packet, [&](const auto& m) { on_timesync(m, packet, now); });
    case Ping::kId:
      return handle<Ping>(packet, [&](const auto& m) { on_ping(m, packet); });
    default:
      dispatch_mission(packet, now);
  }
}

void FlightController::Impl::dispatch_mission(const mav::PacketView& packet, RunTime now) {
  const int version = packet.version;
  const mav::Source from = packet.source;
  switch (packet.message_id) {
    case MissionCount::kId:
      return handle<MissionCount>(
          packet, [&](const auto& m) { missions.on_count(m, from, version, core, now); });
    case MissionItemInt::kId:
      return handle<MissionItemInt>(
          packet, [&](const auto& m) { missions.on_item(m, from, version, core, now); });
    case MissionRequestList::kId:
      return handle<MissionRequestList>(
          packet, [&](const auto& m) { missions.on_request_list(m, from, version, core); });
    case MissionRequestInt::kId:
      return handle<MissionRequestInt>(packet, [&](const auto& m) {
        missions.on_request(m.seq, m.mission_type, from, version, core);
      });
    case MissionRequest::kId:
      return handle<MissionRequest>(packet, [&](const auto& m) {
        missions.on_request(m.seq, m.mission_type, from, version, core);
      });
    case MissionClearAll::kId:
      return handle<MissionClearAll>(
          packet, [&](const auto& m) { missions.on_clear(m, from, version, core); });
    case MissionSetCurrent::kId:
      return handle<MissionSetCurrent>(
          packet, [&](const auto& m) { missions.on_set_current(m, core, now); });
    default:
      return;
  }
}

void FlightController::Impl::watch_sensors(RunTime now) {
  const bool lost =
      core.sensors.seen(SensorMonitor::kImu) && !core.sensors.alive(SensorMonitor::kImu, now);
  if (lost && !sensors_lost) core.commander.on_sensors_lost();
  sensors_lost = lost;
}

void FlightController::Impl::say() {
  for (const StatusTexts::Line& line : core.texts.take()) {
    Statustext m;
    m.severity = line.severity;
    mav::set_text(m.text, line.text);
    core.outbox.send(m);
  }
}

void FlightController::Impl::update_status() {
  FlightStatus& s = core.status;
  const EstimatorState& e = core.estimator.state();
  s.armed = core.commander.armed();
  s.mode = core.commander.mode();
  s.landed = core.commander.landed();
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

void FlightController::Impl::tick(RunTime now) {
  watch_sensors(now);
  const bool changed = core.commander.armed() != was_armed || core.commander.mode() != was_mode ||
                       core.commander.landed() != was_landed;
  if (changed) {
    was_armed = core.commander.armed();
    was_mode = core.commander.mode();
    was_landed = core.commander.landed();
    telemetry.hurry();
  }
  core.apply_params();
  if (!core.texts.empty()) say();
  telemetry.update(core, now);
  params.update(core, now);
  missions.update(core, now);
}

// ------------------------------------------------------------------------------ interface

FlightController::FlightController(const FcuConfig& config, Sink send)
    : impl_(std::make_unique<Impl>(config, std::move(send))) {}
FlightController::~FlightController() = default;
FlightController::FlightController(FlightController&&) noexcept = default;
FlightController& FlightController::operator=(FlightController&&) noexcept = default;

void FlightController::on_bytes(std::span<const std::uint8_t> bytes, RunTime now) {
  impl_->parser.feed(bytes, [&](const mav::PacketView& packet) { on_packet(packet, now); });
}

void FlightController::on_packet(const mav::PacketView& packet, RunTime now) {
  impl_->begin(now);
  impl_->sequence.update(packet.source, packet.sequence);
  if (packet.message_id < Outbox::kIds) ++impl_->received[packet.message_id];
  if (!impl_->is_for_us(packet)) return;
  impl_->dispatch(packet, now);
  impl_->update_status();
}

void FlightController::tick(RunTime now) {
  impl_->begin(now);
  impl_->tick(now);
  impl_->update_status();
}

void FlightController::set_hil_observer(HilObserver observer) {
  impl_->core.observer = std::move(observer);
}

const FlightStatus& FlightController::status() const { return impl_->core.status; }

const Estimator& FlightController::estimator() const { return impl_->core.estimator; }

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
  stats.lost_by_sequence = impl_->sequence.lost();
  stats.stale_sensors = impl_->sensors.stale();
  stats.missed_controls = impl_->sensors.missed_controls();
  stats.sensor_age = impl_->sensors.age();
  return stats;
}

bool FlightController::get_param(std::string_view name, double& value) const {
  const auto index = impl_->core.params.index_of(name);
  if (index) value = impl_->core.params.at(*index).value;
  return index.has_value();
}

bool FlightController::set_param(std::string_view name, double value) {
  const bool good = impl_->core.params.set(name, value) == ParamSetResult::kOk;
  impl_->core.apply_params();
  return good;
}

std::string FlightController::params_text() const {
  std::ostringstream out;
  out.precision(9);
  for (std::size_t i = 0; i < impl_->core.params.size(); ++i) {
    const Param& param = impl_->core.params.at(i);
    if (param.value != param.initial) out << param.name << ' ' << param.value << '\n';
  }
  return out.str();
}

bool FlightController::take_reboot_request() {
  return std::exchange(impl_->core.reboot_wanted, false);
}

std::uint64_t FlightController::params_revision() const { return impl_->core.params.revision(); }

}  // namespace cas::fcu
