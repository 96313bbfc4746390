// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/sim_report.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "base/earth/frames.hpp"
#include "base/os/write_file.hpp"

namespace cas::sim {

namespace {

using Json = nlohmann::json;

constexpr int kStatsSchema = 1;

/// Quantiles and the distribution: [upper end, entries below it and not below the bin before].
Json histogram_us(const base::Histogram& histogram) {
  const auto us = [](base::Duration d) { return 1e6 * base::to_seconds(d); };
  Json bins = Json::array();
  for (const auto& [upper, count] : histogram.octaves()) bins.push_back({us(upper), count});
  return {{"p50", us(histogram.quantile(0.5))},
          {"p99", us(histogram.quantile(0.99))},
          {"max", us(histogram.max())},
          {"count", histogram.count()},
          {"histogram", std::move(bins)}};
}

const char* to_string(PaceMode mode) {
  switch (mode) {
    case PaceMode::kRealtime:
      return "realtime";
    case PaceMode::kLockstep:
      return "lockstep";
    case PaceMode::kFreeRun:
      return "free_run";
  }
  return "";
}

Json to_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json vehicle_status(const std::string& name, const World& world, VehicleId id) {
  const BodyState& state = world.state(id);
  const auto& q = state.q_WB;
  return {{"name", name},
          {"p_W", to_json(state.p_WB)},
          {"v_W", to_json(state.v_WB)},
          {"q_WB", {q.w(), q.x(), q.y(), q.z()}},
          {"w_B", to_json(state.w_WB_B)},
          {"rpy_ND_rad", to_json(base::euler_rpy(base::q_ND_from_q_WB(q)))},
          {"in_contact", world.in_contact(id)}};
}

}  // namespace

Json plugin_figures(const SimRunner& runner) {
  Json plugins = Json::object();
  for (const PluginFigures& figures : runner.plugin_figures()) {
    Json parsed = Json::parse(figures.json, nullptr, false);
    plugins[figures.name] = parsed.is_discarded() ? Json(figures.json) : std::move(parsed);
  }
  return plugins;
}

Json warnings_report(const SimRunner& runner) {
  Json warnings = Json::array();
  for (const SimWarning& each : runner.warnings()) {
    warnings.push_back({{"vehicle", each.vehicle}, {"warning", each.sentence}});
  }
  return warnings;
}

Json status_report(const SimLoop& loop) {
  const SimRunner& runner = loop.runner();
  const LoopFigures f = loop.figures();
  Json vehicles = Json::array();
  const auto names = runner.vehicle_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    vehicles.push_back(vehicle_status(names[i], runner.world(), static_cast<VehicleId>(i)));
  }
  return {{"time_s", base::to_seconds(f.time)},
          {"steps", f.steps},
          {"paused", f.paused},
          {"pace", to_string(runner.config().pace.mode)},
          {"real_time_factor", f.real_time_factor},
          {"late_steps", f.late_steps},
          {"lockstep_timeouts", f.lockstep_timeouts},
          {"vehicles", std::move(vehicles)}};
}

Json stats_report(const SimLoop& loop) {
  const LoopFigures f = loop.figures();
  return {{"schema", kStatsSchema},
          {"program", "hilsim"},
          {"time_s", base::to_seconds(f.time)},
          {"steps", f.steps},
          {"wall_s", f.wall_s},
          {"real_time_factor", f.real_time_factor},
          {"late_steps", f.late_steps},
          {"lockstep_timeouts", f.lockstep_timeouts},
          {"given_up_s", f.given_up_s},
          {"step_us", histogram_us(loop.step_times())},
          {"lateness_us", histogram_us(loop.lateness())},
          {"plugins", plugin_figures(loop.runner())},
          {"warnings", warnings_report(loop.runner())}};
}

std::string endpoints_report(const SimRunner& runner) {
  std::string text;
  const Json plugins = plugin_figures(runner);
  for (const Json& figures : plugins) {
    if (!figures.is_object() || !figures.contains("endpoint")) continue;
    if (!text.empty()) text.append(" ");
    text.append(figures["endpoint"].is_string() ? figures["endpoint"].get<std::string>() : "?");
  }
  return text;
}

void write_report(const std::filesystem::path& file, const Json& report) {
  base::write_file(file, report.dump(2) + '\n', base::Durability::kCache);
}

}  // namespace cas::sim
