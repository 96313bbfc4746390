// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/flight_step.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "base/angles.hpp"
#include "base/enum_words.hpp"
#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "hils/flight/phase_check.hpp"

namespace cas::hils {

namespace {

constexpr double kMaxStepSeconds = 86'400;
constexpr double kMaxDistanceM = 10'000;
constexpr base::Duration kMissionPatience = std::chrono::minutes(5);
constexpr base::Duration kRebootPatience = std::chrono::minutes(1);
constexpr base::Duration kBreachPatience = std::chrono::minutes(2);
constexpr base::Duration kLoiterPatience = std::chrono::minutes(3);
constexpr base::Duration kTransitionPatience = std::chrono::minutes(1);
constexpr double kBreachSpeed_m_s = 2;

constexpr base::EnumWords<StepKind::kStandBy> kWords{
    "arm",     "takeoff",  "goto",       "hold",    "trajectory", "sticks",
    "setgain", "setparam", "wait_until", "mission", "loiter",     "transition",
    "breach",  "rtl",      "land",       "disarm",  "reboot",     "end of trajectory",
    "stand by"};
/// The words of scenarios.
constexpr auto kScenarioWords =
    std::span(kWords.words).first<static_cast<std::size_t>(StepKind::kEndTrajectory)>();

constexpr std::array<std::pair<fcu::PatternShape, std::string_view>, 3> kShapes{{
    {fcu::PatternShape::kCircle, "circle"},
    {fcu::PatternShape::kFigureEight, "figure_eight"},
    {fcu::PatternShape::kSteps, "step"},
}};

/// "; steps are arm, land", and which of them was meant where one is near.
template <class Words>
std::string or_these(std::string_view kinds, std::string_view word, const Words& known) {
  return fmt::format("; {} are {}{}", kinds, fmt::join(known, ", "),
                     base::did_you_mean(word, known));
}

StepKind parse_kind(const base::ConfigNode& node, std::string_view word) {
  const auto kind = kWords.find(word);
  if (kind && *kind < StepKind::kEndTrajectory) return *kind;
  node.fail(fmt::format("there is no step '{}'{}", word, or_these("steps", word, kScenarioWords)));
}

std::optional<double> optional_number(const base::ConfigNode& node, std::string_view key) {
  const std::optional<base::ConfigNode> child = node.find(key);
  if (!child) return std::nullopt;
  const double value = child->as<double>();
  // The vehicle has a range of its own; no autopilot has a gain outside this one.
  constexpr double kMostGain = 1000;
  if (!(value >= 0 && value <= kMostGain))
    child->fail(fmt::format("{:g} must lie in [0, {:g}]", value, kMostGain));
  return value;
}

Eigen::Vector3d parse_place(const base::ConfigNode& body) {
  return {body.require_in("north_m", -kMaxDistanceM, kMaxDistanceM),
          body.require_in("east_m", -kMaxDistanceM, kMaxDistanceM),
          body.require_in("up_m", 0.5, kMaxDistanceM)};
}

void parse_goto(const base::ConfigNode& body, FlightStep& step) {
  step.place_m = parse_place(body);
  if (body.has("yaw_deg")) step.yaw_rad = heading_deg(body) * base::kRadPerDeg;
}

void parse_gain(const base::ConfigNode& body, FlightStep& step) {
  step.loop = body.require<std::string>("loop");
  step.p = optional_number(body, "p");
  step.i = optional_number(body, "i");
  step.d = optional_number(body, "d");
  if (step.p || step.i || step.d) return;
  // An unknown key such as "P" is named, with the key that was meant; these two are read later.
  for (const char* const key : {"name", "timeout_s"}) body.has(key);
  body.reject_unused();
  body.fail("a setgain step names at least one of p, i and d");
}

/// The scenario does not name the autopilot: a gain that any of them has is accepted.
void check_gain(const base::ConfigNode& body, const FlightStep& step, const casd::GainMap& gains) {
  if (gains.empty()) return;
  std::optional<std::string> refusal;
  std::vector<std::string> known;
  for (const casd::Autopilot autopilot : {casd::Autopilot::kPx4, casd::Autopilot::kArduPilot}) {
    for (const casd::GainLoop& loop : gains.loops(autopilot)) {
      if (std::ranges::find(known, loop.name) == known.end()) known.push_back(loop.name);
      if (loop.name != step.loop) continue;
      refusal = casd::unsupported(loop, {.p = step.p, .i = step.i, .d = step.d});
      if (!refusal) return;
    }
  }
  if (refusal) body.fail(*refusal);
  body.at("loop").fail(
      fmt::format("there is no loop '{}'{}", step.loop, or_these("loops", step.loop, known)));
}

fcu::PatternShape parse_shape(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  std::vector<std::string_view> known;
  for (const auto& [shape, name] : kShapes) {
    if (name == word) return shape;
    known.push_back(name);
  }
  node.fail("a trajectory is a circle, a figure_eight or a step" + base::did_you_mean(word, known));
}

/// A step goes north at once after half of its time, the others go on for `duration_s`.
void parse_trajectory(const base::ConfigNode& body, FlightStep& step) {
  Trajectory& trajectory = step.trajectory;
  trajectory.shape = parse_shape(body.at("shape"));
  trajectory.size_m = body.require_in("size_m", 0.1, 50);
  const double duration_s = body.require_in("duration_s", 2, 240);
  step.duration = base::from_seconds(duration_s);
  if (trajectory.shape == fcu::PatternShape::kSteps) {
    trajectory.period_s = duration_s / 2;
  } else {
    trajectory.speed_m_s = body.require_in("speed_m_s", 0.1, 10);
  }
  step.params = {{"CAS_TRJ_SIZE", trajectory.size_m},
                 {"CAS_TRJ_SPEED", trajectory.speed_m_s},
                 {"CAS_TRJ_PERIOD", trajectory.period_s},
                 {"CAS_TRJ_SHAPE", static_cast<double>(trajectory.shape)}};
}

void parse_sticks(const base::ConfigNode& body, FlightStep& step) {
  step.sticks = Sticks{.pitch = body.get_in("pitch", 0, -1, 1),
                       .roll = body.get_in("roll", 0, -1, 1),
                       .yaw = body.get_in("yaw", 0, -1, 1),
                       .climb = body.get_in("climb", 0, -1, 1)};
  step.duration = base::from_seconds(body.require_in("duration_s", 0.5, 240));
}

/// "landed" unless the scenario has set the vehicle to stay in the air.
void parse_rtl(const base::ConfigNode& body, FlightStep& step) {
  const auto ends = body.get<std::string>("ends", "landed");
  if (ends != "landed" && ends != "holding") body.at("ends").fail("an rtl ends landed or holding");
  step.ends_holding = ends == "holding";
}

/// A circle about a place, which counts from where the vehicle was armed.
void parse_loiter(const base::ConfigNode& body, FlightStep& step) {
  constexpr double kLeastRadius_m = 5;
  constexpr double kMostRadius_m = 1000;
  step.place_m = {body.get_in("north_m", 0, -kMaxDistanceM, kMaxDistanceM),
                  body.get_in("east_m", 0, -kMaxDistanceM, kMaxDistanceM),
                  body.require_in("up_m", 0.5, kMaxDistanceM)};
  step.radius_m = body.require_in("radius_m", -kMostRadius_m, kMostRadius_m);
  if (std::abs(step.radius_m) < kLeastRadius_m) {
    body.at("radius_m").fail("is at least 5 m; below 0 the circle is flown counter-clockwise");
  }
  step.timeout = kLoiterPatience;
}

void parse_transition(const base::ConfigNode& body, FlightStep& step) {
  const auto to = body.require<std::string>("to");
  if (to != "plane" && to != "multicopter") {
    body.at("to").fail("a VTOL turns into a plane or a multicopter");
  }
  step.to_plane = to == "plane";
  step.timeout = kTransitionPatience;
}

/// A place that the fence keeps the vehicle from.
void parse_breach(const base::ConfigNode& body, FlightStep& step) {
  step.place_m = parse_place(body);
  step.reach_m = step.place_m.norm();
  step.trajectory.speed_m_s = body.get_in("speed_m_s", kBreachSpeed_m_s, 0.1, 10);
  step.timeout = kBreachPatience;
}

void parse_params(const base::ConfigNode& body, FlightStep& step) {
  if (const auto value = body.find("value")) {
    value->fail("a setparam step has each parameter as a key, such as 'MPC_XY_P: 0.95'");
  }
  for (const auto& [name, value] : body.entries()) {
    if (name == "name" || name == "timeout_s" || name == "vehicle") continue;
    step.params.emplace_back(name, value.as<double>());
    if (std::abs(step.params.back().second) > std::numeric_limits<float>::max()) {
      value.fail("no parameter holds so large a number");
    }
  }
  if (step.params.empty()) body.fail("a setparam step names at least one parameter");
}

/// Keys without which the step means nothing, where there are several.
std::vector<std::string_view> needed_keys(const base::ConfigNode& body, StepKind kind) {
  if (kind == StepKind::kGoto || kind == StepKind::kBreach) return {"north_m", "east_m", "up_m"};
  if (kind == StepKind::kLoiter) return {"up_m", "radius_m"};
  if (kind != StepKind::kTrajectory) return {};
  const auto shape = body.find("shape");
  const bool is_step = shape && shape->as<std::string>() == "step";
  if (!shape || is_step) return {"shape", "size_m", "duration_s"};
  return {"shape", "size_m", "duration_s", "speed_m_s"};
}

/// Names all the keys that a step lacks. Of a single one ConfigNode::at() knows which was meant.
void check_keys(const base::ConfigNode& body, StepKind kind) {
  std::vector<std::string_view> missing = needed_keys(body, kind);
  std::erase_if(missing, [&body](std::string_view key) { return body.has(key); });
  if (missing.size() < 2) return;
  body.fail(fmt::format("keys are missing: '{}'", fmt::join(missing, "', '")));
}

void parse_body(const base::ConfigNode& body, const VehicleNames& names, FlightStep& step) {
  check_keys(body, step.kind);
  step.vehicle = parse_vehicle_key(body, names);
  if (step.kind == StepKind::kTakeoff) step.altitude_m = body.require_in("altitude_m", 0.5, 1000);
  if (step.kind == StepKind::kGoto) parse_goto(body, step);
  if (step.kind == StepKind::kSetGain) parse_gain(body, step);
  if (step.kind == StepKind::kSetParam) parse_params(body, step);
  if (step.kind == StepKind::kTrajectory) parse_trajectory(body, step);
  if (step.kind == StepKind::kSticks) parse_sticks(body, step);
  if (step.kind == StepKind::kRtl) parse_rtl(body, step);
  if (step.kind == StepKind::kBreach) parse_breach(body, step);
  if (step.kind == StepKind::kLoiter) parse_loiter(body, step);
  if (step.kind == StepKind::kTransition) parse_transition(body, step);
  if (step.kind == StepKind::kReboot) step.timeout = kRebootPatience;
  if (step.kind == StepKind::kMission) {
    step.mission = parse_mission(body);
    step.timeout = kMissionPatience;
  }
  if (step.kind == StepKind::kWaitUntil) {
    step.until = parse_condition(body, "condition");
    if (!step.until) body.fail("wait_until needs a condition, such as 'altitude > 2'");
  }
  if (step.kind == StepKind::kHold) {
    step.duration = base::from_seconds(body.require_in("duration_s", 0.1, kMaxStepSeconds));
  }
  if (step.kind == StepKind::kHold || step.kind == StepKind::kTrajectory) {
    step.measure = body.get("measure", false);
  }
  step.name = body.get<std::string>("name", "");
  const double timeout_s =
      body.get_in("timeout_s", base::to_seconds(step.timeout), 0.1, kMaxStepSeconds);
  step.timeout = base::from_seconds(timeout_s);
}

FlightStep parse_step(const base::ConfigNode& node, const casd::GainMap& gains,
                      const VehicleNames& names) {
  FlightStep step;
  if (node.is_scalar()) {
    step.kind = parse_kind(node, node.as<std::string>());
    try {
      parse_body(base::ConfigNode::empty("the step alone"), names, step);
    } catch (const base::ConfigError& error) {
      node.fail(std::string("needs a map of its values: ") + error.what());
    }
    return step;
  }
  if (!node.is_map()) node.fail("a step is a word or a map with one key, such as 'hold: {...}'");
  const auto entries = node.entries();
  if (entries.size() != 1) {
    node.fail("a step is a map with exactly one key, and this has: " +
              base::joined(entries, ", ", [](const auto& entry) { return entry.first; }));
  }
  step.kind = parse_kind(node, entries.front().first);
  const base::ConfigNode& body = entries.front().second;
  if (!body.is_map()) body.fail("the step takes a map");
  parse_body(body, names, step);
  if (step.kind == StepKind::kSetGain) check_gain(body, step, gains);
  return step;
}

/// A wait_until asks for steps that the flight has. @throws base::ConfigError
void check_conditions(const base::ConfigNode& steps, const std::vector<FlightStep>& flight) {
  for (const base::ConfigNode& node : steps.items()) {
    if (!node.is_map() || !node.has("wait_until")) continue;
    check_phases(node.at("wait_until").at("condition"), flight);
  }
}

/// The step itself, or `stand by` for a vehicle that it does not name. The phase stays the same.
FlightStep as_seen_by(std::size_t vehicle, const FlightStep& step) {
  if (!step.vehicle || *step.vehicle == vehicle) return step;
  FlightStep other;
  other.kind = StepKind::kStandBy;
  other.name = phase_of(step);
  other.vehicle = step.vehicle;
  other.measure = step.measure;
  return other;
}

/// Walks through the steps of a flight as they are read and refuses one that the state before it
/// does not allow: no takeoff before arm, nothing measured on the ground, no end in the air.
class FlightRehearsal {
 public:
  /// @param who  the vehicle, where errors must name it; else empty
  explicit FlightRehearsal(std::string who) : who_(std::move(who)) {}

