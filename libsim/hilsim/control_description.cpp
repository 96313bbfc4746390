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
  "SimStatus": {"time_s": "number: simulated", "steps": "integer", "paused": "boolean", "pace": "string: realtime, lockstep, free_run",
    "real_time_factor": "number", "late_steps": "integer", "lockstep_timeouts": "integer", "vehicles": ["VehicleTruth"]},
  "Distribution": {"p50": "number: us", "p99": "number: us", "max": "number: us", "count": "integer",
    "histogram": ["any: [upper end in us, entries]"]},
  "SimStats": {"schema": "integer", "program": "string", "time_s": "number: simulated", "steps": "integer", "wall_s": "number",
    "real_time_factor": "number", "late_steps": "integer", "lockstep_timeouts": "integer", "given_up_s": "number",
    "step_us": "Distribution", "lateness_us": "Distribution", "plugins": {"*": "any"}}
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
  "sim.stats": {"summary": "Figures of the run and of each plugin.", "params": {}, "result": "SimStats"},
  "sim.quit": {"summary": "Ends the run in good order.", "params": {}, "result": "SimStatus"}
}
})json";

}  // namespace

base::rpc::Description control_description(std::string version) {
  return {kText, std::move(version)};
}

}  // namespace cas::sim
