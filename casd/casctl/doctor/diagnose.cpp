// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/findings.hpp"

#include <algorithm>

#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

/// The changed file is not in force.
void check_reload(const DoctorFacts& facts, Findings& all) {
  const json reload = facts.after.value("reload", json::object());
  if (reload.value("accepted", true)) return;
  bad(all,
      "the last reload, " + duration_text(reload.value("age_s", 0.0)) +
          " ago, was refused; the topology before it is in force: " + reload.value("reason", "?"),
      "mend the file, then `casctl reload`; where it takes a restart, restart casd");
}

void check_recording(const DoctorFacts& facts, Findings& all) {
  const json recording = facts.after.value("recording", json::object());
  if (!recording.value("active", false)) {
    if (recording.value("left_out", 0) > 0) {
      warn(all, recording["left_out"].dump() + " packets are missing in the last recording",
           "the disk was full, gone or too slow, or the file was deleted: see casd's log");
    }
    if (!recording.contains("paused")) return;
    return bad(all,
               "casd cannot record in " + recording.value("folder", "?") + ": " +
                   recording["paused"].get<std::string>(),
               "mend this folder (`folder` of `log` in the topology): it must exist, "
               "be casd's to write, and have room under `keep` of `log`");
  }
  const std::string missing = recording.at("left_out").dump() + " packets are missing in it";
  if (recording.contains("paused")) {
    bad(all, "the recording pauses: " + recording["paused"].get<std::string>() + "; " + missing,
        "mend the folder for recordings, or make room in it under `keep` "
        "of `log`; it goes on by itself");
  } else if (recording.value("left_out", 0) > 0) {
    warn(all, "the recording has gaps: " + missing,
         "the disk was full, gone or too slow, or the file was deleted: see casd's log, or record "
         "to another disk (`folder` of `log`)");
  } else {
    good(all, "the recording is whole");
  }
}

bool is_armed(const json& status, const json& system) {
  const json vehicles = status.value("vehicles", json::array());
  return std::ranges::any_of(vehicles, [&system](const json& vehicle) {
    return vehicle.value("system", json()) == system && vehicle.value("armed", false);
  });
}

/// Armed and asked for its log, of which nothing has come. @param status  casd.status
bool awaits_log(const json& status, const json& system) {
  const json logs = status.value("autopilot_logs", json::object());
  return is_armed(status, system) &&
         std::ranges::any_of(logs.value("vehicles", json::array()), [&system](const json& log) {
           return log.value("vehicle", json()) == system && log.value("wanted", false) &&
                  !log.contains("file");
         });
}

void check_autopilot_logs(const DoctorFacts& facts, Findings& all) {
  const auto logs = facts.after.find("autopilot_logs");
  if (logs == facts.after.end()) return;
  if (logs->contains("paused")) {
    return bad(all, "the logs of autopilots pause: " + logs->value("paused", "?"),
               "mend " + logs->value("folder", "?") +
                   ": it must be a folder that casd may write to, with room under "
                   "`keep` of `log`; they go on by themselves");
  }
  for (const json& log : logs->value("vehicles", json::array())) {
    const json vehicle = log.at("vehicle");
    // At one look alone it may have been asked a moment ago.
    const bool sends_none = awaits_log(facts.before, vehicle) && awaits_log(facts.after, vehicle);
    if (!log.contains("trouble") && !sends_none) continue;
    warn(all,
         "vehicle " + vehicle.dump() + " " +
             log.value("trouble", "is armed, was asked for its log and sends none"),
         "its firmware may send no logs (fcu_emulator does not), or a parameter turns them off "
         "(PX4: "
         "SDLOG_BACKEND; ArduPilot: LOG_BACKEND_TYPE)");
  }
}

}  // namespace

Findings diagnose(const DoctorFacts& facts) {
  // A cause before its effects: without its device a link is down, without its link a vehicle is
  // silent, and without sensors no arming check passes.
  Findings all;
  check_reload(facts, all);
  check_devices(facts, all);
  check_links(facts, all);
  check_signing(facts, all);
  check_baud(facts, all);
  check_vehicles(facts, all);
  check_external_ahrs(facts, all);
  check_streams(facts, all);
  check_readiness(facts, all);
  check_ground_stations(facts, all);
  check_recording(facts, all);
  check_autopilot_logs(facts, all);
  check_machine(facts, all);
  return all;
}

}  // namespace cas::casctl