  /// @throws base::ConfigError at `node`
  void play(const FlightStep& step, const base::ConfigNode& node);
  /// @throws base::ConfigError at `steps`
  void finish(const base::ConfigNode& steps) const;

 private:
  void play_mission(const FlightStep& step, const base::ConfigNode& node);
  void play_measure(const FlightStep& step, const base::ConfigNode& node);

  [[noreturn]] void refuse(const base::ConfigNode& node, const std::string& sentence) const;

  std::string who_;
  bool armed_ = false;
  bool airborne_ = false;
  bool measured_ = false;
};

void FlightRehearsal::play(const FlightStep& step, const base::ConfigNode& node) {
  const std::string word(to_string(step.kind));
  switch (step.kind) {
    case StepKind::kArm:
      if (armed_) refuse(node, "the vehicle is armed already");
      armed_ = true;
      return;
    case StepKind::kTakeoff:
      if (!armed_) refuse(node, "takeoff needs an arm step before it");
      if (airborne_) refuse(node, "the vehicle is in the air already");
      airborne_ = true;
      return;
    case StepKind::kGoto:
    case StepKind::kTrajectory:
    case StepKind::kSticks:
    case StepKind::kLoiter:
    case StepKind::kTransition:
    case StepKind::kBreach:
    case StepKind::kLand:
      if (!airborne_) refuse(node, word + " needs a takeoff step before it");
      airborne_ = step.kind != StepKind::kLand;
      return play_measure(step, node);
    case StepKind::kRtl:
      if (!airborne_) refuse(node, word + " needs a takeoff step before it");
      airborne_ = step.ends_holding;
      return;
    case StepKind::kMission:
      return play_mission(step, node);
    case StepKind::kHold:
    case StepKind::kStandBy:
      return play_measure(step, node);
    case StepKind::kDisarm:
      if (airborne_) refuse(node, "disarm in the air would drop the vehicle: land first");
      armed_ = false;
      return;
    case StepKind::kReboot:
      if (armed_) refuse(node, "reboot needs a disarmed vehicle: add a disarm step before it");
      return;
    case StepKind::kEndTrajectory:
    case StepKind::kSetGain:
    case StepKind::kSetParam:
    case StepKind::kWaitUntil:
      return;
  }
}

void FlightRehearsal::play_mission(const FlightStep& step, const base::ConfigNode& node) {
  const bool takes_off = step.mission.takes_off();
  if (!armed_) refuse(node, "mission needs an arm step before it");
  if (!airborne_ && !takes_off) {
    refuse(node,
           "a mission from the ground begins with a takeoff, or needs a takeoff step before it");
  }
  if (airborne_ && takes_off) {
    refuse(node, "the vehicle is in the air already: the mission begins without a takeoff");
  }
  airborne_ = !step.mission.lands();
}

void FlightRehearsal::play_measure(const FlightStep& step, const base::ConfigNode& node) {
  if (!step.measure) return;
  if (!airborne_) refuse(node, "a measured hold needs a takeoff step before it");
  if (measured_) refuse(node, "only one step can be the measured one");
  measured_ = true;
}

void FlightRehearsal::finish(const base::ConfigNode& steps) const {
  if (airborne_) refuse(steps, "the flight ends in the air: add a land step");
  if (!measured_) {
    steps.reject_unused();  // a misspelt `measure` is the reason
    refuse(steps, "no hold is measured: give one hold or trajectory 'measure: true'");
  }
}

void FlightRehearsal::refuse(const base::ConfigNode& node, const std::string& sentence) const {
  node.fail(who_.empty() ? sentence : who_ + ": " + sentence);
}

}  // namespace

std::optional<std::size_t> parse_vehicle_key(const base::ConfigNode& node,
                                             const VehicleNames& names) {
  const std::optional<base::ConfigNode> key = node.find("vehicle");
  if (!key) return std::nullopt;
  const auto name = key->as<std::string>();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    key->fail(fmt::format("there is no vehicle '{}'{}", name, or_these("vehicles", name, names)));
  }
  return static_cast<std::size_t>(found - names.begin());
}

