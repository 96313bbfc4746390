// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/flown_simulator.hpp"

#include <chrono>
#include <nlohmann/json.hpp>

#include "hils/programs/pilot_calls.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;

/// For a stretch of the stream in lockstep, on a machine that may be very busy.
constexpr base::Duration kRunPatience = std::chrono::seconds(120);

Eigen::Vector3d vector_of(const Json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

/// Motion of a vehicle in sim.status, whose axes are W's: x east, y north.
Motion to_motion(const Json& vehicle) {
  const Eigen::Vector3d p_W = vector_of(vehicle.at("p_W"));
  const Eigen::Vector3d v_W = vector_of(vehicle.at("v_W"));
  return {.p_m = {p_W.y(), p_W.x(), p_W.z()},
          .v_m_s = {v_W.y(), v_W.x(), v_W.z()},
          .rpy_rad = vector_of(vehicle.at("rpy_ND_rad"))};
}

}  // namespace

FlownSimulator::FlownSimulator(const std::filesystem::path& control)
    : client_(connect("unix:" + control.string())) {}

base::SimTime FlownSimulator::look() { return take(client_.call("sim.status", Json::object())); }

base::SimTime FlownSimulator::run_until(base::SimTime time) {
  return take(client_.call("sim.run_until", {{"time_s", base::to_seconds(time)}}, kRunPatience));
}

void FlownSimulator::tell_phase(std::string_view phase) {
  client_.call("sim.phase", {{"name", phase}});
}

base::SimTime FlownSimulator::take(const Json& status) {
  status_ = {.time = base::SimTime(base::from_seconds(status.at("time_s").get<double>())),
             .real_time_factor = status.value("real_time_factor", 0.0),
             .late_steps = status.value("late_steps", std::uint64_t{0}),
             .lockstep_timeouts = status.value("lockstep_timeouts", std::uint64_t{0}),
             .paused = status.value("paused", false),
             .truth = {}};
  for (const Json& vehicle : status.at("vehicles")) {
    Motion& truth = status_.truth.emplace_back(to_motion(vehicle));
    if (start_m_.size() < status_.truth.size()) start_m_.push_back(truth.p_m);
    truth.p_m -= start_m_[status_.truth.size() - 1];
  }
  return status_.time;
}

}  // namespace cas::hils
