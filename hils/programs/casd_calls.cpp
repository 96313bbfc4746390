// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/casd_calls.hpp"

#include <nlohmann/json.hpp>

#include "hils/programs/flight_calls.hpp"

namespace cas::hils {

using base::rpc::Json;

namespace {

VehicleReport to_report(const Json& state) {
  VehicleReport report;
  report.heard = true;
  report.armed = state.value("armed", false);
  const std::string landed = state.value("landed", "");
  report.in_air = landed == "in_air";
  report.on_ground = landed == "on_ground";
  if (const auto p = state.find("position_N"); p != state.end() && p->is_object()) {
    report.has_position = true;
    report.p_N = {p->value("x_m", 0.0), p->value("y_m", 0.0), p->value("z_m", 0.0)};
    report.v_N = {p->value("vx_m_s", 0.0), p->value("vy_m_s", 0.0), p->value("vz_m_s", 0.0)};
  }
  if (const auto a = state.find("attitude"); a != state.end() && a->is_object()) {
    report.roll_rad = a->value("roll_rad", 0.0);
    report.pitch_rad = a->value("pitch_rad", 0.0);
    report.yaw_rad = a->value("yaw_rad", 0.0);
  }
  return report;
}

/// The parameters of a call that means this vehicle.
Json to(AskedVehicle vehicle, Json params) {
  if (vehicle) params["vehicle"] = *vehicle;
  return params;
}

}  // namespace

VehicleReport vehicle_report(base::rpc::Client& casd, AskedVehicle vehicle) {
  try {
    return to_report(casd.call("vehicle.state", to(vehicle, Json::object())));
  } catch (const base::rpc::CallError& error) {
    if (error.code() == base::rpc::kNoSuchVehicle) return {};  // not heard yet
    throw;
  }
}

std::string give(base::rpc::Client& casd, const FlightStep& step, bool not_hil,
                 AskedVehicle vehicle) {
  try {
    for (auto& [method, params] : to_calls(step)) {
      if (step.kind == StepKind::kArm && not_hil) params["not_hil"] = true;
      casd.call(method, to(vehicle, params));
    }
    return {};
  } catch (const base::rpc::CallError& error) {
    return error.what();
  }
}

}  // namespace cas::hils
