// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/telemetry_ulog.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <string_view>

#include "base/earth/deg_e7.hpp"
#include "base/earth/frames.hpp"
#include "hils/ulog/ulog_topics.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::hils {

using namespace mavlink::common;  // NOLINT: the file is about its messages
using sim::UlogRecord;
using Topic = UlogTopicId;

namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

template <class Flags>
bool has(Flags set, Flags flag) {
  return (set & flag) != Flags{};
}

/// Thrust along -Dz as the vector that PX4 has for it.
UlogRecord& put_thrust(UlogRecord& record, float thrust) {
  return record.put(0.0F).put(0.0F).put(-thrust);
}

template <class Values>
UlogRecord& put_all(UlogRecord& record, const Values& values) {
  for (const float value : values) record.put(value);
  return record;
}

/// The message, where the packet is one and undamaged, goes to `use`.
template <class Message, class Use>
void with(const mav::PacketView& packet, const Use& use) {
  if (packet.message_id != Message::kId) return;
  if (const auto message = mav::decode<Message>(packet)) use(*message);
}

void write_battery(sim::UlogFile& file, base::SimTime time, const BatteryStatus& m) {
  constexpr std::uint16_t kNoCell = 0xFFFF;
  double voltage_mv = 0;
  std::uint8_t cells = 0;
  for (const std::uint16_t cell : m.voltages) {
    if (cell == kNoCell) continue;
    voltage_mv += cell;
    ++cells;
  }
  const auto known = [](double value, bool is_known) { return is_known ? value : kNone; };
  write(file, Topic::kBattery,
        UlogRecord(time)
            .put_float(known(voltage_mv * 1e-3, cells > 0))
            .put_float(known(m.current_battery * 1e-2, m.current_battery >= 0))
            .put_float(known(m.current_consumed, m.current_consumed >= 0))
            .put_float(known(m.battery_remaining * 1e-2, m.battery_remaining >= 0))
            .put(cells));
}

}  // namespace

TelemetryUlog::TelemetryUlog(sim::UlogFile& file, std::uint8_t system,
                             std::span<const sim::UlogParam> params)
    : file_(file), system_(system) {
  for (const sim::UlogParam& param : params) params_[param.name] = param.value;
}

void TelemetryUlog::on_packet(base::SimTime time, const mav::PacketView& packet) {
  if (packet.source.system != system_) return;
  on_estimate(time, packet);
  on_setpoint(time, packet);
  on_actuators(time, packet);
  on_state(time, packet);
  on_param(packet);
}

void TelemetryUlog::on_estimate(base::SimTime time, const mav::PacketView& packet) {
  with<Attitude>(packet, [&](const Attitude& m) {
    const Eigen::Quaterniond q = base::quaternion_rpy(m.roll, m.pitch, m.yaw);
    write(file_, Topic::kAttitude,
          UlogRecord(time).put_float(q.w()).put_float(q.x()).put_float(q.y()).put_float(q.z()));
    write(file_, Topic::kAngularVelocity,
          UlogRecord(time).put(m.rollspeed).put(m.pitchspeed).put(m.yawspeed));
  });
  with<EstimatorStatus>(packet, [&](const EstimatorStatus& m) { estimator_ = m.flags; });
  with<LocalPositionNed>(packet, [&](const LocalPositionNed& m) {
    using E = EstimatorStatusFlags;
    write(file_, Topic::kLocalPosition,
          UlogRecord(time)
              .put(m.x)
              .put(m.y)
              .put(m.z)
              .put(m.vx)
              .put(m.vy)
              .put(m.vz)
              .put(has(estimator_, E::kPosHorizRel) || has(estimator_, E::kPosHorizAbs))
              .put(has(estimator_, E::kPosVertAbs))
              .put(has(estimator_, E::kVelocityHoriz))
              .put(has(estimator_, E::kVelocityVert)));
  });
  with<GlobalPositionInt>(packet, [&](const GlobalPositionInt& m) {
    write(file_, Topic::kGlobalPosition,
          UlogRecord(time)
              .put(base::degrees_of_e7(m.lat))
              .put(base::degrees_of_e7(m.lon))
              .put_float(m.alt * 1e-3));
  });
}

void TelemetryUlog::on_setpoint(base::SimTime time, const mav::PacketView& packet) {
  with<AttitudeTarget>(packet, [&](const AttitudeTarget& m) {
    UlogRecord attitude(time);
    put_thrust(put_all(attitude, m.q), m.thrust);
    write(file_, Topic::kAttitudeSetpoint, attitude);
    UlogRecord rates(time);
    put_thrust(rates.put(m.body_roll_rate).put(m.body_pitch_rate).put(m.body_yaw_rate), m.thrust);
    write(file_, Topic::kRatesSetpoint, rates);
  });
  with<PositionTargetLocalNed>(packet, [&](const PositionTargetLocalNed& m) {
    UlogRecord record(time);  // both topics have the same numbers in the same order
    put_all(record,
            std::array{m.x, m.y, m.z, m.vx, m.vy, m.vz, m.afx, m.afy, m.afz, m.yaw, m.yaw_rate});
    write(file_, Topic::kLocalPositionSetpoint, record);
    write(file_, Topic::kTrajectorySetpoint, record);
  });
}

