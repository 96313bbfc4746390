// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/findings.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "casd/casctl/session/session.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/words/external_ahrs_params.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr double kLeastServoHz = 200;  ///< ArduCopter 4.6 gives some 300

/// Whether a ground station has been heard on a link.
bool leads_to_station(const DoctorFacts& facts, const std::string& link) {
  return std::ranges::any_of(facts.messages, [&link](const json& message) {
    return message.value("link", "") == link && message.value("direction", "") == "rx" &&
           message.value("name", "") == "HEARTBEAT" &&
           message.value("component", 0) == kGroundStation;
  });
}

/// Checks the parameters that a vehicle has told.
void check_params(const casd::ParamValues& params, const std::string& who, Findings& all) {
  if (!params.contains("EAHRS_TYPE")) {
    return bad(all, who + " has no parameter EAHRS_TYPE: its firmware is without External AHRS",
               "boards with 2 MB of flash have it up to 4.6; for 4.7 ask ArduPilot's custom build "
               "server");
  }
  const auto port = casd::external_ahrs_port(params);
  if (!port) {
    bad(all, who + ": no SERIALn_PROTOCOL is 36: no port takes the sensors",
        "casctl param set SERIALn_PROTOCOL 36, n of the port with the sensors' line, and restart "
        "the board");
  }
  const std::size_t before = all.size();
  const std::string unknown_port = port ? "" : "SERIAL0";
  for (const casd::ExternalAhrsParam& param : casd::external_ahrs_lacks(params, port.value_or(0))) {
    if (!unknown_port.empty() && param.name.starts_with(unknown_port)) continue;
    const auto found = params.find(param.name);
    if (found == params.end() && params.at("EAHRS_TYPE") == 0 && param.name.starts_with("EAHRS_")) {
      continue;  // ArduPilot shows it once External AHRS is on
    }
    bad(all,
        who + ": " + param.name +
            (found == params.end() ? " is not there" : " is " + fixed(found->second, 0)) +
            ", not " + fixed(param.value, 0) + " (" + param.meaning + ")",
        "casctl param set " + param.name + " " + fixed(param.value, 0) +
            ", and restart the board; hils board setup sets all of them");
  }
  if (port && all.size() == before) good(all, who + " has the parameters of External AHRS");
}

void check_outputs(const DoctorFacts& facts, const json& vehicle, const std::string& who,
                   Findings& all) {
  if (facts.after.value("allow_not_hil", false)) {
    warn(all, who + " has no HIL mode: ITS OUTPUTS ARE LIVE",
         "no motor, ESC or servo may be connected; casctl arm --not-hil arms it");
  } else {
    bad(all, who + " has no HIL mode, and casd does not arm it",
        "disconnect every motor, ESC and servo; then set allow_not_hil: true of `commanding`");
  }
  const double hz = rate_of(facts, vehicle.value("link", ""), "rx", {"SERVO_OUTPUT_RAW"},
                            vehicle.value("system", 0));
  if (hz < kLeastServoHz) {
    bad(all, who + " sends SERVO_OUTPUT_RAW " + fixed(hz, 0) + " times a second",
        "request_rates of its link: {SERVO_OUTPUT_RAW: 300}, and a line that carries it");
  } else {
    good(all, who + " sends SERVO_OUTPUT_RAW " + fixed(hz, 0) + " times a second");
  }
}

}  // namespace

bool is_by_external_ahrs(const DoctorFacts& facts, const json& vehicle) {
  if (vehicle.value("autopilot", "") != "ArduPilot") return false;
  return std::ranges::any_of(facts.routes, [&](const json& route) {
    const json allow = route.value("allow", json::array());
    return route.value("from", "") == vehicle.value("link", "") &&
           std::ranges::find(allow, json("SERVO_OUTPUT_RAW")) != allow.end() &&
           !leads_to_station(facts, route.value("to", ""));
  });
}

void check_external_ahrs(const DoctorFacts& facts, Findings& all) {
  for (const json& vehicle : facts.after.value("vehicles", json::array())) {
    if (is_silent(vehicle) || !is_by_external_ahrs(facts, vehicle)) continue;
    const int system = vehicle.value("system", 0);
    const std::string who = "vehicle " + std::to_string(system);
    check_outputs(facts, vehicle, who, all);
    if (const auto params = facts.params.find(system); params != facts.params.end()) {
      check_params(params->second, who, all);
    } else if (const auto why = facts.unasked.find(system); why != facts.unasked.end()) {
      bad(all, who + ": its parameters could not be read (" + why->second + ")", "ask again");
    }
  }
}

}  // namespace cas::casctl
