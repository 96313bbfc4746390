// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/findings.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "base/text.hpp"
#include "casd/casctl/session/session.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr double kSensorHz = 200;  // the least that stock firmware flies well on

/// The links that a vehicle's system is heard on: the ways of a group are one vehicle's.
std::set<std::string> links_of(const DoctorFacts& facts, const json& vehicle) {
  std::set<std::string> links{vehicle.value("link", "")};
  for (const json& message : facts.messages) {
    if (message.value("direction", "") == "rx" && message.value("name", "") == "HEARTBEAT" &&
        message.value("system", 0) == vehicle.value("system", 0)) {
      links.insert(message.value("link", ""));
    }
  }
  return links;
}

/// Whether a HIL stream passes casd to or from a link.
bool has_stream(const DoctorFacts& facts, const std::string& link) {
  return rate_of(facts, link, "tx", {"HIL_SENSOR"}) > 0 ||
         rate_of(facts, link, "rx", {"HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"}) > 0;
}

bool may_carry_sensors(const json& route) {
  const auto lists = [&route](const char* key) {
    const json list = route.value(key, json::array());
    return std::find(list.begin(), list.end(), json("HIL_SENSOR")) != list.end();
  };
  return route.contains("allow") ? lists("allow") : !lists("block");
}

/// Whether a vehicle without the HIL flag is stock firmware in software (SITL), which never sets it
/// and exchanges sensors and controls with its simulator directly. The topology must consent to
/// such vehicles, and nothing may indicate a board; a question that PX4 did not answer may.
bool is_in_software(const DoctorFacts& facts, const json& vehicle) {
  const std::string autopilot = vehicle.value("autopilot", "");
  if (autopilot == "PX4") {
    const auto sys_hitl = facts.sys_hitl.find(vehicle.value("system", 0));
    if (sys_hitl == facts.sys_hitl.end() || sys_hitl->second != 0) return false;
  } else if (autopilot != "ArduPilot") {
    return false;
  }
  const std::set<std::string> links = links_of(facts, vehicle);
  return facts.after.value("allow_not_hil", false) && !vehicle.value("hil", false) &&
         std::none_of(links.begin(), links.end(), [&facts](const std::string& link) {
           return link_named(facts.after, link).value("type", "") == "serial" ||
                  has_stream(facts, link);
         });
}

/// Whether casd only routes for a vehicle that does not say HIL: nothing may send it sensor data.
/// A real one perhaps: it must get no advice to fly on simulated sensors.
bool is_routed_alone(const DoctorFacts& facts, const json& vehicle) {
  const bool flies_here = vehicle.value("hil", false) || is_in_software(facts, vehicle);
  if (flies_here || facts.routes.empty()) return false;
  const std::set<std::string> links = links_of(facts, vehicle);
  return std::none_of(facts.routes.begin(), facts.routes.end(), [&links](const json& route) {
    return links.contains(route.value("to", "")) && may_carry_sensors(route);
  });
}

/// Remedy for a vehicle without the HIL flag.
std::string remedy_for_no_hil(const DoctorFacts& facts, const json& vehicle) {
  const int system = vehicle.value("system", 0);
  if (const auto why = facts.unasked.find(system); why != facts.unasked.end()) {
    return "SYS_HITL could not be read (" + why->second + "): ask again";
  }
  const auto found = facts.sys_hitl.find(system);
  if (found != facts.sys_hitl.end() && found->second == 1.0) {
    return "SYS_HITL is 1 already: restart the board";
  }
  return "PX4: casctl param set SYS_HITL 1, then casctl reboot; a firmware in software (SITL) "
         "never "
         "says so: see docs/use/firmware";
}