void TelemetryUlog::on_actuators(base::SimTime time, const mav::PacketView& packet) {
  constexpr std::size_t kMotors = 12;  // of actuator_motors
  with<HilControls>(packet, [&](const HilControls& m) {
    write(file_, Topic::kTorqueSetpoint,
          UlogRecord(time).put(m.roll_ailerons).put(m.pitch_elevator).put(m.yaw_rudder));
    UlogRecord thrust(time);
    write(file_, Topic::kThrustSetpoint, put_thrust(thrust, m.throttle));
  });
  with<HilActuatorControls>(packet, [&](const HilActuatorControls& m) {
    by_motor_ = true;
    UlogRecord record(time);
    write(file_, Topic::kActuatorMotors, put_all(record, std::span(m.controls).first<kMotors>()));
  });
  with<ServoOutputRaw>(packet, [&](const ServoOutputRaw& m) {
    const std::array us{m.servo1_raw,  m.servo2_raw,  m.servo3_raw,  m.servo4_raw,
                        m.servo5_raw,  m.servo6_raw,  m.servo7_raw,  m.servo8_raw,
                        m.servo9_raw,  m.servo10_raw, m.servo11_raw, m.servo12_raw,
                        m.servo13_raw, m.servo14_raw, m.servo15_raw, m.servo16_raw};
    const auto last = std::ranges::find_if(us.rbegin(), us.rend(), [](auto v) { return v != 0; });
    UlogRecord outputs(time);
    outputs.put(static_cast<std::uint32_t>(us.rend() - last));
    for (const std::uint16_t pulse : us) outputs.put_float(pulse);
    write(file_, Topic::kActuatorOutputs, outputs);
    if (by_motor_) return;
    UlogRecord motors(time);  // 1000 to 2000 us are 0 to 1; below, the motor is disarmed
    for (const std::uint16_t pulse : std::span(us).first<kMotors>()) {
      motors.put(pulse < 1000 ? kNone : static_cast<float>(pulse - 1000) / 1000.0F);
    }
    write(file_, Topic::kActuatorMotors, motors);
  });
}

void TelemetryUlog::on_state(base::SimTime time, const mav::PacketView& packet) {
  with<Heartbeat>(packet, [&](const Heartbeat& m) {
    const auto nav_state = mav::services::px4_nav_state(m.custom_mode);
    if (m.autopilot != MavAutopilot::kPx4 || !nav_state) return;
    constexpr std::uint8_t kDisarmed = 1;  // ARMING_STATE_DISARMED, ARMING_STATE_ARMED
    constexpr std::uint8_t kArmed = 2;
    write(file_, Topic::kVehicleStatus,
          UlogRecord(time)
              .put(has(m.base_mode, MavModeFlag::kSafetyArmed) ? kArmed : kDisarmed)
              .put(*nav_state)
              .put(static_cast<std::uint8_t>(has(m.base_mode, MavModeFlag::kHilEnabled)))
              .put(static_cast<std::uint8_t>(m.type))
              .put(packet.source.system)
              .put(packet.source.component));
  });
  with<ExtendedSysState>(packet, [&](const ExtendedSysState& m) {
    if (m.landed_state == MavLandedState::kUndefined) return;
    write(file_, Topic::kLandDetected,
          UlogRecord(time).put(m.landed_state == MavLandedState::kOnGround));
  });
  with<BatteryStatus>(packet, [&](const BatteryStatus& m) { write_battery(file_, time, m); });
  with<Statustext>(packet, [&](const Statustext& m) {
    const std::string_view part = mav::text(m.text);
    if (m.id == 0 || m.chunk_seq == 0) sentence_.clear();
    sentence_ += part;
    if (m.id != 0 && part.size() == m.text.size()) return;  // goes on in the next message
    file_.write_text(time, std::min(static_cast<int>(m.severity), 7), sentence_);
    sentence_.clear();
  });
}

void TelemetryUlog::on_param(const mav::PacketView& packet) {
  with<ParamValue>(packet, [&](const ParamValue& m) {
    // PX4 and our controller put the bytes of the value's own type into the float field.
    const bool is_integer = m.param_type == MavParamType::kInt32;
    if (!is_integer && m.param_type != MavParamType::kReal32) return;
    const double value = is_integer ? std::bit_cast<std::int32_t>(m.param_value)
                                    : static_cast<double>(m.param_value);
    const std::string name(mav::text(m.param_id));
    const auto [known, is_new] = params_.try_emplace(name, value);
    if (!is_new && static_cast<float>(known->second) == static_cast<float>(value)) return;
    known->second = value;
    file_.write(sim::UlogParam{.name = name, .is_integer = is_integer, .value = value});
  });
}

}  // namespace cas::hils
