// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "casd/station/vehicle_commander.hpp"

namespace cas::casd {

/// Requests that follow one another; the first that fails ends the chain.
struct VehicleCommander::Steps {
  std::vector<std::function<void(base::RunTime, Done)>> todo;
  std::size_t next = 0;
  Outcome total;
  Done done;
};

void VehicleCommander::run_steps(std::shared_ptr<Steps> steps) {
  if (!steps->total.ok() || steps->next == steps->todo.size()) {
    steps->done(steps->total);
    return;
  }
  const auto& step = steps->todo[steps->next++];
  step(now_, [this, steps](const Outcome& outcome) {
    steps->total.kind = outcome.kind;
    steps->total.message = outcome.message;
    for (const auto& [name, value] : outcome.parameters) steps->total.parameters[name] = value;
    for (const std::string& text : outcome.status_texts) steps->total.status_texts.push_back(text);
    run_steps(steps);
  });
}

void VehicleCommander::read_param(std::uint8_t system, const std::string& name, base::RunTime now,
                                  Done done) {
  now_ = now;
  if (Vehicle* vehicle = known(system, done)) vehicle->params.read(name, now, std::move(done));
}

void VehicleCommander::set_param(std::uint8_t system, const std::string& name, double value,
                                 base::RunTime now, Done done) {
  now_ = now;
  if (Vehicle* vehicle = known(system, done)) {
    vehicle->params.set(name, value, now, std::move(done));
  }
}

void VehicleCommander::list_params(std::uint8_t system, base::RunTime now, Done done) {
  now_ = now;
  if (Vehicle* vehicle = known(system, done)) vehicle->params.list(now, std::move(done));
}

std::optional<mavlink::common::MavParamType> VehicleCommander::param_type(
    std::uint8_t system, const std::string& name) const {
  const auto vehicle = vehicles_.find(system);
  if (vehicle == vehicles_.end()) return std::nullopt;
  const auto& known = vehicle->second->params.known();
  const auto found = known.find(name);
  if (found == known.end()) return std::nullopt;
  return found->second.type;
}

void VehicleCommander::set_gains(std::uint8_t system, const GainLoop& loop,
                                 const GainValues& values, base::RunTime now, Done done) {
  now_ = now;
  if (const std::optional<std::string> why = unsupported(loop, values)) {
    done(failure(OutcomeKind::kRefused, *why));
    return;
  }
  const auto steps = std::make_shared<Steps>();
  steps->done = std::move(done);
  const auto add = [&](const std::optional<std::string>& name, const std::optional<double>& value) {
    if (!name) return;
    steps->todo.push_back([this, system, name = *name, value](base::RunTime at, Done next) {
      if (value) {
        set_param(system, name, *value, at, std::move(next));
      } else {
        read_param(system, name, at, std::move(next));
      }
    });
  };
  add(loop.p, values.p);
  add(loop.i, values.i);
  add(loop.d, values.d);
  run_steps(steps);
}

void VehicleCommander::read_gains(std::uint8_t system, const GainLoop& loop, base::RunTime now,
                                  Done done) {
  set_gains(system, loop, GainValues{}, now, std::move(done));
}

}  // namespace cas::casd
