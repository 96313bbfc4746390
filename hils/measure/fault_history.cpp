// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/fault_history.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace cas::hils {

namespace {

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

}  // namespace cas::hils
