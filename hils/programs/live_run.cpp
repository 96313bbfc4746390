// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/live_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/time/unix_time.hpp"
#include "hils/measure/check_json.hpp"
#include "hils/programs/hand_fault.hpp"

namespace cas::hils {

namespace {

using Json = nlohmann::json;

constexpr base::Duration kStatusPeriod = std::chrono::milliseconds(500);
constexpr base::Duration kCallsPeriod = std::chrono::seconds(1);
constexpr double kShortestFault_s = 0.05;
constexpr double kLongestFault_s = 30;
constexpr std::size_t kMostTouched = 20;  // acts that are listed

/// In W: x east, y north, z up.
Json in_W(const Pose& pose, const Eigen::Vector3d& start_m) {
  return {pose.y_m + start_m.y(), pose.x_m + start_m.x(), pose.z_m + start_m.z()};
}

/// Velocity of the reference, so that a page knows it between two looks.
Json velocity_W(const Stage& stage, std::int64_t now_us) {
  constexpr std::int64_t kHalf_us = 5'000;
  const Pose before = reference_at(stage, now_us - kHalf_us);
  const Pose after = reference_at(stage, now_us + kHalf_us);
  constexpr double kPer_s = 1e6 / (2.0 * kHalf_us);
  return {kPer_s * (after.y_m - before.y_m), kPer_s * (after.x_m - before.x_m),
          kPer_s * (after.z_m - before.z_m)};
}

Json stage_json(const Stage& stage) {
  return {{"name", phase_of(stage.step)},
          {"begin_s", base::to_seconds(stage.begin)},
          {"end_s", base::to_seconds(stage.end)},
          {"measured", stage.step.measure}};
}

Json stages_json(const FlightPlan& plan, base::SimTime now) {
  std::vector<Stage> stages = plan.stages();
  if (const auto stage = plan.under_way(now)) stages.push_back(*stage);
  Json list = Json::array();
  for (const Stage& stage : stages) {
    if (stage.step.kind != StepKind::kEndTrajectory) list.push_back(stage_json(stage));
  }
  return list;
}

/// Kinds of faults that this bench can have, for the page's buttons.
Json fault_kinds(const Scenario& scenario, bool has_line) {
  Json kinds{"drop", "rotor"};
  if (has_line) kinds.push_back("unplug");
  const auto is_wind = [](const base::ConfigNode& plugin) {
    return plugin.at("plugin").as<std::string>() == "wind";
  };
  if (std::ranges::any_of(scenario.plugins, is_wind)) kinds.push_back("gust");
  return {{"kinds", std::move(kinds)},
          {"shortest_s", kShortestFault_s},
          {"longest_s", kLongestFault_s}};
}

bool is_line_fault(const BenchFault& fault) {
  return std::holds_alternative<LineFault>(fault.kind) ||
         std::holds_alternative<UnplugFault>(fault.kind);
}

}  // namespace

struct LiveRun::Shown {
  Json touched = Json::array();  ///< acts of others
  Json status;
};

LiveRun::LiveRun() : shown_(std::make_unique<Shown>()) {}
LiveRun::~LiveRun() { tell_end("hils ended without a verdict"); }

void LiveRun::start(const RunRequest& request, const RunPaths& paths,
                    const Supervisor& supervisor) {
  request_ = &request;
  so_far_.resize(request.scenario.vehicles.size());
  for (const VehiclePaths& vehicle : paths.vehicles) {
    emulated_.push_back(std::filesystem::exists(vehicle.fcu_control()));
  }
  try {
    port_ = std::make_unique<RunPort>(paths.run_port());
  } catch (const std::exception& error) {
    fmt::print(stderr, "hils: the run goes on without a page: {}\n", error.what());
    return;
  }
  const bool has_line = std::ranges::find(emulated_, true) != emulated_.end();
  port_->show("fault.list", fault_kinds(request.scenario, has_line));
  web_.emplace(paths, supervisor);
}

void LiveRun::look(base::SimTime now, const FleetPlan& plan,
                   std::span<const VehicleReport> vehicles,
                   std::span<const Eigen::Vector3d> start_m) {
  if (!port_) return;
  for (std::size_t i = 0; i < so_far_.size(); ++i) {
    if (const auto stage = plan.plan(i).under_way(now)) so_far_[i].add(*stage, now, vehicles[i]);
  }
  port_->show("run.reference", reference(now, plan, start_m));
  if (base::steady_now() < next_status_) return;
  next_status_ = base::steady_now() + kStatusPeriod;
  shown_->status = status(now, plan);
  port_->show("run.status", shown_->status);
}

Json LiveRun::reference(base::SimTime now, const FleetPlan& plan,
                        std::span<const Eigen::Vector3d> start_m) const {
  const auto now_us = static_cast<std::int64_t>(base::to_time_usec(now));
  Json vehicles = Json::array();
  for (std::size_t i = 0; i < so_far_.size(); ++i) {
    const auto stage = reference_stage(plan.plan(i), now);
    if (!stage) {
      vehicles.push_back(nullptr);
      continue;
    }
    const Pose pose = reference_at(*stage, now_us);
    vehicles.push_back({{"p_W", in_W(pose, start_m[i])},
                        {"v_W", velocity_W(*stage, now_us)},
                        {"yaw_rad", pose.yaw_rad}});
  }
  return {{"t_s", base::to_seconds(now)}, {"v", std::move(vehicles)}};
}

Json LiveRun::status(base::SimTime now, const FleetPlan& plan) const {
  const Scenario& scenario = request_->scenario;
  Json vehicles = Json::array();
  for (std::size_t i = 0; i < so_far_.size(); ++i) {
    vehicles.push_back({{"name", scenario.vehicles[i].name},
                        {"system", scenario.vehicles[i].system_id},
                        {"checks", checks_json(so_far_[i].checks(scenario.limits_of(i)))}});
  }
  return {{"name", scenario.name},
          {"seed", request_->seed},
          {"state", "running"},
          {"sentences", Json::array()},
          {"touched", shown_->touched},
          {"stages", stages_json(plan.plan(plan.leader()), now)},
          {"vehicles", std::move(vehicles)}};
}

void LiveRun::show_calls(const std::vector<OutsideCall>& calls) {
  next_calls_ = base::steady_now() + kCallsPeriod;
  shown_->touched = Json::array();
  for (const OutsideCall& call : calls) {
    if (shown_->touched.size() == kMostTouched) return;
    if (!is_act(call)) continue;
    shown_->touched.push_back(
        {{"by", fmt::format("{} ({})", call.port, call.client)},
         {"what", call.method + (call.params == "{}" ? "" : " " + call.params)}});
  }
}

void LiveRun::play_faults(base::SimTime now, std::span<const VehicleReport> vehicles,
                          BenchFaultScript& faults, base::rpc::Client& simulator,
                          const BeginFault& begin) {
  if (!port_) return;
  for (const RunPort::FaultCall& call : port_->take_faults()) {
    Json result;
    std::optional<base::rpc::CallError> refusal;
    try {
      result = inject(Json::parse(call.params), now, vehicles, faults, simulator, begin);
    } catch (const base::rpc::CallError& error) {
      refusal = error;
    } catch (const Json::exception&) {
      refusal = base::rpc::BadParams("a parameter is missing, or is of another type");
    } catch (const base::ConfigError& error) {
      refusal = base::rpc::BadParams(error.what());
    }
    base::log::info(fmt::format("fault.inject {} by {}: {}", call.params, call.reply.client,
                                refusal ? refusal->what() : "done"));
    calls_.push_back({.log_us = base::unix_us(),
                      .client = call.reply.client,
                      .method = "fault.inject",
                      .params = call.params,
                      .system = 0,
                      .accepted = !refusal,
                      .port = "the page",
                      .sim_s = base::to_seconds(now)});
    next_calls_ = {};
    if (refusal) {
      port_->refuse(call, refusal->code(), refusal->what());
      continue;
    }
    port_->answer(call, result);
    port_->publish("fault", std::move(result));
  }
}

Json LiveRun::inject(const Json& params, base::SimTime now, std::span<const VehicleReport> vehicles,
                     BenchFaultScript& faults, base::rpc::Client& simulator,
                     const BeginFault& begin) {
  const Scenario& scenario = request_->scenario;
  const std::size_t i = vehicle_of_fault(params, scenario.systems(), vehicles);
  const double for_s = params.at("for_s").get<double>();
  if (!(for_s >= kShortestFault_s && for_s <= kLongestFault_s)) {
    throw base::rpc::BadParams(
        fmt::format("for_s is {:g} to {:g} s", kShortestFault_s, kLongestFault_s));
  }
  Json script = params;
  script.erase("vehicle");
  Json entry = script;
  entry["vehicle"] = scenario.vehicles[i].name;
  entry["at_s"] = base::to_seconds(now);
  const auto root = base::ConfigNode::parse(Json{{"faults", {entry}}}.dump(), "fault.inject");
  const ScenarioFaults parsed =
      parse_scenario_faults(root.at("faults"), scenario.line, scenario.names());
  root.reject_unused();
  for (const BenchFault& fault : parsed.bench) {
    if (!is_line_fault(fault)) {
      throw base::rpc::CallError(base::rpc::kRefused,
                                 "by hand the line breaks, not casd or a ground station");
    }
    if (!emulated_[i]) {
      throw base::rpc::CallError(base::rpc::kRefused,
                                 "a real controller's line is cut at its plug");
    }
    if (faults.line_is_faulty(i)) {
      throw base::rpc::CallError(base::rpc::kRefused,
                                 "a fault of this vehicle's line is under way: wait");
    }
    begin(fault);
    faults.add_begun(fault, now);
  }
  if (!parsed.vehicle.empty()) {
    const Json order{{"vehicle", scenario.vehicles[i].name}, {"fault", script}};
    simulator.call("sim.fault", order);
  }
  return {{"name", params.value("name", std::string("by hand"))},
          {"vehicle", scenario.vehicles[i].system_id},
          {"began_s", base::to_seconds(now)},
          {"ended_s", base::to_seconds(now) + for_s}};
}

bool LiveRun::page_has_ended() const { return web_ && web_->has_ended(); }

void LiveRun::resume(base::rpc::Client& simulator) { simulator.call("sim.resume", Json::object()); }

void LiveRun::tell_end(const std::string& sentence) {
  if (!port_ || std::exchange(told_, true)) return;
  Json verdict = shown_->status;
  if (!verdict.is_object()) {
    verdict = {{"name", request_->scenario.name},
               {"seed", request_->seed},
               {"touched", shown_->touched},
               {"stages", Json::array()},
               {"vehicles", Json::array()}};
  }
  verdict["state"] = "invalid";
  verdict["sentences"] = Json::array({sentence});
  port_->tell_verdict(std::move(verdict));
}

void LiveRun::tell(const RunResult& result) {
  if (!port_) return;
  told_ = true;
  Json verdict = shown_->status;
  verdict["state"] = !result.verdict.valid   ? "invalid"
                     : result.verdict.passed ? "passed"
                                             : "failed";
  verdict["sentences"] = result.verdict.failures;
  verdict["touched"] = shown_->touched;
  verdict["out"] = request_->out.string();
  verdict["vehicles"] = Json::array();
  for (const VehicleResult& vehicle : result.vehicles) {
    verdict["vehicles"].push_back({{"name", vehicle.record.vehicle},
                                   {"system", vehicle.record.system},
                                   {"checks", checks_json(vehicle.verdict.checks)}});
    if (!shown_->touched.empty() || !vehicle.figures.changes.from_outside()) continue;
    verdict["touched"] = {{{"by", "a ground station"}, {"what", "the report has it"}}};
  }
  port_->tell_verdict(std::move(verdict));
}

}  // namespace cas::hils