std::string_view to_string(StepKind kind) { return kWords[kind]; }

std::string_view phase_of(const FlightStep& step) {
  return step.name.empty() ? to_string(step.kind) : std::string_view(step.name);
}

bool takes_off(const FlightStep& step) {
  return step.kind == StepKind::kTakeoff ||
         (step.kind == StepKind::kMission && step.mission.takes_off());
}

bool lands(const FlightStep& step) {
  if (step.kind == StepKind::kMission) return step.mission.lands();
  return step.kind == StepKind::kLand || (step.kind == StepKind::kRtl && !step.ends_holding);
}

bool is_command(StepKind kind) {
  return kind != StepKind::kHold && kind != StepKind::kWaitUntil && kind != StepKind::kStandBy;
}

std::vector<FlightStep> parse_flight(const base::ConfigNode& steps, const casd::GainMap& gains,
                                     const VehicleNames& names) {
  if (!steps.is_list()) steps.fail("steps is a list");
  std::vector<FlightStep> flight;
  std::vector<FlightRehearsal> rehearsals;
  for (const std::string& name : names) rehearsals.emplace_back(names.size() > 1 ? name : "");
  for (const base::ConfigNode& node : steps.items()) {
    const FlightStep& step = flight.emplace_back(parse_step(node, gains, names));
    for (std::size_t i = 0; i < rehearsals.size(); ++i) {
      rehearsals[i].play(as_seen_by(i, step), node);
    }
    if (step.kind != StepKind::kTrajectory && step.kind != StepKind::kSticks) continue;
    FlightStep end;
    end.kind = StepKind::kEndTrajectory;
    end.vehicle = step.vehicle;
    end.params = {{"CAS_TRJ_SHAPE", 0}};
    end.sticks = step.sticks;
    flight.push_back(end);
  }
  for (const FlightRehearsal& rehearsal : rehearsals) rehearsal.finish(steps);
  check_conditions(steps, flight);
  return flight;
}

