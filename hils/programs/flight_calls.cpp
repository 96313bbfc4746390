// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/flight_calls.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace cas::hils {

using Json = nlohmann::json;

namespace {

Eigen::Vector3d vector_of(const Json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

}  // namespace

Motion to_motion(const Json& vehicle) {
  const Eigen::Vector3d p_W = vector_of(vehicle.at("p_W"));
  const Eigen::Vector3d v_W = vector_of(vehicle.at("v_W"));
  return {.p_m = {p_W.y(), p_W.x(), p_W.z()},
          .v_m_s = {v_W.y(), v_W.x(), v_W.z()},
          .rpy_rad = vector_of(vehicle.at("rpy_ND_rad"))};
}

std::vector<Call> to_calls(const FlightStep& step) {
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
                {"yaw_deg", step.yaw_rad * 180.0 / M_PI}}}};
    case StepKind::kSetGain: {
      Json params{{"loop", step.loop}};
      if (step.p) params["p"] = *step.p;
      if (step.i) params["i"] = *step.i;
      if (step.d) params["d"] = *step.d;
      return {{"gain.set", params}};
    }
    case StepKind::kSetParam:
    case StepKind::kTrajectory:
    case StepKind::kEndTrajectory: {
      std::vector<Call> calls;
      for (const auto& [name, value] : step.params) {
        calls.emplace_back("param.set", Json{{"name", name}, {"value", value}});
      }
      return calls;
    }
    case StepKind::kLand:
      return {{"vehicle.land", Json::object()}};
    case StepKind::kDisarm:
      return {{"vehicle.disarm", Json::object()}};
    case StepKind::kHold:
    case StepKind::kWaitUntil:
    case StepKind::kStandBy:
      break;
  }
  return {};
}

}  // namespace cas::hils
