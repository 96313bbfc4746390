// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/port_description.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "casd/words/link_words.hpp"

namespace cas::casd {
namespace {

// @rx, @tx and @link stand for counters. Units are in the names; N is the vehicle's local frame (x
// north, y east, z down).
constexpr const char* kText = R"json({
"title": "casd",
"shapes": {
  "Acknowledgement": {"vehicle": "integer: system id", "result": "string: ACCEPTED, or SENT where nothing acknowledges",
    "at_s?": "number: moment of the answer by casd's clock"},
  "Quantiles": {"p50": "number: us", "p99": "number: us", "max": "number: us"},
  "Counts": {"*": "integer"},
  "LinkReceived": {@rx, "verdicts": "Counts", "signatures?": "Counts"},
  "LinkSent": {@tx, "forwarding_us": "Quantiles"},
  "FutureSignature": {"system": "integer", "component": "integer", "link_id": "integer", "ahead_s": "number",
    "refused": "integer", "age_s": "number"},
  "LinkSigning": {"time_file": "string", "time_ahead_s": "number", "too_far_ahead": "boolean", "future?": "FutureSignature"},
  "Link": {"name": "string", "type": "string: udp, udp_server, serial, tcp, tcp_server, tlog",
    "state": "string: up, down, opening", "endpoint": "string: bound address or device, or why it is down",
    "remote?": "string: where a udp link sends, as the topology has it", "baud?": "integer", "added?": "boolean: true where it was added at run time", "sniffer?": "boolean: gets every packet", "group?": "string: of redundant paths",
    "to_not_hil?": "string: all, or stops_only where what may spin or move a vehicle that is not in HIL is held back; absent where the link only listens", @link, "rx": "LinkReceived", "tx": "LinkSent",
    "signing?": "LinkSigning"},
  "RateLimit": {"message": "string|integer", "max_hz?": "number", "every?": "integer"},
  "Route": {"from": "string", "to": "string", "allow?": ["string|integer"], "block?": ["string|integer"],
    "allow_systems?": ["integer"], "block_systems?": ["integer"], "allow_components?": ["integer"],
    "block_components?": ["integer"], "rates?": ["RateLimit"]},
  "Unreadable": {"link": "string", "cause": "string: crc, kernel, foreign, not_accepted, no_memory", "count": "integer"},
  "DroppedMessage": {"link": "string", "id": "integer", "name": "string", "system": "integer", "component": "integer",
    "count": "integer", "hz": "number", "age_s": "number", "cause": "string"},
  "Drops": {"unreadable": ["Unreadable"], "dropped": ["DroppedMessage"]},
  "RouteLatency": {"from": "string", "count": "integer", "p50": "number: us", "p99": "number: us", "max": "number: us"},
  "LinkLatency": {"link": "string", "p50": "number: us", "p99": "number: us", "max": "number: us", "routes": ["RouteLatency"]},
  "Echo": {"vehicle": "integer", "count": "integer", "unmatched": "integer", "p50": "number: us", "p99": "number: us",
    "max": "number: us"},
  "MessageCount": {"link": "string", "direction": "string: rx, tx or drop.CAUSE", "id": "integer", "name": "string",
    "system": "integer", "component": "integer", "count": "integer", "hz": "number: over the last seconds", "age_s": "number"},
  "MessageField": {"name": "string", "value": "any", "units?": "string"},
  "MessageFields": ["MessageField"],
  "MessageValue": {"id": "integer", "name": "string", "fields": "MessageFields|null: in the order of the dialect",
    "age_s?": "number", "count?": "integer: packets since the look began"},
  "Rival": {"component": "integer", "link": "string", "heartbeat_age_s": "number"},
  "Vehicle": {"system": "integer", "component": "integer", "autopilot": "string: PX4, ArduPilot, other", "type": "string",
    "armed": "boolean", "hil": "boolean", "mode": "string", "state": "string: MAV_STATE", "arming_checks": "string: pass, fail, unknown",
    "landed": "string: undefined, on_ground, in_air, taking_off, landing", "link": "string", "heartbeat_age_s": "number",
    "silent_after_s": "number: an older HEARTBEAT means that it is silent", "complaints": ["string: speaks against flying"],
    "position_lacks?": "string: what takeoff by position still needs; left out: nothing", "rival?": "Rival"},
  "Attitude": {"roll_rad": "number", "pitch_rad": "number", "yaw_rad": "number", "p_rad_s": "number", "q_rad_s": "number",
    "r_rad_s": "number", "age_s": "number"},
  "PositionN": {"x_m": "number: north", "y_m": "number: east", "z_m": "number: down", "vx_m_s": "number", "vy_m_s": "number",
    "vz_m_s": "number", "age_s": "number"},
  "GlobalPosition": {"lat_deg": "number", "lon_deg": "number", "alt_m": "number: above mean sea level",
    "relative_alt_m?": "number: above home; left out: HIGH_LATENCY2 alone tells of it, and its home is unknown", "age_s": "number"},
  "Home": {"lat_deg": "number", "lon_deg": "number", "alt_m": "number: above mean sea level", "x_m": "number: north in N",
    "y_m": "number: east in N", "z_m": "number: down in N"},
  "StatusText": {"severity": "string: emergency to debug", "text": "string", "age_s": "number"},
  "Intervention": {"by": "string: system/component", "link": "string", "what": "string: command 400 (disarm)", "disarms": "boolean: or may do so",
    "times": "integer", "age_s": "number: of the newest"},
  "Interventions": ["Intervention"],
  "VehicleState": {"system": "integer", "component": "integer", "autopilot": "string", "type": "string", "armed": "boolean",
    "hil": "boolean", "mode": "string", "state": "string", "arming_checks": "string", "landed": "string", "link": "string",
    "heartbeat_age_s": "number", "silent_after_s": "number", "complaints": ["string"], "rival?": "Rival", "attitude?": "Attitude",
    "position_N?": "PositionN", "global?": "GlobalPosition", "home?": "Home", "altitude_m?": "number: above home",
    "altitude_age_s?": "number", "landed_age_s?": "number", "position_lacks?": "string: what takeoff by position still needs; left out: nothing",
    "firmware?": "string: its version", "vtol?": "string: multicopter, to_plane, plane, to_multicopter; left out: it is no VTOL",
    "at_s": "number: by casd's clock", "statustexts": ["StatusText"],
    "interventions?": "Interventions: what others than casd had it do, in the order in which each kind first came; left out: nothing"},
  "TelemetryState": {"armed": "boolean|null", "mode": "string|null", "landed": "string|null", "system_state": "string|null",
    "age_s": "number|null"},
  "TelemetryAttitude": {"roll_deg": "number|null", "pitch_deg": "number|null", "yaw_deg": "number|null", "age_s": "number|null"},
  "TelemetryRates": {"roll_deg_s": "number|null", "pitch_deg_s": "number|null", "yaw_deg_s": "number|null",
    "age_s": "number|null"},
  "TelemetryPosition": {"north_m": "number|null", "east_m": "number|null", "down_m": "number|null", "age_s": "number|null"},
  "TelemetryVelocity": {"north_m_s": "number|null", "east_m_s": "number|null", "down_m_s": "number|null", "age_s": "number|null"},
  "TelemetryGlobal": {"lat_deg": "number|null", "lon_deg": "number|null", "alt_m": "number|null: above mean sea level",
    "relative_alt_m": "number|null: above home", "heading_deg": "number|null", "age_s": "number|null"},
  "TelemetryBattery": {"voltage_v": "number|null", "current_a": "number|null", "remaining_percent": "number|null",
    "age_s": "number|null"},
  "TelemetryGps": {"fix": "string|null", "satellites": "integer|null", "lat_deg": "number|null", "lon_deg": "number|null",
    "alt_m": "number|null", "hdop": "number|null", "vdop": "number|null", "speed_m_s": "number|null", "course_deg": "number|null",
    "horizontal_accuracy_m": "number|null", "vertical_accuracy_m": "number|null", "age_s": "number|null"},
  "TelemetryEstimator": {"attitude_ok": "boolean|null", "horizontal_velocity_ok": "boolean|null",
    "vertical_velocity_ok": "boolean|null", "horizontal_position_ok": "boolean|null", "height_ok": "boolean|null",
    "gps_glitch": "boolean|null", "accel_error": "boolean|null", "velocity_ratio": "number|null",
    "horizontal_position_ratio": "number|null", "height_ratio": "number|null", "mag_ratio": "number|null",
    "horizontal_accuracy_m": "number|null", "vertical_accuracy_m": "number|null", "age_s": "number|null"},
  "TelemetryRotors": {"output1_us": "number|null", "output2_us": "number|null", "output3_us": "number|null",
    "output4_us": "number|null", "output5_us": "number|null", "output6_us": "number|null", "output7_us": "number|null",
    "output8_us": "number|null", "age_s": "number|null"},
  "Telemetry": {"vehicle": "integer", "state": "TelemetryState", "attitude": "TelemetryAttitude", "rates": "TelemetryRates",
    "position": "TelemetryPosition", "velocity": "TelemetryVelocity", "global": "TelemetryGlobal",
    "battery": "TelemetryBattery", "gps": "TelemetryGps", "estimator": "TelemetryEstimator", "rotors": "TelemetryRotors"},
  "GainsBefore": {"p?": "number|null", "i?": "number|null", "d?": "number|null"},
  "Gains": {"vehicle": "integer", "loop": "string", "p?": "number|null", "i?": "number|null", "d?": "number|null",
    "parameters": {"*": "number|null"}, "before?": "GainsBefore: of each that was set"},
  "GainLoop": {"loop": "string", "parameters": {"p?": "string", "i?": "string", "d?": "string"}},
  "GainLoops": {"vehicle": "integer", "loops": ["GainLoop"]},
  "Parameter": {"vehicle": "integer", "name": "string", "value": "number|null", "type": "string: UINT8 to REAL32",
    "before?": "number|null: of one that was set"},
  "ListedParameter": {"name": "string", "value": "number|null", "type": "string"},
  "Parameters": {"vehicle": "integer", "parameters": ["ListedParameter"]},
  "Recording": {"active": "boolean", "awaits_arming": "boolean", "folder": "string", "file": "string", "recorded": "integer: packets",
    "left_out": "integer: packets", "bytes": "integer", "paused?": "string", "paused_s?": "number"},
  "AutopilotLog": {"vehicle": "integer: system id", "wanted": "boolean: the vehicle is asked for it", "file?": "string", "bytes?": "integer",
    "trouble?": "string"},
  "AutopilotLogs": {"folder": "string", "paused?": "string: why nothing is written", "paused_s?": "number", "vehicles": ["AutopilotLog"]},
  "LogStatus": {"ended?": "string: file of the recording that the call has ended", "active": "boolean", "awaits_arming": "boolean", "folder": "string", "file": "string",
    "recorded": "integer: packets", "left_out": "integer: packets", "bytes": "integer", "paused?": "string", "paused_s?": "number"},
  "JournalCall": {"at_s": "number: by casd's clock", "unix_us": "integer: by that of a recording", "client": "string", "method": "string",
    "params": "any: null where it was longer than 1 KiB", "vehicle": "integer: system id; 0: none", "refusal?": "string", "times?": "integer: so often one after the other; left out: once"},
  "Journal": {"calls": ["JournalCall"], "forgotten": "integer: older ones"},
  "Self": {"system": "integer", "component": "integer"},
  "Reload": {"accepted": "boolean", "age_s": "number", "reason?": "string"},
  "DaemonStatus": {"schema": "integer", "program": "string", "version": "string", "uptime_s": "number", "name?": "string",
    "topology?": "string", "threads": "string: auto, per_link, single, blocking", "self": "Self", "allow_not_hil": "boolean: as in the topology",
    "clients": "integer", "links": ["Link"],
    "vehicles": ["Vehicle"], "recording?": "Recording", "autopilot_logs?": "AutopilotLogs: left out: none are taken", "reload?": "Reload"}
},
"methods": {
  "casd.status": {"summary": "Everything at a glance.", "params": {}, "result": "DaemonStatus"},
  "casd.reload": {"summary": "Reads the topology again.", "params": {}, "result": {"reloaded": "boolean"}},
  "casd.journal": {"summary": "The newest calls of the audit about vehicles and links, the oldest first.", "params": {}, "result": "Journal"},
  "link.list": {"summary": "State and counters of each link.", "params": {}, "result": ["Link"]},
  "link.add": {"summary": "Opens one more link, until it is removed or the topology is read again.",
    "params": {"entry": {"*": "any"}, "routes?": [{"*": "any"}]},
    "result": {"link": "string: its name"}},
  "link.remove": {"summary": "Closes a link.",
    "params": {"link": "string", "force?": "boolean: also the only link of an armed vehicle"}, "result": {"link": "string"}},
  "link.routes": {"summary": "The rules in force.", "params": {}, "result": ["Route"]},
  "link.drops": {"summary": "Why packets did not go on.",
    "params": {"link?": "string: that one alone", "limit?": "integer: rows of the answer; left out: 5000", "offset?": "integer: rows before it"}, "result": "Drops"},
  "link.latency": {"summary": "Forwarding times by sending link, in us.", "params": {}, "result": ["LinkLatency"]},
  "link.echo": {"summary": "From a HIL_SENSOR in to the controls that echo its stamp, by vehicle, in us.", "params": {}, "result": ["Echo"]},
  "message.list": {"summary": "Each message of each sender, in the order in which they were first heard.",
    "params": {"link?": "string: that one alone", "limit?": "integer: rows of the answer; left out: 5000", "offset?": "integer: rows before it"}, "result": ["MessageCount"]},
  "message.value": {"summary": "The newest packet of one message of one sender on one link, decoded.",
    "params": {"link": "string", "message": "string|integer: name or id", "system": "integer", "component": "integer"},
    "result": "MessageValue"},
  "vehicle.state": {"summary": "What the vehicle has told about itself.", "params": {"vehicle?": "integer: system id"}, "result": "VehicleState"},
  "vehicle.telemetry": {"summary": "What the vehicle measures, by topic; what it has not told is null.",
    "params": {"vehicle?": "integer: system id"}, "result": "Telemetry"},
  "vehicle.arm": {"summary": "Arms; answered when the vehicle has acknowledged.",
    "params": {"vehicle?": "integer: system id", "force?": "boolean: without the vehicle's own checks",
               "not_hil?": "boolean: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN"},
    "result": "Acknowledgement"},
  "vehicle.disarm": {"summary": "Disarms.",
    "params": {"vehicle?": "integer: system id", "force?": "boolean: in flight, too"}, "result": "Acknowledgement"},
  "vehicle.takeoff": {"summary": "Takes off.",
    "params": {"vehicle?": "integer: system id", "altitude_m": "number: above home, above 0, at most 10 000",
               "not_hil?": "boolean: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN"}, "result": "Acknowledgement"},
  "vehicle.land": {"summary": "Lands where it is.", "params": {"vehicle?": "integer: system id"}, "result": "Acknowledgement"},
  "vehicle.hold": {"summary": "Stays where it is.", "params": {"vehicle?": "integer: system id"}, "result": "Acknowledgement"},
  "vehicle.rtl": {"summary": "Returns home and lands.", "params": {"vehicle?": "integer: system id"}, "result": "Acknowledgement"},
  "vehicle.reboot": {"summary": "Restarts the autopilot.",
    "params": {"vehicle?": "integer: system id", "not_hil?": "boolean: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE"}, "result": "Acknowledgement"},
  "vehicle.goto": {"summary": "Goes to a position in the local frame N.",
    "params": {"vehicle?": "integer: system id", "north_m": "number", "east_m": "number", "down_m": "number",
               "yaw_deg?": "number: heading from north, clockwise; left out: it stays",
               "radius_m?": "number: of the circle about it, for a vehicle that flies on its wing; below 0 counter-clockwise",
               "not_hil?": "boolean: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE"}, "result": "Acknowledgement"},
  "vehicle.mode": {"summary": "Changes the autopilot's mode, by its word.",
    "params": {"vehicle?": "integer: system id", "mode": "string: HOLD, POSCTL, GUIDED, ...",
               "not_hil?": "boolean: also one that does not say that it is in HIL. A REAL VEHICLE MAY MOVE"}, "result": "Acknowledgement"},
  "vehicle.manual_control": {"summary": "Stick positions, once; repeat them at 10 Hz or more.",
    "params": {"vehicle?": "integer: system id", "pitch?": "number: -1 to 1, forward", "roll?": "number: -1 to 1, right",
               "throttle?": "number: 0 to 1", "yaw?": "number: -1 to 1, clockwise", "buttons?": "integer: bits",
               "not_hil?": "boolean: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN"},
    "result": "Acknowledgement"},
  "vehicle.message_interval": {"summary": "How often the vehicle sends a message.",
    "params": {"vehicle?": "integer: system id", "message": "string|integer: name or id", "hz?": "number: 0 is off; left out: its default"},
    "result": "Acknowledgement"},
  "vehicle.command": {"summary": "Any MAV_CMD as COMMAND_LONG.",
    "params": {"vehicle?": "integer: system id", "command": "integer: MAV_CMD", "params?": ["number|null: null is NaN"],
               "not_hil?": "boolean: also one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN"},
    "result": "Acknowledgement"},
  "gain.set": {"summary": "Sets gains of a control loop, one at least; those left out stay.",
    "params": {"vehicle?": "integer: system id", "loop": "string: rollrate, velocity, ...", "p?": "number", "i?": "number", "d?": "number",
               "not_hil?": "boolean: also of one that does not say that it is in HIL. REAL PROPELLERS MAY SPIN"},
    "result": "Gains"},
  "gain.get": {"summary": "The gains of a loop in force.", "params": {"vehicle?": "integer: system id", "loop": "string"}, "result": "Gains"},
  "gain.list": {"summary": "The loops of this vehicle's autopilot.", "params": {"vehicle?": "integer: system id"}, "result": "GainLoops"},
  "param.get": {"summary": "One parameter.", "params": {"vehicle?": "integer: system id", "name": "string"}, "result": "Parameter"},
  "param.set": {"summary": "Changes a parameter; answered with the value in force.",
    "params": {"vehicle?": "integer: system id", "name": "string", "value": "number",
               "not_hil?": "boolean: also one that arms or drives outputs, of a vehicle that does not say that it is in HIL. REAL PROPELLERS MAY SPIN"},
    "result": "Parameter"},
  "param.list": {"summary": "All parameters: takes as long as new ones come.", "params": {"vehicle?": "integer: system id"}, "result": "Parameters"},
  "log.start": {"summary": "Records every packet that passes into a new .tlog file.",
    "params": {"file?": "string: a name, no path", "rotate_mib?": "number: MiB, 0 is off", "rotate_minutes?": "number: 0 is off",
               "keep?": "integer: files that stay, 0 is all"}, "result": "LogStatus"},
  "log.stop": {"summary": "Ends the recording.", "params": {}, "result": "LogStatus"},
  "log.status": {"summary": "The recording.", "params": {}, "result": "LogStatus"}
},
"topics": {
  "statustext": {"summary": "A vehicle says something.",
    "params": {"vehicle": "integer", "severity": "string: emergency to debug", "text": "string"}},
  "parameters": {"summary": "Once a second while param.list is under way; a count of 0 is not known yet.",
    "params": {"vehicle": "integer", "received": "integer", "count": "integer"}},
  "links": {"summary": "A link changes its state.",
    "params": {"link": "string", "state": "string", "endpoint": "string", "reconnects": "integer"}},
  "messages": {"summary": "Once a second, as message.list answers, the first 2000.", "params": ["MessageCount"]},
  "drops": {"summary": "Once a second in which packets were dropped, as link.drops answers, the first 2000.", "params": "Drops"}
}
})json";

/// The counters of a block of a link's JSON (kLinkCounters), as keys of a shape.
std::string counter_keys(std::string_view group) {
  using Kind = CounterWords::Kind;
  std::vector<std::string> keys;
  for (const CounterWords& words : kLinkCounters) {
    if (words.group != group) continue;
    const nlohmann::json key = words.key;
    const nlohmann::json shape = std::string(words.kind == Kind::kByCause ? "Counts" : "integer") +
                                 ": " + std::string(words.help);
    keys.push_back(key.dump() + ": " + shape.dump());
  }
  return base::joined(keys, ", ");
}

}  // namespace

base::rpc::Description port_description(std::string version) {
  std::string text = kText;
  for (const auto& [mark, group] : {std::pair{"@rx", "rx"}, {"@tx", "tx"}, {"@link", ""}}) {
    text.replace(text.find(mark), std::string_view(mark).size(), counter_keys(group));
  }
  return {text, std::move(version)};
}

}  // namespace cas::casd
