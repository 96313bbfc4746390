// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight_step.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace cas::hils {

namespace {

constexpr double kMaxStepSeconds = 86'400;
constexpr double kMaxDistanceM = 10'000;
constexpr double kRadiansPerDegree = M_PI / 180.0;

constexpr std::array<std::pair<StepKind, std::string_view>, 7> kWords{{
    {StepKind::kArm, "arm"},
    {StepKind::kTakeoff, "takeoff"},
    {StepKind::kGoto, "goto"},
    {StepKind::kHold, "hold"},
    {StepKind::kSetGain, "setgain"},
    {StepKind::kLand, "land"},
    {StepKind::kDisarm, "disarm"},
}};

StepKind parse_kind(const base::ConfigNode& node, std::string_view word) {
  for (const auto& [kind, name] : kWords) {
    if (name == word) return kind;
  }
  node.fail("there is no step '" + std::string(word) +
            "'; steps are arm, takeoff, goto, hold, setgain, land and disarm");
}

std::optional<double> optional_number(const base::ConfigNode& node, std::string_view key) {
  const std::optional<base::ConfigNode> child = node.find(key);
  if (!child) return std::nullopt;
  return child->as<double>();
}

void parse_goto(const base::ConfigNode& body, FlightStep& step) {
  step.place_m = {body.require_in("north_m", -kMaxDistanceM, kMaxDistanceM),
                  body.require_in("east_m", -kMaxDistanceM, kMaxDistanceM),
                  body.require_in("up_m", 0.5, kMaxDistanceM)};
  step.yaw_rad = body.get_in("yaw_deg", 0, -180, 180) * kRadiansPerDegree;
}

void parse_gain(const base::ConfigNode& body, FlightStep& step) {
  step.loop = body.require<std::string>("loop");
  step.p = optional_number(body, "p");
  step.i = optional_number(body, "i");
  step.d = optional_number(body, "d");
  if (!step.p && !step.i && !step.d) body.fail("a setgain step names at least one of p, i and d");
}

void parse_body(const base::ConfigNode& body, FlightStep& step) {
  if (step.kind == StepKind::kTakeoff) step.altitude_m = body.require_in("altitude_m", 0.5, 1000);
  if (step.kind == StepKind::kGoto) parse_goto(body, step);
  if (step.kind == StepKind::kSetGain) parse_gain(body, step);
  if (step.kind == StepKind::kHold) {
    step.duration = base::from_seconds(body.require_in("duration_s", 0.1, kMaxStepSeconds));
    step.measure = body.get("measure", false);
  }
  const double timeout_s =
      body.get_in("timeout_s", base::to_seconds(step.timeout), 0.1, kMaxStepSeconds);
  step.timeout = base::from_seconds(timeout_s);
}

FlightStep parse_step(const base::ConfigNode& node) {
  FlightStep step;
  if (node.is_scalar()) {
    step.kind = parse_kind(node, node.as<std::string>());
    parse_body(base::ConfigNode::empty(node.path()), step);
    return step;
  }
  if (!node.is_map()) node.fail("a step is a word or a map with one key, such as 'hold: {...}'");
  const auto entries = node.entries();
  if (entries.size() != 1) node.fail("a step is a map with exactly one key");
  step.kind = parse_kind(node, entries.front().first);
  const base::ConfigNode& body = entries.front().second;
  if (!body.is_map()) body.fail("the step takes a map");
  parse_body(body, step);
  return step;
}

/// Walks through the flight and refuses a step that the state before it does not allow.
class Rehearsal {
 public:
  void play(const FlightStep& step, const base::ConfigNode& node) {
    const std::string word(to_string(step.kind));
    switch (step.kind) {
      case StepKind::kArm:
        if (armed_) node.fail("the vehicle is armed already");
        armed_ = true;
        return;
      case StepKind::kTakeoff:
        if (!armed_) node.fail("takeoff needs an arm step before it");
        if (airborne_) node.fail("the vehicle is in the air already");
        airborne_ = true;
        return;
      case StepKind::kGoto:
      case StepKind::kLand:
        if (!airborne_) node.fail(word + " needs a takeoff step before it");
        airborne_ = step.kind == StepKind::kGoto;
        return;
      case StepKind::kHold:
        if (step.measure && !airborne_) node.fail("a measured hold needs a takeoff step before it");
        if (step.measure && measured_) node.fail("only one hold can be the measured one");
        measured_ = measured_ || step.measure;
        return;
      case StepKind::kDisarm:
        if (airborne_) node.fail("disarm in the air would drop the vehicle: land first");
        armed_ = false;
        return;
      case StepKind::kSetGain:
        return;
    }
  }

  void finish(const base::ConfigNode& steps) const {
    if (airborne_) steps.fail("the flight ends in the air: add a land step");
    if (!measured_) steps.fail("no hold is measured: give one of them 'measure: true'");
  }

 private:
  bool armed_ = false;
  bool airborne_ = false;
  bool measured_ = false;
};

}  // namespace

std::string_view to_string(StepKind kind) {
  for (const auto& [candidate, name] : kWords) {
    if (candidate == kind) return name;
  }
  return "?";
}

std::vector<FlightStep> parse_flight(const base::ConfigNode& steps) {
  if (!steps.is_list()) steps.fail("steps is a list");
  std::vector<FlightStep> flight;
  Rehearsal rehearsal;
  for (const base::ConfigNode& node : steps.items()) {
    flight.push_back(parse_step(node));
    rehearsal.play(flight.back(), node);
  }
  rehearsal.finish(steps);
  return flight;
}

}  // namespace cas::hils
