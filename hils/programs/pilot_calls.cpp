// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/pilot_calls.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/angles.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using mavlink::common::MavVtolState;

/// The client of this program's calls, in the journal of the program that is asked.
std::string introduce(base::rpc::Client& client) {
  return client.call("introduce", {{"name", fmt::format("hils-{}", ::getpid())}})
      .get<std::string>();
}

/// Adds the vehicle's newest text about its fence: ArduCopter's is a notice.
void add_fence_words(const Json& state, VehicleReport& report) {
  for (const Json& said : state.value("statustexts", Json::array())) {
    const std::string text = said.value("text", "");
    if (!tells_of_breach(text)) continue;
    report.fence_words = text;
    report.fence_words_age_s = said.value("age_s", 0.0);
  }
}

/// Adds the vehicle's newest text that is at least a warning; old ones do not count.
void add_warning(const Json& state, VehicleReport& report) {
  constexpr double kLately_s = 5;
  constexpr double kRepeated_s = 31;  // ArduPilot says every 30 s what its arming checks lack
  const double oldest_s = report.position_lack ? kRepeated_s : kLately_s;
  for (const Json& said : state.value("statustexts", Json::array())) {
    const std::string severity = said.value("severity", "");
    const bool harmless = severity == "notice" || severity == "info" || severity == "debug";
    if (!harmless && said.value("age_s", 0.0) < oldest_s) report.warning = said.value("text", "");
  }
}

}  // namespace

VehicleReport to_report(const nlohmann::json& state) {
  VehicleReport report;
  report.heard = true;
  report.heartbeat_age_s = state.value("heartbeat_age_s", 0.0);
  report.firmware = state.value("firmware", "");
  report.autopilot = state.value("autopilot", "");
  report.type = state.value("type", "");
  report.vtol = state.value("vtol", "");
  report.hil = state.value("hil", false);
  report.armed = state.value("armed", false);
  report.mode = state.value("mode", "");
  const std::string landed = state.value("landed", "");
  report.in_air = landed == "in_air";
  report.on_ground = landed == "on_ground";
  if (const auto lack = state.find("position_lacks"); lack != state.end()) {
    report.position_lack = lack->get<std::string>();
  }
  if (const auto p = state.find("position_N"); p != state.end() && p->is_object()) {
    report.has_position = true;
    report.position_age_s = p->value("age_s", 0.0);
    report.p_N = {p->value("x_m", 0.0), p->value("y_m", 0.0), p->value("z_m", 0.0)};
    report.v_N = {p->value("vx_m_s", 0.0), p->value("vy_m_s", 0.0), p->value("vz_m_s", 0.0)};
  }
  if (const auto a = state.find("attitude"); a != state.end() && a->is_object()) {
    report.roll_rad = a->value("roll_rad", 0.0);
    report.pitch_rad = a->value("pitch_rad", 0.0);
    report.yaw_rad = a->value("yaw_rad", 0.0);
  }
  add_warning(state, report);
  add_fence_words(state, report);
  return report;
}

