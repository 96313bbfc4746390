// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_simulator.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace cas::hils {

VirtualSimulator::VirtualSimulator(sim::SimConfig config, sim::SimOptions options,
                                   std::vector<OnBytes> on_bytes)
    : runner_(std::move(config), std::move(options)) {
  const std::vector<std::string> names = runner_.vehicle_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    wires_.push_back(std::make_unique<VirtualWire>(
        runner_.bus(), names[i], static_cast<sim::VehicleId>(i), std::move(on_bytes.at(i))));
  }
  runner_.start();
  for (const auto& wire : wires_) wire->start(runner_.world());
}

void VirtualSimulator::step(base::RunTime now) {
  for (const auto& wire : wires_) wire->deliver(now - runner_.step_size(), now);
  runner_.step();
}

void VirtualSimulator::set_flight_phase(std::string_view name) {
  if (name == phase_) return;
  phase_ = name;
  runner_.set_flight_phase(name);
}

base::RunTime VirtualSimulator::next_event() const {
  return base::RunTime((runner_.time() + runner_.step_size()).time_since_epoch());
}

std::string VirtualSimulator::stats_json() const {
  using Json = nlohmann::json;
  Json plugins = Json::object();
  for (const sim::PluginFigures& figures : runner_.plugin_figures()) {
    plugins[figures.name] = Json::parse(figures.json, nullptr, false);
  }
  const Json stats{{"schema", 1},
                   {"program", "hilsim"},
                   {"time_s", base::to_seconds(runner_.time())},
                   {"steps", runner_.steps()},
                   {"plugins", std::move(plugins)}};
  return stats.dump(2) + "\n";
}

}  // namespace cas::hils
