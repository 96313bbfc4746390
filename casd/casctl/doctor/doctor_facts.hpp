// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "casd/words/external_ahrs_params.hpp"

namespace cas::casctl {

/// A serial device as this machine sees it.
struct DeviceFacts {
  std::string path;
  bool exists = false;
  bool usable = false;               ///< readable and writable by the doctor's user
  std::string group;                 ///< that owns it
  std::optional<int> latency_timer;  ///< ms; of USB-serial adapters that have one
};

/// All that the doctor looks at.
struct DoctorFacts {
  nlohmann::json before;                            ///< casd.status
  nlohmann::json after;                             ///< casd.status, `seconds` later
  nlohmann::json messages;                          ///< message.list after
  nlohmann::json routes = nlohmann::json::array();  ///< link.routes
  double seconds = 0;
  std::map<int, double> sys_hitl;  ///< by system: the parameter of PX4s that do not say HIL
  std::map<int, casd::ParamValues> params;  ///< by system: of ArduPilots by External AHRS
  std::map<int, std::string> unasked;       ///< why they could not be read

  std::vector<DeviceFacts> devices;
  std::vector<std::string> governors;  ///< CPU frequency governors in force
  double clock_step_s = 0;             ///< of the wall clock against the monotonic clock
  double wake_p99_us = 0;              ///< lateness of a thread that sleeps 1 ms at a time
  double wake_max_us = 0;
};

/// Component id of ground stations.
inline constexpr int kGroundStation = 190;

/// Messages that came longer ago do not count as a stream.
inline constexpr double kFresh_s = 3;

/// A link in a casd.status; an empty object if it has none of that name.
nlohmann::json link_named(const nlohmann::json& status, const std::string& name);

/// Rate of messages of these names on a link in one direction. @param system  nullopt: of all
double rate_of(const DoctorFacts& facts, const std::string& link, const std::string& direction,
               const std::set<std::string>& names, std::optional<int> system = std::nullopt);

}  // namespace cas::casctl