std::optional<Sticks> held_sticks(const FlightStep& step) {
  if (step.kind == StepKind::kSticks) return step.sticks;
  if (step.kind == StepKind::kEndTrajectory && step.sticks) return Sticks{};
  return std::nullopt;
}

void refuse_firmware_steps(const base::ConfigNode& steps, bool has_wing) {
  const auto of_wings = [](std::string_view word) {
    return word == "loiter" || word == "transition";
  };
  for (const base::ConfigNode& node : steps.items()) {
    for (const char* const word : {"mission", "loiter", "transition", "breach", "reboot"}) {
      const bool bare = node.is_scalar() && node.as<std::string>() == word;
      if ((has_wing && of_wings(word)) || (!bare && !(node.is_map() && node.has(word)))) continue;
      (bare ? node : node.at(word))
          .fail(fmt::format("only a scenario of stock firmware (key firmware) has a step {}{}",
                            word,
                            of_wings(word) ? ", or one of a vehicle with wings (block aero)" : ""));
    }
  }
}

std::vector<FlightStep> steps_for(std::size_t vehicle, const std::vector<FlightStep>& flight) {
  std::vector<FlightStep> steps;
  steps.reserve(flight.size());
  for (const FlightStep& step : flight) steps.push_back(as_seen_by(vehicle, step));
  return steps;
}

}  // namespace cas::hils