/// The arming checks of a disarmed vehicle.
void check_arming_checks(const DoctorFacts& facts, const json& vehicle, Findings& all) {
  const std::string who = "vehicle " + vehicle.at("system").dump();
  const std::string checks = vehicle.value("arming_checks", "unknown");
  if (checks == "fail") {
    bad(all, who + " says that its arming checks fail",
        "casctl arm tells what it lacks; a ground station's messages do, too");
  } else if (checks == "unknown" && is_routed_alone(facts, vehicle)) {
    return;  // casd is not to arm it
  } else if (checks == "unknown") {
    const std::string autopilot = vehicle.value("autopilot", "");
    const bool tells = autopilot == "PX4" || autopilot == "ArduPilot";
    if (rate_of(facts, vehicle.value("link", ""), "rx", {"SYS_STATUS"},
                vehicle.value("system", 0)) > 0) {
      warn(all, who + " does not tell whether its arming checks pass",
           std::string(autopilot == "PX4" ? "PX4 tells it from v1.13 on; " : "") +
               "casctl arm tells what it lacks");
    } else {
      all.push_back({tells ? Health::kBad : Health::kWarning,
                     who + " has not told whether its arming checks pass",
                     "wait until it has sent SYS_STATUS, or ask: casctl message-interval "
                     "SYS_STATUS 1; casctl arm tells what it lacks",
                     false});
    }
  } else {
    good(all, who + " says that its arming checks pass");
  }
}

}  // namespace

void check_vehicles(const DoctorFacts& facts, Findings& all) {
  const json vehicles = facts.after.value("vehicles", json::array());
  if (vehicles.empty()) {
    bad(all, "no flight controller has sent a HEARTBEAT",
        "is it powered, on the right port, and does that port speak MAVLink (PX4: MAV_1_CONFIG, "
        "SER_TEL2_BAUD)?");
  }
  for (const json& vehicle : vehicles) {
    const std::string who = "vehicle " + vehicle.at("system").dump();
    const double age_s = vehicle.value("heartbeat_age_s", 0.0);
    if (const auto rival = vehicle.find("rival"); rival != vehicle.end()) {
      bad(all,
          who + " is not alone: links " + vehicle.value("link", "?") + " and " +
              rival->value("link", "?") +
              " bring two autopilots with this system id; casd arms neither",
          "give one of them another id (PX4: MAV_SYS_ID, ArduPilot: SYSID_THISMAV), or, where both "
          "links lead to one vehicle, put them into one `group`");
    } else if (is_silent(vehicle)) {
      bad(all, who + " has been silent for " + fixed(age_s, 0) + " s", "see its link above");
    } else if (is_by_external_ahrs(facts, vehicle)) {
      continue;  // check_external_ahrs()
    } else if (is_in_software(facts, vehicle)) {
      good(all,
           who + " is taken for " + vehicle.value("autopilot", "") +
               " in software (SITL): it does not say HIL, and the topology allows that "
               "(allow_not_hil); casctl arm --not-hil arms it. Its sensors do not pass casd: not "
               "checked");
    } else if (is_routed_alone(facts, vehicle)) {
      good(all, who +
                    " is not in HIL, and no route brings it HIL_SENSOR: casd only routes for it, "
                    "and streams were not checked");
      all.back().unchecked = true;
    } else if (!vehicle.value("hil", false)) {
      bad(all, who + " does not say that it is in HIL mode", remedy_for_no_hil(facts, vehicle));
    } else {
      good(all, who + " is in HIL mode");
    }
  }
}

