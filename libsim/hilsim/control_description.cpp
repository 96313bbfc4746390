// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/control_description.hpp"

#include <utility>

namespace cas::sim {
namespace {

// W is east-north-up, B forward-left-up, N north-east-down, D forward-right-down.
constexpr const char* kText = R"json({
"title": "hilsim",
"shapes": {
  "VehicleTruth": {"name": "string", "p_W": ["number: m, centre of mass"], "v_W": ["number: m/s"],
    "q_WB": ["number: w, x, y, z; turns B into W"], "w_B": ["number: rad/s"],
    "rpy_ND_rad": ["number: roll, pitch, yaw of D against N"], "in_contact": "boolean"},
  "ScenePart": {"name": "string", "shape": "string: box, sphere, cylinder, plane, mesh", "p": ["number: m, in the parent"],
    "q": ["number: w, x, y, z"], "size_m?": ["number"], "radius_m?": "number", "length_m?": "number: along z",
    "mesh?": "string: sha256: and the hash", "surface?": "SceneSurface: of a visual that is a control surface"},
  "SceneSurface": {"index": "integer", "sign": "number: of the turn about its y axis at x = size / 2 by a deflection above 0"},
  "SceneRotor": {"p_B": ["number: m, hub"], "axis_B": ["number"], "radius_m": "number", "spin": "integer: 1 counter-clockwise, -1 clockwise",
    "k_f": "number: N s^2", "k_m": "number: N m s^2", "omega_max_rad_s": "number"},
  "SceneRay": {"name": "string", "p_B": ["number: m"], "dir_B": ["number"], "max_m": "number"},
  "SceneVehicle": {"name": "string", "type": "string: the vehicle file's name", "system": "integer", "mass_kg": "number",
    "parts": ["ScenePart: what touches the ground"], "visuals": ["ScenePart: of its model without the rotors; none where it has neither wings nor a mesh among them"],
    "rotors": ["SceneRotor"], "rays": ["SceneRay"]},
  "SceneObstacle": {"name": "string", "parts": ["ScenePart"]},
  "SceneHome": {"lat_deg": "number", "lon_deg": "number", "alt_m": "number"},
  "Scene": {"hash": "string", "frame": "string: W", "home": "SceneHome", "vehicles": ["SceneVehicle"], "world": ["ScenePart"],
    "obstacles": ["SceneObstacle: that move"]},
  "VehicleMotion": {"p": ["number: m, in W"], "q": ["number: w, x, y, z; turns B into W"], "vel": ["number: m/s, in W"],
    "w": ["number: rad/s, in B"], "rotors": ["number: rad/s"], "surfaces": ["number: rad"], "contact": "integer: 0 or 1", "rays": ["number|null: m"]},
  "ObstacleMotion": {"p": ["number: m, in W"], "q": ["number: w, x, y, z"]},
  "Motion": {"t_s": "number: simulated", "steps": "integer", "rate": "number: real-time factor", "paused": "boolean",
    "late_steps": "integer", "v": ["VehicleMotion"], "wind_W": ["number: m/s, at the first vehicle"], "o": ["ObstacleMotion"]},
  "Clouds": {"t_s": "number: simulated", "v": ["any: x, y, z of each return in W, m, one after the other, in the order of the scene's vehicles"]},
  "MeshPiece": {"bytes": "integer: of the whole mesh", "base64": "string: the bytes from `offset` on, 256 KiB at most"},
  "NotedCall": {"unix_us": "integer", "time_s": "number: simulated", "client": "string", "method": "string: or a signal's name", "params": "any",
    "times?": "integer: so many of sim.run_until, or of the same sim.step, in a row; params of the last"},
  "SimJournal": {"calls": ["NotedCall"], "forgotten": "integer: older ones"},
  "SimStatus": {"time_s": "number: simulated", "steps": "integer", "paused": "boolean", "pace": "string: realtime, lockstep, free_run",
    "real_time_factor": "number", "late_steps": "integer", "lockstep_timeouts": "integer", "vehicles": ["VehicleTruth"]},
  "Distribution": {"p50": "number: us", "p99": "number: us", "max": "number: us", "count": "integer",
    "histogram": ["any: [upper end in us, entries]"]},
  "SimWarning": {"vehicle": "string: its name, or empty for the world", "warning": "string"},
  "SimStats": {"schema": "integer", "program": "string", "time_s": "number: simulated", "steps": "integer", "wall_s": "number",
    "real_time_factor": "number", "late_steps": "integer", "lockstep_timeouts": "integer", "given_up_s": "number",
    "step_us": "Distribution", "lateness_us": "Distribution", "plugins": {"*": "any"},
    "warnings": ["SimWarning"]}
},
"methods": {
  "sim.status": {"summary": "Time, pace and the true motion of each vehicle.", "params": {}, "result": "SimStatus"},
  "sim.pause": {"summary": "Pauses; in lockstep once the newest HIL_SENSOR has been answered.", "params": {}, "result": "SimStatus"},
  "sim.resume": {"summary": "Goes on.", "params": {}, "result": "SimStatus"},
  "sim.step": {"summary": "Pauses, makes steps, and answers after the last.", "params": {"n?": "integer: from 1"}, "result": "SimStatus"},
  "sim.run_until": {"summary": "Runs to a simulated time and pauses there; answered when it is reached.",
    "params": {"time_s": "number: since the start"}, "result": "SimStatus"},
  "sim.reset": {"summary": "Back to time zero: the same seed, the same run.", "params": {}, "result": "SimStatus"},
  "sim.phase": {"summary": "Tells the plugins what the flight is about.", "params": {"name": "string"}, "result": "SimStatus"},
  "sim.fault": {"summary": "A fault that begins with the next step, for a vehicle whose plugin fault has by_hand.",
    "params": {"vehicle": "string: its name", "fault": "any: as an entry of the plugin's faults, without at_s and when"}, "result": "boolean: true"},
  "sim.journal": {"summary": "The newest calls and signals that changed the run, the oldest first.", "params": {}, "result": "SimJournal"},
  "sim.stats": {"summary": "Figures of the run and of each plugin.", "params": {}, "result": "SimStats"},
  "sim.scene": {"summary": "What there is, as the physics has it: shapes, rotors, beams.", "params": {}, "result": "Scene"},
  "sim.mesh": {"summary": "A mesh of the scene, in pieces: counts of vertices and triangles (uint32), vertices (float32), indices (uint32).",
    "params": {"hash": "string: 64 hexadecimal digits", "offset?": "integer: bytes"}, "result": "MeshPiece"},
  "sim.watch": {"summary": "The newest motion, rounded for a picture; sampled 60 times a second at most, however many ask.", "params": {}, "result": "Motion"},
  "sim.clouds": {"summary": "The newest scan of each lidar for a picture: at most 1500 returns of it.", "params": {}, "result": "Clouds"},
  "sim.quit": {"summary": "Ends the run in good order.", "params": {}, "result": "SimStatus"}
}
})json";

}  // namespace

base::rpc::Description control_description(std::string version) {
  return {kText, std::move(version)};
}

}  // namespace cas::sim
