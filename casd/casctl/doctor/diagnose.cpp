// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "base/text.hpp"
#include "casd/casctl/session/link_counter.hpp"
#include "casd/casctl/session/table.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr double kBitsPerByte = 10;
constexpr double kFullLine = 0.9;  // of a line's rate: bursts begin to queue
constexpr double kSensorHz = 200;  // the least that stock firmware flies well on
constexpr double kClockStep_s = 0.005;
constexpr double kLateWake_us = 1000;
constexpr double kFresh_s = 3;
constexpr int kGroundStation = 190;  // component id of ground stations

using Findings = std::vector<Finding>;

void good(Findings& all, std::string what) { all.push_back({Health::kGood, std::move(what), ""}); }

void warn(Findings& all, std::string what, std::string remedy) {
  all.push_back({Health::kWarning, std::move(what), std::move(remedy)});
}

void bad(Findings& all, std::string what, std::string remedy) {
  all.push_back({Health::kBad, std::move(what), std::move(remedy)});
}

/// The same link in the other status.
json link_named(const json& status, const std::string& name) {
  for (const json& link : status.value("links", json::array())) {
    if (link.value("name", "") == name) return link;
  }
  return json::object();
}

/// How much a counter grew between the two looks.
double growth(const DoctorFacts& facts, const json& link, const casd::CounterWords& words) {
  const auto value = [&words](const json& of) {
    return static_cast<double>(counter_of(of, words).value_or(0));
  };
  return value(link) - value(link_named(facts.before, link.value("name", "")));
}

double drop_growth(const DoctorFacts& facts, const json& link, const std::string& cause) {
  const auto drops = [&cause](const json& of) {
    return of.contains("tx") ? of["tx"].value("dropped", json::object()).value(cause, 0.0) : 0.0;
  };
  return drops(link) - drops(link_named(facts.before, link.value("name", "")));
}

/// Rate of messages of these names on a link in one direction. @param system  nullopt: of all
double rate_of(const DoctorFacts& facts, const std::string& link, const std::string& direction,
               const std::set<std::string>& names, std::optional<int> system = std::nullopt) {
  double hz = 0;
  for (const json& message : facts.messages) {
    if (message.value("link", "") == link && message.value("direction", "") == direction &&
        names.contains(message.value("name", "")) &&
        (!system || message.value("system", 0) == *system) &&
        message.value("age_s", 1e9) < kFresh_s) {
      hz += message.value("hz", 0.0);
    }
  }
  return hz;
}

/// Advice for a link that is not up; its endpoint has the reason.
std::string remedy_for_down(const json& link) {
  if (link.value("type", "") != "serial") {
    return "start the program at the other end, and compare both ends' addresses";
  }
  if (link.value("endpoint", "").find(": pseudo-terminal ") != std::string::npos) {
    return "start the emulator (again): casd writes to no terminal that it cannot tell from "
           "somebody's; docs/troubleshooting.md has more";
  }
  if (link.value("endpoint", "").find(": No such file") != std::string::npos) {
    return "start the emulator (fcu_emulator), or plug the board in, and compare `device` in the "
           "topology with the emulator's link or /dev/serial/by-id";
  }
  return "plug the board in, and compare `device` in the topology with /dev/serial/by-id";
}

/// Packets that casd dropped, except setpoints replaced by newer ones and packets of closed links.
void check_own_drops(const DoctorFacts& facts, const json& link, Findings& own) {
  for (const casd::CauseWords& words : casd::kCauses) {
    const std::string cause(words.word);
    const double drops = words.trouble ? drop_growth(facts, link, cause) : 0;
    if (drops <= 0) continue;
    warn(own,
         "link " + link.value("name", "?") + ": casd dropped " +
             std::to_string(static_cast<std::uint64_t>(drops)) + " packets (" + cause + ")",
         "`casctl drops` names the messages; docs/troubleshooting.md has a line for each cause");
  }
}

