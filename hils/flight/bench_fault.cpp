// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/bench_fault.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <utility>

#include "base/suggestion.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::hils {

namespace {

using base::ConfigNode;

constexpr double kLongestRun_s = 1e6;
constexpr double kLongestUnplug_s = 3600;
/// An autopilot that is silent for 30 s ends the run.
constexpr double kLongestPause_s = 20;
constexpr std::array<std::string_view, 9> kBenchKeys{
    "line", "unplug", "restart", "flood_hz", "silence", "starve", "reload", "pause", "cut"};

void expect_word(const ConfigNode& node, std::string_view word) {
  if (node.as<std::string>() != word) node.fail("takes only " + std::string(word));
}

BenchFaultKind parse_kind(const ConfigNode& node, std::string_view key, const ConfigNode& line) {
  const ConfigNode value = node.at(key);
  if (key == "line") return LineFault{fcu::LineConfig::parse(value.merged_over(line))};
  if (key == "flood_hz") return FloodFault{node.require_in(key, 1, 100'000)};
  if (key == "unplug") {
    expect_word(value, "fcu");
    return UnplugFault{};
  }
  if (key == "silence") {
    const auto word = value.as<std::string>();
    if (word != "ground" && word != "sticks") value.fail("takes only ground or sticks");
    return SilenceFault{.sticks = word == "sticks"};
  }
  if (key == "cut") return CutFault{value.as<std::string>()};
  if (key == "pause") {
    expect_word(value, "hilsim");
    return PauseFault{base::from_seconds(node.require_in("for_s", 0.001, kLongestPause_s))};
  }
  if (key == "starve") return StarveFault{parse_wake_up(value)};
  expect_word(value, "casd");
  if (key == "reload") return ReloadFault{};
  return RestartFault{};
}

BenchFault parse_bench_fault(const ConfigNode& node, std::string_view key, const ConfigNode& line) {
  BenchFault fault;
  fault.kind = parse_kind(node, key, line);
  fault.name = node.get<std::string>("name", std::string(key));
  fault.when = parse_condition(node, "when");
  if (node.has("at_s")) {
    fault.at = base::SimTime(base::from_seconds(node.require_in("at_s", 0, kLongestRun_s)));
  }
  if (fault.at.has_value() == fault.when.has_value()) node.fail("needs at_s or when, not both");
  const double longest =
      std::holds_alternative<UnplugFault>(fault.kind) ? kLongestUnplug_s : kLongestRun_s;
  fault.lasting = base::from_seconds(node.require_in("for_s", 0.001, longest));
  if (std::holds_alternative<PauseFault>(fault.kind)) fault.lasting = {};
  for (const std::string_view other : kBenchKeys) {
    if (other != key && node.has(other)) {
      node.at(other).fail("is a second effect; give each its own entry");
    }
  }
  return fault;
}

std::optional<std::string_view> bench_key(const ConfigNode& node) {
  for (const std::string_view key : kBenchKeys) {
    if (node.has(key)) return key;
  }
  return std::nullopt;
}

/// Parses as the plugin does, for its errors. A kind unknown to it may be a misspelt fault of the
/// bench.
void read_as_plugin(const ConfigNode& node, std::size_t number) {
  try {
    sim::parse_fault(node, number);
  } catch (const base::ConfigError&) {
    for (const auto& [key, value] : node.entries()) {
      const std::string meant = base::did_you_mean(key, kBenchKeys);
      if (!meant.empty()) value.fail("there is no such fault" + meant);
    }
    throw;
  }
}

/// Every vehicle has a line of its own, and its own condition.
void add_bench_fault(BenchFault fault, std::optional<std::size_t> vehicle, std::size_t vehicles,
                     std::vector<BenchFault>& faults) {
  if (vehicle || fault.is_everybodys()) {
    fault.vehicle = vehicle.value_or(0);
    faults.push_back(std::move(fault));
    return;
  }
  for (fault.vehicle = 0; fault.vehicle < vehicles; ++fault.vehicle) faults.push_back(fault);
}

}  // namespace

WakeUpFigures parse_wake_up(const ConfigNode& node) {
  WakeUpFigures figures;
  figures.p50_us = node.require_in("p50_us", 0, 1e6);
  figures.p99_us = node.require_in("p99_us", figures.p50_us, 1e6);
  return figures;
}

bool BenchFault::is_everybodys() const {
  return !std::holds_alternative<LineFault>(kind) && !std::holds_alternative<UnplugFault>(kind);
}

ScenarioFaults parse_scenario_faults(const ConfigNode& faults, const ConfigNode& line,
                                     const VehicleNames& names) {
  if (!faults.is_list()) faults.fail("faults is a list");
  ScenarioFaults result;
  for (const ConfigNode& node : faults.items()) {
    if (!node.is_map()) node.fail("a fault is a map, such as '{at_s: 20, for_s: 5, drop: gps}'");
    const std::optional<std::size_t> vehicle = parse_vehicle_key(node, names);
    if (const auto key = bench_key(node)) {
      add_bench_fault(parse_bench_fault(node, *key, line), vehicle, names.size(), result.bench);
    } else {
      read_as_plugin(node, result.vehicle.size() + 1);
      result.vehicle.push_back({.script = node, .vehicle = vehicle});
    }
  }
  return result;
}

void refuse_faults(const ConfigNode& faults, std::span<const std::string_view> keys,
                   const std::string& why) {
  for (const ConfigNode& node : faults.items()) {
    for (const std::string_view key : keys) {
      if (node.is_map() && node.has(key)) node.at(key).fail(why);
    }
  }
}

std::vector<VehicleFault> ScenarioFaults::of_vehicle(std::size_t number) const {
  std::vector<VehicleFault> own;
  std::ranges::copy_if(vehicle, std::back_inserter(own), [number](const VehicleFault& fault) {
    return fault.vehicle.value_or(number) == number;
  });
  return own;
}

BenchFaultScript::BenchFaultScript(std::vector<BenchFault> faults) {
  for (BenchFault& fault : faults) add(std::move(fault));
}

void BenchFaultScript::add(BenchFault fault) {
  entries_.push_back({.fault = std::move(fault), .span = std::nullopt, .over = false});
}

void BenchFaultScript::add_begun(BenchFault fault, base::SimTime now) {
  add(std::move(fault));
  note_begin(entries_.back(), now);
}

void BenchFaultScript::note_begin(Entry& entry, base::SimTime now) {
  entry.span = history_.size();
  history_.push_back({.name = entry.fault.name, .begin = now, .end = std::nullopt});
  if (!entry.fault.is_everybodys()) history_.back().vehicle = entry.fault.vehicle;
}

bool BenchFaultScript::line_is_faulty(std::size_t vehicle) const {
  return std::ranges::any_of(entries_, [vehicle](const Entry& entry) {
    return entry.span && !entry.over && !entry.fault.is_everybodys() &&
           entry.fault.vehicle == vehicle;
  });
}

const LineFault* BenchFaultScript::line_of(std::size_t vehicle) const {
  const Entry* newest = nullptr;
  for (const Entry& entry : entries_) {
    if (!entry.span || entry.over || entry.fault.vehicle != vehicle) continue;
    if (!std::holds_alternative<LineFault>(entry.fault.kind)) continue;
    if (newest == nullptr || *entry.span > *newest->span) newest = &entry;
  }
  return newest == nullptr ? nullptr : std::get_if<LineFault>(&newest->fault.kind);
}

std::vector<BenchFaultScript::Event> BenchFaultScript::update(
    base::SimTime now, std::span<const VehicleReport> vehicles, std::string_view phase) {
  std::vector<Event> events;
  for (Entry& entry : entries_) {
    if (!entry.span && is_due(entry.fault, now, vehicles, phase)) {
      note_begin(entry, now);
      events.push_back({.fault = &entry.fault, .begins = true});
    } else if (entry.span && !entry.over &&
               now - history_[*entry.span].begin >= entry.fault.lasting) {
      entry.over = true;
      history_[*entry.span].end = now;
      events.push_back({.fault = &entry.fault, .begins = false});
    }
  }
  return events;
}

std::vector<BenchFaultScript::Span> BenchFaultScript::history_of(std::size_t vehicle) const {
  std::vector<Span> spans;
  std::ranges::copy_if(history_, std::back_inserter(spans), [vehicle](const Span& span) {
    return span.vehicle.value_or(vehicle) == vehicle;
  });
  return spans;
}

bool BenchFaultScript::is_due(const BenchFault& fault, base::SimTime now,
                              std::span<const VehicleReport> vehicles, std::string_view phase) {
  if (fault.at) return now >= *fault.at;
  const VehicleReport& vehicle = vehicles[fault.vehicle];
  if (fault.when->on_truth && !vehicle.truth) return false;
  const Motion motion = fault.when->on_truth ? *vehicle.truth : vehicle.estimate();
  return fault.when->expression.evaluate(facts_of(now, motion, vehicle.armed, phase));
}

}  // namespace cas::hils