void check_readiness(const DoctorFacts& facts, Findings& all) {
  static const std::set<std::string> kFit = {"standby", "active"};
  for (const json& vehicle : facts.after.value("vehicles", json::array())) {
    if (is_silent(vehicle)) continue;  // said already
    const std::string who = "vehicle " + vehicle.at("system").dump();
    const std::string state = vehicle.value("state", "uninit");
    if (!kFit.contains(state)) {
      bad(all, who + " is in state " + state + ", mode " + vehicle.value("mode", "?"),
          state == "boot" || state == "calibrating"
              ? "wait until it is done; it needs HIL_SENSOR and HIL_GPS to align itself"
              : "casctl reboot, once it is disarmed; a simulated vehicle that fell: reset the "
                "simulator, too");
    }
    const std::string checks = vehicle.value("arming_checks", "unknown");
    for (const json& complaint : vehicle.value("complaints", json::array())) {
      const std::string what = who + ": " + complaint.get<std::string>();
      if (checks == "pass") {  // a text of a while ago, perhaps
        warn(all, what, "its arming checks pass now: casctl arm tells whether this still holds");
      } else {
        bad(all, what,
            "it does not arm until this is gone; after its start give it half a minute, then ask "
            "again");
      }
    }
    if (vehicle.value("armed", false)) {
      good(all, who + " is armed");
      continue;
    }
    const std::string lack = vehicle.value("position_lacks", "");
    if (!lack.empty() && !is_routed_alone(facts, vehicle)) {
      bad(all, who + " cannot take off yet: " + lack,
          "casctl arm waits for it; where a sensor is named, look at its stream and at the board");
      continue;
    }
    check_arming_checks(facts, vehicle, all);
  }
}

void check_streams(const DoctorFacts& facts, Findings& all) {
  for (const json& vehicle : facts.after.value("vehicles", json::array())) {
    const std::string link = vehicle.value("link", "");
    const std::string who = "vehicle " + vehicle.at("system").dump();
    // The vehicle's own line covers these.
    if (is_silent(vehicle) || is_in_software(facts, vehicle) || is_routed_alone(facts, vehicle) ||
        is_by_external_ahrs(facts, vehicle)) {
      continue;
    }
    const double sensor_hz = rate_of(facts, link, "tx", {"HIL_SENSOR"});
    const double control_hz = rate_of(facts, link, "rx", {"HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS"});
    if (sensor_hz <= 0) {
      bad(all, who + " gets no HIL_SENSOR",
          "start hilsim, and let the topology route HIL_SENSOR and HIL_GPS to " + link);
    } else if (sensor_hz < kSensorHz) {
      warn(all, who + " gets only " + fixed(sensor_hz, 0) + " HIL_SENSOR a second",
           "is the simulator slower than real time? See the rate in hilsim's figures");
    } else {
      good(all, who + " gets " + fixed(sensor_hz, 0) + " HIL_SENSOR a second");
    }
    if (control_hz <= 0) {
      bad(all, who + " sends no actuator controls",
          sensor_hz > 0
              ? "it does not take the sensor stream: HIL mode, and at PX4 more than 5000 B/s on "
                "this port (MAV_1_RATE, baud rate of 115200 or more)"
              : "they start when HIL_SENSOR arrives");
    } else {
      good(all, who + " answers with " + fixed(control_hz, 0) + " actuator controls a second" +
                    (vehicle.value("armed", false) ? "" : " (disarmed: the motors stand)"));
    }
  }
}

void check_ground_stations(const DoctorFacts& facts, Findings& all) {
  const json self = facts.after.value("self", json::object());
  std::set<std::pair<int, int>> stations;
  bool twin = false;
  for (const json& message : facts.messages) {
    if (message.value("direction", "") != "rx" || message.value("name", "") != "HEARTBEAT" ||
        message.value("age_s", 1e9) > kFresh_s) {
      continue;
    }
    const std::pair from{message.value("system", 0), message.value("component", 0)};
    if (from.second != kGroundStation) continue;
    if (from == std::pair{self.value("system", 0), self.value("component", 0)}) {
      twin = true;
    } else {
      stations.insert(from);
    }
  }
  if (twin) {
    bad(all, "another station uses casd's own address",
        "give one of them another system_id (a second casd on this network?)");
  }
  if (stations.size() > 1) {
    const std::string ids = base::joined(stations, ", ", [](const auto& station) {
      return std::to_string(station.first) + "/" + std::to_string(station.second);
    });
    warn(all, "several ground stations are connected: " + ids,
         "let one command; two that set modes and parameters fight each other");
  } else if (!twin) {
    good(all,
         stations.empty() ? "no ground station beside casd" : "one ground station beside casd");
  }
}

}  // namespace cas::casctl