/// "; 120 of its packets go nowhere, as the topology has it (casctl drops)", or nothing.
std::string filtered_text(const DoctorFacts& facts, const json& link) {
  const auto count = [](const json& of) {
    const json rx = of.value("rx", json::object());
    const json verdicts = rx.value("verdicts", json::object());
    double packets = rx.value("not_accepted", 0.0);
    using enum casd::DropCause;
    for (const casd::DropCause cause : {kNoRule, kNoTarget, kRateLimited}) {
      packets += verdicts.value(std::string(to_string(cause)), 0.0);
    }
    return packets;
  };
  const double packets = count(link) - count(link_named(facts.before, link.value("name", "")));
  if (packets <= 0) return "";
  return "; " + std::to_string(static_cast<std::uint64_t>(packets)) +
         " of its packets go nowhere, as the topology has it (casctl drops)";
}

/// "; it dropped 1099 packets before (casctl drops)", or nothing.
std::string earlier_drops_text(const json& link) {
  const json dropped = link.value("tx", json::object()).value("dropped", json::object());
  double packets = 0;
  for (const casd::CauseWords& words : casd::kCauses) {
    if (words.trouble) packets += dropped.value(std::string(words.word), 0.0);
  }
  if (packets <= 0) return "";
  return "; it dropped " + std::to_string(static_cast<std::uint64_t>(packets)) +
         " packets before (casctl drops)";
}

void check_links(const DoctorFacts& facts, Findings& all) {
  for (const json& link : facts.after.value("links", json::array())) {
    const std::string name = "link " + link.value("name", "?");
    if (link.value("state", "") != "up") {
      bad(all, name + " is " + link.value("state", "?") + ": " + link.value("endpoint", ""),
          remedy_for_down(link));
      continue;
    }
    Findings own;
    // A buffer that overflows is a cause, lost packets are its effect: the last first.
    for (auto words = casd::kLinkCounters.rbegin(); words != casd::kLinkCounters.rend(); ++words) {
      if (words->trouble.empty() || growth(facts, link, *words) <= 0) continue;
      (words->bad ? bad : warn)(own, name + ": " + std::string(words->trouble),
                                std::string(words->remedy));
    }
    check_own_drops(facts, link, own);
    if (own.empty()) {
      const bool silent = growth(facts, link, casd::counter_words("rx", "packets")) <= 0;
      good(own, name + " is up, nothing lost or damaged in " + fixed(facts.seconds, 1) + " s" +
                    (silent ? ", nothing received" : "") + earlier_drops_text(link) +
                    filtered_text(facts, link));
    }
    all.insert(all.end(), own.begin(), own.end());
  }
}

double signature_growth(const DoctorFacts& facts, const json& link, const char* verdict) {
  const auto count = [verdict](const json& of) {
    const json rx = of.value("rx", json::object());
    return rx.value("signatures", json::object()).value(verdict, 0.0);
  };
  return count(link) - count(link_named(facts.before, link.value("name", "")));
}

/// Timestamps of signatures must rise, so one from the future shuts out all later packets.
void check_signing(const DoctorFacts& facts, Findings& all) {
  for (const json& link : facts.after.value("links", json::array())) {
    const auto signing = link.find("signing");
    if (signing == link.end()) continue;
    const std::string name = "link " + link.value("name", "?");
    const json future = signing->value("future", json::object());
    if (signature_growth(facts, link, "too_new") > 0) {
      bad(all,
          name + ": " + stream_text(future) + " signs " +
              duration_text(future.value("ahead_s", 0.0)) + " ahead of casd's clock and is refused",
          "put that sender's clock right, or this machine's (`date`); see docs/troubleshooting.md");
    }
    if (signing->value("too_far_ahead", false)) {
      const bool moved = future.value("ahead_s", 0.0) > 0 && !future.value("refused", true);
      bad(all,
          name + ": the time of its signatures is " +
              duration_text(signing->value("time_ahead_s", 0.0)) + " ahead of the clock" +
              (moved ? ", moved there by " + stream_text(future) : "") +
              "; other senders are refused as too old",
          "put the clocks right, stop casd, remove " + signing->value("time_file", "KEY.time") +
              ", start casd; see docs/troubleshooting.md");
    }
  }
}

