// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/vehicle_health.hpp"

#include <algorithm>
#include <string_view>

namespace cas::casd {
namespace {

using mavlink::common::MavSysStatusSensor;
using mavlink::common::SysStatus;

constexpr base::Duration kFreshStatus = std::chrono::seconds(5);
/// PX4 repeats what fails each time it is asked, ArduPilot every 30 s.
constexpr base::Duration kFreshText = std::chrono::seconds(45);

struct Sensor {
  MavSysStatusSensor bit;
  std::string_view name;
};

constexpr Sensor kNeeded[] = {
    {MavSysStatusSensor::k3dGyro, "gyroscope"},
    {MavSysStatusSensor::k3dAccel, "accelerometer"},
    {MavSysStatusSensor::k3dMag, "magnetometer"},
    {MavSysStatusSensor::kAbsolutePressure, "barometer"},
    {MavSysStatusSensor::kGps, "GPS"},
};

/// How PX4 (1.12, 1.16) and ArduPilot begin the reasons why they will not arm.
constexpr std::string_view kReasons[] = {"Preflight Fail", "PreArm", "Arm:", "Arming denied"};

bool is_reason(std::string_view text) {
  return std::any_of(std::begin(kReasons), std::end(kReasons),
                     [text](std::string_view word) { return text.starts_with(word); });
}

void add(std::vector<std::string>& all, std::string text) {
  if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(std::move(text));
}

void add_sensors(std::vector<std::string>& all, const SysStatus& status) {
  for (const Sensor& sensor : kNeeded) {
    const std::string name(sensor.name);
    if (!has(status.onboard_control_sensors_present, sensor.bit)) {
      add(all, "no " + name);
    } else if (has(status.onboard_control_sensors_enabled, sensor.bit) &&
               !has(status.onboard_control_sensors_health, sensor.bit)) {
      add(all, name + " not healthy");
    }
  }
}

}  // namespace

std::vector<std::string> complaints(const VehicleState& vehicle, base::RunTime now,
                                    std::uint64_t texts_before) {
  std::vector<std::string> all;
  const auto& status = vehicle.sys_status();
  if (status && now - status->at < kFreshStatus) add_sensors(all, status->message);
  if (vehicle.armed()) return all;
  std::uint64_t number = vehicle.status_text_count() - vehicle.status_texts().size();
  for (const StatusText& text : vehicle.status_texts()) {
    if (number++ < texts_before) continue;
    if (now - text.at < kFreshText && is_reason(text.text)) add(all, text.text);
  }
  return all;
}

}  // namespace cas::casd
