// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cas::casd {

/// Parameters of a vehicle by their names.
using ParamValues = std::map<std::string, double>;

/// A parameter of ArduPilot by which it takes all its sensors from an External AHRS. Source:
/// ArduPilot's parameter reference, External AHRS and serial ports.
struct ExternalAhrsParam {
  std::string name;
  double value = 0;
  std::string meaning;
  std::optional<double> least{};  ///< any value from here on will do
};

/// The port, from 0 to 9, whose protocol is External AHRS; nullopt: none.
inline std::optional<int> external_ahrs_port(const ParamValues& now) {
  constexpr double kProtocol = 36;
  for (int port = 0; port <= 9; ++port) {
    const auto found = now.find("SERIAL" + std::to_string(port) + "_PROTOCOL");
    if (found != now.end() && found->second == kProtocol) return port;
  }
  return std::nullopt;
}

/// What an ArduPilot needs to fly by plugin external_ahrs on serial port `port`. Pure.
/// @param now  all its parameters: 4.5 has other names
inline std::vector<ExternalAhrsParam> external_ahrs_params(const ParamValues& now, int port) {
  constexpr double kLeastRate = 200;  // Hz; less is too slow for a multicopter's rate loop
  const std::string serial = "SERIAL" + std::to_string(port);
  return {{"EAHRS_TYPE", 1, "VectorNav"},
          {"EAHRS_RATE", 400, "Hz of the inertial samples", kLeastRate},
          {"EAHRS_SENSORS", 15, "GPS, IMU, barometer and compass of it"},
          {serial + "_PROTOCOL", 36, "the line of the sensors"},
          {serial + "_BAUD", 921, "921600 baud"},
          {now.contains("GPS_TYPE") ? "GPS_TYPE" : "GPS1_TYPE", 21, "GPS by External AHRS"},
          {"AHRS_EKF_TYPE", 3, "ArduPilot's own EKF3; 11 would fly by the unit's attitude"},
          {"INS_ENABLE_MASK", 1, "the external IMU alone: it is the first"}};
}

/// Parameters of external_ahrs_params() that have another value or are missing. Pure. ArduPilot
/// shows those of External AHRS only while EAHRS_TYPE is not 0.
inline std::vector<ExternalAhrsParam> external_ahrs_lacks(const ParamValues& now, int port) {
  std::vector<ExternalAhrsParam> lacks;
  for (ExternalAhrsParam& param : external_ahrs_params(now, port)) {
    const auto found = now.find(param.name);
    const bool fits = found != now.end() &&
                      (param.least ? found->second >= *param.least : found->second == param.value);
    if (!fits) lacks.push_back(std::move(param));
  }
  return lacks;
}

}  // namespace cas::casd
