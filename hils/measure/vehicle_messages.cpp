// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/vehicle_messages.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "casd/station/failure_injector.hpp"
#include "casd/station/vehicle_state.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "hils/measure/run_record.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/sys_status.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

using namespace mavlink::common;  // NOLINT: the file is about its messages

namespace {

struct HealthFlag {
  MavSysStatusSensor flag;
  std::string_view name;
};
constexpr std::array<HealthFlag, 12> kHealthFlags{
    {{MavSysStatusSensor::k3dGyro, "gyro"},
     {MavSysStatusSensor::k3dAccel, "accelerometer"},
     {MavSysStatusSensor::k3dMag, "compass"},
     {MavSysStatusSensor::kAbsolutePressure, "barometer"},
     {MavSysStatusSensor::kGps, "GPS"},
     {MavSysStatusSensor::kAhrs, "attitude estimate"},
     {MavSysStatusSensor::kYawPosition, "heading"},
     {MavSysStatusSensor::kZAltitudeControl, "height"},
     {MavSysStatusSensor::kXyPositionControl, "position"},
     {MavSysStatusSensor::kMotorOutputs, "motors"},
     {MavSysStatusSensor::kBattery, "battery"},
     {MavSysStatusSensor::kPrearmCheck, "arming checks"}}};

/// Whether a text refuses a command: it is no sign of a fault by itself.
bool refuses_command(std::string_view text) {
  return text.starts_with("Arm: ") || text.find(" denied") != std::string_view::npos ||
         text.find(" refused") != std::string_view::npos;
}

/// Collects a vehicle's signs and armed states from the packets of a flight log.
class MessageReader {
 public:
  explicit MessageReader(const RunRecord& record) : record_(record) {}

  void on_packet(std::int64_t log_us, const mav::PacketView& packet) {
    constexpr std::uint8_t kAutopilot = 1;
    if (packet.source.system != record_.system || packet.source.component != kAutopilot) return;
    now_s_ = 1e-6 * static_cast<double>(record_.log_clock.to_sim_us(log_us));
    if (const auto beat = mav::decode<Heartbeat>(packet)) on_heartbeat(*beat);
    if (const auto text = mav::decode<Statustext>(packet)) on_text(*text);
    if (const auto status = mav::decode<SysStatus>(packet)) on_status(*status);
  }

  VehicleMessages finish() { return std::move(messages_); }

 private:
  void on_heartbeat(const Heartbeat& beat) {
    const bool armed = has(beat.base_mode, MavModeFlag::kSafetyArmed);
    if (armed != armed_) messages_.armed.push_back({now_s_, armed});
    armed_ = armed;
    const bool critical = beat.system_status == MavState::kCritical ||
                          beat.system_status == MavState::kEmergency ||
                          beat.system_status == MavState::kFlightTermination;
    const auto modes = mav::services::mode_set(casd::autopilot_family(beat.autopilot), beat.type);
    const std::string mode = mode_name(modes, beat.base_mode, beat.custom_mode);
    if (critical && (!critical_ || mode != mode_)) {
      messages_.signs.push_back({.time_s = now_s_, .what = mode, .is_reaction = true});
    }
    critical_ = critical;
    mode_ = mode;
  }

  void on_text(const Statustext& message) {
    if (message.severity > MavSeverity::kWarning) return;
    std::string text(mav::text(message.text));
    std::ranges::replace_if(
        text, [](char c) { return c < ' ' || c > '~'; }, '?');
    if (text.starts_with(casd::kInjectorPrefix) || refuses_command(text)) return;
    messages_.signs.push_back({.time_s = now_s_, .what = "'" + text + "'"});
  }

  void on_status(const SysStatus& status) {
    std::string fallen;
    for (const auto& [flag, name] : kHealthFlags) {
      if (flag == MavSysStatusSensor::kPrearmCheck && armed_) continue;
      const bool fell = has(healthy_, flag) && !has(status.onboard_control_sensors_health, flag);
      if (fell) fallen += (fallen.empty() ? "" : ", ") + std::string(name);
    }
    healthy_ = status.onboard_control_sensors_health;
    if (!fallen.empty()) messages_.signs.push_back({.time_s = now_s_, .what = "health: " + fallen});
  }

  const RunRecord& record_;
  double now_s_ = 0;
  bool armed_ = false;
  bool critical_ = false;
  std::string mode_;
  MavSysStatusSensor healthy_{};
  VehicleMessages messages_;
};

}  // namespace

VehicleMessages read_vehicle_messages(const RunRecord& record) {
  MessageReader reader(record);
  casd::for_each_tlog_packet(record.flight_tlog, table(),
                             [&](std::uint64_t unix_us, const mav::PacketView& packet) {
                               reader.on_packet(static_cast<std::int64_t>(unix_us), packet);
                             });
  return reader.finish();
}

}  // namespace cas::hils