namespace {

Json gain_params(const FlightStep& step) {
  Json params{{"loop", step.loop}};
  if (step.p) params["p"] = *step.p;
  if (step.i) params["i"] = *step.i;
  if (step.d) params["d"] = *step.d;
  return params;
}

std::vector<CasdCall> param_calls(const FlightStep& step) {
  std::vector<CasdCall> calls;
  for (const auto& [name, value] : step.params) {
    calls.emplace_back("param.set", Json{{"name", name}, {"value", value}});
  }
  return calls;
}

std::vector<CasdCall> calls_of(const FlightStep& step, std::string_view autopilot) {
  switch (step.kind) {
    case StepKind::kArm:
      return {{"vehicle.arm", Json::object()}};
    case StepKind::kTakeoff:
      return {{"vehicle.takeoff", {{"altitude_m", step.altitude_m}}}};
    case StepKind::kGoto:
      return {{"vehicle.goto",
               {{"north_m", step.place_m.x()},
                {"east_m", step.place_m.y()},
                {"down_m", -step.place_m.z()},
                {"yaw_deg", step.yaw_rad * base::kDegPerRad}}}};
    case StepKind::kLoiter:
      return {{"vehicle.goto",
               {{"north_m", step.place_m.x()},
                {"east_m", step.place_m.y()},
                {"down_m", -step.place_m.z()},
                {"radius_m", step.radius_m}}}};
    case StepKind::kTransition:
      if (autopilot == "ArduPilot") {  // which takes the command in its mode AUTO only
        return {{"vehicle.mode", {{"mode", step.to_plane ? "LOITER" : "QLOITER"}}}};
      }
      return {{"vehicle.command",
               {{"command", static_cast<int>(mavlink::common::MavCmd::kDoVtolTransition)},
                {"params",
                 {static_cast<int>(step.to_plane ? MavVtolState::kFw : MavVtolState::kMc)}}}}};
    case StepKind::kSetGain:
      return {{"gain.set", gain_params(step)}};
    case StepKind::kEndTrajectory:
      if (step.sticks) return {{"vehicle.mode", {{"mode", "HOLD"}}}};
      return param_calls(step);
    case StepKind::kSetParam:
    case StepKind::kTrajectory:
      return param_calls(step);
    case StepKind::kSticks:
      return {{"vehicle.mode", {{"mode", "POSCTL"}}}};
    case StepKind::kLand:
      return {{"vehicle.land", Json::object()}};
    case StepKind::kRtl:
      return {{"vehicle.rtl", Json::object()}};
    case StepKind::kDisarm:
      return {{"vehicle.disarm", Json::object()}};
    case StepKind::kMission:  // needs more than casd: hils/firmware
    case StepKind::kBreach:
    case StepKind::kReboot:
    case StepKind::kHold:
    case StepKind::kWaitUntil:
    case StepKind::kStandBy:
      break;
  }
  return {};
}

/// What stops a vehicle takes no consent.
bool takes_consent(StepKind kind) {
  return kind != StepKind::kLand && kind != StepKind::kRtl && kind != StepKind::kDisarm;
}

/// Arming, another mode and arming again: longer than casd takes to give all three up.
constexpr base::Duration kCommandPatience = std::chrono::seconds(20);

}  // namespace

base::rpc::Client connect(const std::string& address) {
  base::rpc::Client client(address);
  introduce(client);
  return client;
}

VehicleReport vehicle_report(base::rpc::Client& casd, AskedVehicle vehicle) {
  try {
    return to_report(casd.call("vehicle.state", about(vehicle, Json::object())));
  } catch (const base::rpc::CallError& error) {
    if (error.code() == base::rpc::kNoSuchVehicle) return {};  // not heard yet
    throw;
  }
}

nlohmann::json about(AskedVehicle vehicle, nlohmann::json params) {
  if (vehicle) params["vehicle"] = *vehicle;
  return params;
}

std::vector<CasdCall> step_calls(const FlightStep& step, bool not_hil, AskedVehicle vehicle,
                                 std::string_view autopilot) {
  std::vector<CasdCall> calls = calls_of(step, autopilot);
  for (auto& [method, params] : calls) {
    if (not_hil && takes_consent(step.kind)) params["not_hil"] = true;
    params = about(vehicle, std::move(params));
  }
  return calls;
}

std::optional<Refusal> give(base::rpc::Client& casd, const FlightStep& step, bool not_hil,
                            AskedVehicle vehicle, std::string_view autopilot) {
  try {
    for (const auto& [method, params] : step_calls(step, not_hil, vehicle, autopilot)) {
      casd.call(method, params, kCommandPatience);
    }
    return std::nullopt;
  } catch (const base::rpc::CallError& error) {
    return Refusal{error.what()};
  }
}

std::vector<OutsideCall> read_outside_calls(base::rpc::Client& casd) {
  return outside_calls(casd.call("casd.journal", Json::object()), introduce(casd));
}

std::vector<OutsideCall> read_simulator_calls(base::rpc::Client& simulator) {
  constexpr const char* kPort = "hilsim's control socket";
  const Json journal = simulator.call("sim.journal", Json::object());
  std::vector<OutsideCall> calls = outside_calls(journal, introduce(simulator), kPort);
  if (auto older = forgotten_calls(journal, kPort)) calls.insert(calls.begin(), std::move(*older));
  return calls;
}

}  // namespace cas::hils