/// The changed file is not in force.
void check_reload(const DoctorFacts& facts, Findings& all) {
  const json reload = facts.after.value("reload", json::object());
  if (reload.value("accepted", true)) return;
  bad(all,
      "the last reload, " + duration_text(reload.value("age_s", 0.0)) +
          " ago, was refused; the topology before it is in force: " + reload.value("reason", "?"),
      "mend the file, then `casctl reload`; where it takes a restart, restart casd");
}

void check_baud(const DoctorFacts& facts, Findings& all) {
  for (const json& link : facts.after.value("links", json::array())) {
    const double capacity = link.value("baud", 0.0) / kBitsPerByte;
    if (capacity <= 0 || facts.seconds <= 0 || link.value("state", "") != "up") continue;
    const std::string name = "line " + link.value("name", "?");
    const double load = growth(facts, link, casd::counter_words("tx", "bytes")) / facts.seconds;
    const double used = load / capacity;
    const bool late = drop_growth(facts, link, "age") + drop_growth(facts, link, "queue_full") > 0;
    const std::string text =
        name + " carries " + fixed(load / 1000, 1) + " of " + fixed(capacity / 1000, 1) + " kB/s";
    const std::string drops = late ? "; packets are dropped because they would come too late" : "";
    if (used > kFullLine) {
      bad(all, text + drops,
          "raise the baud rate at both ends, or thin out what is routed there (rates)");
    } else if (late) {
      bad(all, text + drops,
          "not the rate: the other side reads too slowly, or this machine is too busy (wake-ups)");
    } else {
      good(all, text);
    }
  }
}

void check_devices(const DoctorFacts& facts, Findings& all) {
  for (const DeviceFacts& device : facts.devices) {
    if (!device.exists) {
      bad(all, device.path + " does not exist",
          "plug the board in; /dev/serial/by-id shows names that last");
    } else if (!device.usable) {
      bad(all, device.path + " may not be opened by you",
          "sudo usermod -aG " + (device.group.empty() ? "dialout" : device.group) +
              " $USER, then log in again (casd needs the right, casctl does not)");
    } else if (device.latency_timer.value_or(1) > 1) {
      warn(all,
           device.path + " holds packets back for up to " + std::to_string(*device.latency_timer) +
               " ms",
           "install config/udev/61-cas-pixhawk.rules, or echo 1 > "
           "/sys/bus/usb-serial/devices/TTY/latency_timer");
    } else {
      good(all, device.path + " is there and may be opened");
    }
  }
}

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

/// Remedy for a vehicle without the HIL flag.
std::string remedy_for_no_hil(const DoctorFacts& facts, const json& vehicle) {
  const int system = vehicle.value("system", 0);
  if (const auto why = facts.unasked.find(system); why != facts.unasked.end()) {
    return "SYS_HITL could not be read: " + why->second + "; ask again, it says what is there";
  }
  const auto found = facts.sys_hitl.find(system);
  if (found != facts.sys_hitl.end() && found->second == 1.0) {
    return "SYS_HITL is 1 already: restart the board";
  }
  return "PX4: casctl param set SYS_HITL 1, then casctl reboot; a firmware in software (SITL) "
         "never "
         "says so: see docs/firmware";
}

bool is_silent(const json& vehicle) {
  return vehicle.value("heartbeat_age_s", 0.0) > vehicle.value("silent_after_s", kFresh_s);
}

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
    } else if (is_in_software(facts, vehicle)) {
      good(all,
           who + " is taken for " + vehicle.value("autopilot", "") +
               " in software (SITL): it does not say HIL, and the topology allows that "
               "(allow_not_hil); casctl arm --not-hil arms it. Its sensors do not pass casd: not "
               "checked");
    } else if (!vehicle.value("hil", false)) {
      bad(all, who + " does not say that it is in HIL mode", remedy_for_no_hil(facts, vehicle));
    } else {
      good(all, who + " is in HIL mode");
    }
  }
}

