// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/run_record.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"

namespace cas::hils {

namespace {

using mavlink::common::HilActuatorControls;
using mavlink::common::HilControls;

using nlohmann::json;

void add_event(const json& event, std::vector<BenchFaultScript::Span>& faults) {
  const base::SimTime time(base::from_seconds(event.value("time_s", 0.0)));
  const auto name = event.value("fault", std::string());
  if (event.value("event", std::string()) == "begin") {
    faults.push_back({.name = name, .begin = time, .end = std::nullopt});
    return;
  }
  for (auto& fault : faults) {
    if (fault.name == name && !fault.end) fault.end = time;
  }
}

/// "fault@iris0", "fault@iris0#2": the plugins of one vehicle.
bool is_fault_of(const std::string& plugin, const std::string& vehicle) {
  return plugin.substr(0, plugin.find('#')) == "fault@" + vehicle;
}

bool is_plugin_of(const std::string& plugin, const std::string& vehicle) {
  const std::string_view name = std::string_view(plugin).substr(0, plugin.find('#'));
  return name.substr(std::min(name.find('@'), name.size())) == "@" + vehicle;
}

}  // namespace

std::vector<BenchFaultScript::Span> vehicle_faults(const std::filesystem::path& simulator_stats,
                                                   const std::string& vehicle) {
  std::vector<BenchFaultScript::Span> faults;
  std::ifstream in(simulator_stats);
  const json stats = json::parse(in, nullptr, false);
  if (!stats.is_object() || !stats.contains("plugins")) return faults;
  for (const auto& [plugin, figures] : stats["plugins"].items()) {
    if (!is_fault_of(plugin, vehicle) || !figures.is_object()) continue;
    for (const json& event : figures.value("events", json::array())) add_event(event, faults);
  }
  return faults;
}

std::vector<std::string> simulator_warnings(const std::filesystem::path& simulator_stats,
                                            const std::string& vehicle) {
  std::vector<std::string> warnings;
  std::ifstream in(simulator_stats);
  const json stats = json::parse(in, nullptr, false);
  if (!stats.is_object()) return warnings;
  for (const json& each : stats.value("warnings", json::array())) {
    const auto whose = each.value("vehicle", std::string());
    if (whose.empty() || whose == vehicle) warnings.push_back(each.value("warning", ""));
  }
  const json plugins = stats.value("plugins", json::object());  // outlives the view of its items
  for (const auto& [plugin, figures] : plugins.items()) {
    if (!is_plugin_of(plugin, vehicle) || !figures.is_object()) continue;
    for (const json& each : figures.value("warnings", json::array())) {
      if (each.is_string()) warnings.push_back(each.get<std::string>());
    }
  }
  return warnings;
}

std::vector<Stage> RunRecord::flown_stages() const {
  std::vector<Stage> flown = stages;
  if (under_way) flown.push_back(*under_way);
  return flown;
}

const std::vector<PoseSample>& RunRecord::truth() const {
  if (!truth_read) {
    truth_read = std::make_shared<const std::vector<PoseSample>>(read_truth(truth_csv));
  }
  return *truth_read;
}

const std::vector<PoseSample>& RunRecord::estimate() const {
  if (!estimate_read) {
    estimate_read = std::make_shared<const std::vector<PoseSample>>(
        read_estimate(flight_tlog, system, log_clock));
  }
  return *estimate_read;
}

std::vector<RunRecord> records_of(const Scenario& scenario, const RunPaths& paths) {
  std::vector<RunRecord> records;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    RunRecord& record = records.emplace_back();
    record.vehicle = scenario.vehicles[i].name;
    record.system = scenario.vehicles[i].system_id;
    record.truth_csv = paths.vehicles[i].truth_csv();
    record.clouds_csv = paths.vehicles[i].clouds_csv();
    record.sensors = paths.vehicles[i].sensors();
    record.flight_tlog = paths.flight_tlog();
    record.plugin_figures = paths.plugin_figures();
  }
  return records;
}

void add_simulator_report(const RunPaths& paths, RunRecord& record) {
  record.warnings = simulator_warnings(paths.simulator_stats(), record.vehicle);
  for (auto& fault : vehicle_faults(paths.simulator_stats(), record.vehicle)) {
    record.faults.push_back(std::move(fault));
  }
}

std::uint32_t controls_message_id(const RunRecord& record) {
  const bool outputs = std::ranges::any_of(record.controller, [](const base::LedgerEntry& entry) {
    return entry.message_id == HilActuatorControls::kId;
  });
  return outputs ? HilActuatorControls::kId : HilControls::kId;
}

}  // namespace cas::hils