/// The arming checks of a disarmed vehicle.
void check_arming_checks(const DoctorFacts& facts, const json& vehicle, Findings& all) {
  const std::string who = "vehicle " + vehicle.at("system").dump();
  const std::string checks = vehicle.value("arming_checks", "unknown");
  if (checks == "fail") {
    bad(all, who + " says that its arming checks fail",
        "casctl arm tells what it lacks; a ground station's messages do, too");
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
                     "SYS_STATUS 1; casctl arm tells what it lacks"});
    }
  } else {
    good(all, who + " says that its arming checks pass");
  }
}

/// Whether a vehicle that is heard would arm: its state, its own arming checks and its complaints.
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
        bad(all, what, "it does not arm like this");
      }
    }
    if (vehicle.value("armed", false)) {
      good(all, who + " is armed");
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
    if (is_silent(vehicle) || is_in_software(facts, vehicle)) continue;
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

/// Other commanders: heartbeats of ground stations, and casd's own address from elsewhere.
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

void check_recording(const DoctorFacts& facts, Findings& all) {
  const json recording = facts.after.value("recording", json::object());
  if (!recording.value("active", false)) return;
  const std::string missing = recording.at("left_out").dump() + " packets are missing in it";
  if (recording.contains("paused")) {
    bad(all, "the recording pauses: " + recording["paused"].get<std::string>() + "; " + missing,
        "make room in the folder for recordings, or set free_space_min_mib and max_mib of `log` in "
        "the topology; it goes on by itself");
  } else if (recording.value("left_out", 0) > 0) {
    warn(all, "the recording has gaps: " + missing,
         "the disk was full or too slow: record to another one (`folder` of `log`)");
  } else {
    good(all, "the recording is whole");
  }
}

void check_machine(const DoctorFacts& facts, Findings& all) {
  const auto slow = std::find_if(facts.governors.begin(), facts.governors.end(),
                                 [](const std::string& name) { return name == "powersave"; });
  if (slow != facts.governors.end()) {
    warn(all, "the processors run in powersave mode",
         "sudo cpupower frequency-set -g performance while you fly");
  } else {
    good(all, facts.governors.empty() ? "no CPU frequency scaling"
                                      : "CPU frequency governor " + facts.governors.front());
  }
  if (std::abs(facts.clock_step_s) > kClockStep_s) {
    warn(all, "the wall clock moved by " + fixed(facts.clock_step_s * 1000, 1) + " ms",
         "let NTP settle before you fly: logs get wrong times (casd itself uses the steady clock)");
  } else {
    good(all, "the wall clock runs evenly");
  }
  const std::string wake = "a thread that sleeps 1 ms wakes up to " + fixed(facts.wake_max_us, 0) +
                           " us late (99 %: " + fixed(facts.wake_p99_us, 0) + " us)";
  if (facts.wake_p99_us > kLateWake_us) {
    warn(all, wake,
         "end other programs, or give casd real-time rights (config/systemd/casd-realtime.conf, "
         "scheduling in the topology)");
  } else {
    good(all, wake);
  }
}

}  // namespace

std::vector<Finding> diagnose(const DoctorFacts& facts) {
  // A cause before its effects: without its device a link is down, without its link a vehicle is
  // silent, and without sensors no arming check passes.
  Findings all;
  check_reload(facts, all);
  check_devices(facts, all);
  check_links(facts, all);
  check_signing(facts, all);
  check_baud(facts, all);
  check_vehicles(facts, all);
  check_streams(facts, all);
  check_readiness(facts, all);
  check_ground_stations(facts, all);
  check_recording(facts, all);
  check_machine(facts, all);
  return all;
}

}  // namespace cas::casctl
