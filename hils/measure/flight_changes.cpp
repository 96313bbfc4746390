// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/flight_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "casd/packet/intervention.hpp"
#include "casd/packet/own_station.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/services.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "hils/flight/flight_step.hpp"
#include "hils/measure/firmware_record.hpp"
#include "hils/measure/run_record.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

using namespace mavlink::common;  // NOLINT: the file is about its messages
using nlohmann::json;

namespace {

constexpr std::uint8_t kAutopilot = 1;  ///< component

/// A float's worth of a number apart at most.
bool same(double a, double b) { return static_cast<float>(a) == static_cast<float>(b); }

/// Gains and parameters that a step of the scenario sets.
std::map<std::string, double> values_of(const FlightStep& step,
                                        const std::vector<casd::GainLoop>& loops) {
  std::map<std::string, double> values(step.params.begin(), step.params.end());
  if (step.kind != StepKind::kSetGain) return values;
  const auto loop = std::ranges::find(loops, step.loop, &casd::GainLoop::name);
  if (loop == loops.end()) return values;
  if (loop->p && step.p) values[*loop->p] = *step.p;
  if (loop->i && step.i) values[*loop->i] = *step.i;
  if (loop->d && step.d) values[*loop->d] = *step.d;
  return values;
}

/// "velocity P" for MPC_XY_VEL_P_ACC.
std::string loop_words(const std::vector<casd::GainLoop>& loops, const std::string& parameter) {
  for (const casd::GainLoop& loop : loops) {
    if (loop.p == parameter) return loop.name + " P";
    if (loop.i == parameter) return loop.name + " I";
    if (loop.d == parameter) return loop.name + " D";
  }
  return {};
}

/// A parameter's name as terminal, page and JSON take it, whatever bytes came over the wire.
template <std::size_t n>
std::string name_of(const std::array<char, n>& id) {
  std::string name(mav::text(id));
  std::ranges::replace_if(
      name, [](char c) { return c < ' ' || c > '~'; }, '?');
  return name;
}

/// Whether a call injects a failure, by the kept part of its parameters.
bool is_failure(const OutsideCall& call) {
  if (call.method != "vehicle.command") return false;
  const json params = json::parse(call.params, nullptr, false);
  return params.is_object() &&
         static_cast<MavCmd>(params.value("command", 0)) == MavCmd::kInjectFailure;
}

/// Goes through a flight log and the calls of the command port.
class ChangeReader {
 public:
  ChangeReader(const RunRecord& record, const casd::GainMap& gains, bool own_station)
      : record_(record), gains_(gains), own_station_(own_station), stages_(record.flown_stages()) {}

  void on_packet(std::int64_t log_us, const mav::PacketView& packet) {
    if (packet.source.system == record_.system) {
      if (packet.source.component == kAutopilot) on_vehicle(log_us, packet);
      return;
    }
    if (is_own(packet.source)) return;
    on_other(log_us, packet);
  }

  void add_calls() {
    for (const OutsideCall& call : record_.outside_calls) {
      const bool tunes = call.method == "param.set" || call.method == "gain.set";
      if ((call.system != record_.system && call.system != 0) || !is_act(call)) continue;
      if (tunes && call.accepted) continue;  // where it changed a value, the log has it
      const std::string params = call.params == "{}" ? "" : " " + call.params;
      const std::string what = call.method + params + (call.accepted ? "" : ", refused");
      // Calls to the simulator count at any time: after a reset simulated time is early again.
      if (call.sim_s || is_failure(call)) {
        keep_act(call.sim_s.value_or(seconds(call.log_us)), port_words(call), what);
      } else {
        add_act(call.log_us, port_words(call), what);
      }
    }
  }

  FlightChanges finish() {
    std::ranges::stable_sort(changes_.acts, {}, &OutsideAct::time_s);
    return std::move(changes_);
  }

 private:
  static std::string port_words(const OutsideCall& call) {
    return call.port + " (" + call.client + ")";
  }

  /// Commands of casd's station come from its command port: from hils or from the listed calls.
  static bool is_own(mav::Source source) {
    return source == casd::kOwnStation || source == kCompanion || source == kCompanionSticks;
  }

  const std::vector<casd::GainLoop>& loops() const { return gains_.loops(autopilot_); }
  double seconds(std::int64_t log_us) const {
    return static_cast<double>(record_.log_clock.to_sim_us(log_us)) * 1e-6;
  }

  void on_vehicle(std::int64_t log_us, const mav::PacketView& packet) {
    if (const auto beat = mav::decode<Heartbeat>(packet)) {
      autopilot_ = casd::autopilot_family(beat->autopilot);
    }
    if (const auto answer = mav::decode<CommandAck>(packet)) on_answer(log_us, *answer);
    const auto told = mav::decode<ParamValue>(packet);
    if (!told) return;
    const auto encoding = autopilot_ == casd::Autopilot::kArduPilot
                              ? casd::ParamEncoding::kCast
                              : casd::ParamEncoding::kBytewise;
    on_value(log_us, name_of(told->param_id),
             casd::from_wire(encoding, told->param_type, told->param_value));
  }

  /// The addressee may have commanded the vehicle over a link that casd does not see.
  void on_answer(std::int64_t log_us, const CommandAck& answer) {
    const mav::Source asker{answer.target_system, answer.target_component};
    const std::optional<casd::Act> act = casd::act_of(answer);
    if (!act || asker.system == 0 || is_own(asker) || heard_.contains(asker)) return;
    add_act(log_us, station_words(asker), act->what);
  }

  static std::string station_words(mav::Source source) {
    return fmt::format("ground station {}/{}", source.system, source.component);
  }

  void on_value(std::int64_t log_us, const std::string& name, double value) {
    const auto known = values_.find(name);
    const auto wish = wishes_.extract(name);  // answered, whatever came of it
    const bool first = known == values_.end();
    std::optional<double> before;
    if (!first) before = known->second;
    values_[name] = value;
    const bool unchanged = before && (same(*before, value) || std::isnan(value));
    const bool wished = !wish.empty() && log_us - wish.mapped().second <= kLongest_us;
    if (unchanged || (first && !wished)) return;
    ParameterChange change{.time_s = seconds(log_us),
                           .by = "the vehicle itself",
                           .parameter = name,
                           .loop = loop_words(loops(), name),
                           .before = before,
                           .after = value};
    if (wished) {
      change.by = wish.mapped().first;
      change.from_outside = true;
    } else if (const OutsideCall* call = call_for(log_us, name, value)) {
      change.by = port_words(*call);
      change.from_outside = true;
    } else if (const Stage* stage = stage_for(change.time_s, name, value)) {
      if (stage->step.kind == StepKind::kTrajectory) return;
      if (stage->step.kind == StepKind::kEndTrajectory) return;
      change.by = fmt::format("scenario, step '{}'", phase_of(stage->step));
    }
    changes_.parameters.push_back(std::move(change));
  }

  /// A value that a call had casd set at about this time.
  const OutsideCall* call_for(std::int64_t log_us, const std::string& name, double value) const {
    for (const OutsideCall& call : record_.outside_calls) {
      if (call.system != record_.system || std::abs(call.log_us - log_us) > kLongest_us) continue;
      const json params = json::parse(call.params, nullptr, false);
      if (!params.is_object()) continue;
      if (call.method == "param.set" && params.value("name", "") == name &&
          same(params.value("value", NAN), value)) {
        return &call;
      }
      if (call.method == "gain.set" && sets(params, name, value)) return &call;
    }
    return nullptr;
  }

  /// Whether parameters of gain.set mean this value of this parameter.
  bool sets(const json& params, const std::string& name, double value) const {
    FlightStep step{.kind = StepKind::kSetGain};
    step.loop = params.value("loop", "");
    for (auto [key, slot] : {std::pair{"p", &step.p}, {"i", &step.i}, {"d", &step.d}}) {
      if (params.contains(key) && params[key].is_number()) *slot = params[key].get<double>();
    }
    const std::map<std::string, double> values = values_of(step, loops());
    const auto found = values.find(name);
    return found != values.end() && same(found->second, value);
  }

  /// The step of the scenario that set this value; the clocks of log and flight are this far apart.
  const Stage* stage_for(double time_s, const std::string& name, double value) const {
    constexpr double kClocksApart_s = 1;
    for (const Stage& stage : stages_) {
      if (time_s < base::to_seconds(stage.begin) - kClocksApart_s) continue;
      if (time_s > base::to_seconds(stage.end) + kClocksApart_s) continue;
      const std::map<std::string, double> values = values_of(stage.step, loops());
      const auto found = values.find(name);
      if (found != values.end() && same(found->second, value)) return &stage;
    }
    return nullptr;
  }

  bool is_meant(std::uint8_t target) const { return target == 0 || target == record_.system; }

  void on_other(std::int64_t log_us, const mav::PacketView& packet) {
    const std::string by = station_words(packet.source);
    if (const auto wish = mav::decode<ParamSet>(packet)) {
      if (is_meant(wish->target_system)) wishes_[name_of(wish->param_id)] = {by, log_us};
      return;
    }
    const std::optional<casd::Act> act = casd::act_of(packet);
    if (!act || !is_meant(act->target.system)) return;
    if (own_station_ && packet.message_id == ManualControl::kId) return;
    heard_.insert(packet.source);
    // A failure lasts: it counts whenever it was.
    casd::is_failure(packet) ? keep_act(seconds(log_us), by, act->what)
                             : add_act(log_us, by, act->what);
  }

  /// Only acts in the flight count: before it a ground station greets the vehicle.
  void add_act(std::int64_t log_us, const std::string& by, const std::string& what) {
    const double time_s = seconds(log_us);
    if (stages_.empty() || time_s < base::to_seconds(stages_.front().begin)) return;
    // What comes after the step that failed may tell its cause.
    const bool completed = !record_.flight_failure;
    if (completed && time_s > base::to_seconds(stages_.back().end)) return;
    keep_act(time_s, by, what);
  }

  void keep_act(double time_s, const std::string& by, const std::string& what) {
    for (OutsideAct& act : changes_.acts) {
      if (act.by != by || act.what != what) continue;
      ++act.times;
      return;
    }
    if (changes_.acts.size() < kMostActs) {
      changes_.acts.push_back({.time_s = time_s, .by = by, .what = what});
    }
  }

  static constexpr std::size_t kMostActs = 200;
  /// From a wish to its answer: casd asks five times at most.
  static constexpr std::int64_t kLongest_us = 10'000'000;

  const RunRecord& record_;
  const casd::GainMap& gains_;
  bool own_station_;
  std::vector<Stage> stages_;  ///< with the one that was not done when the flight ended
  casd::Autopilot autopilot_ = casd::Autopilot::kPx4;
  std::map<std::string, double> values_;  ///< newest received
  std::set<mav::Source> heard_;           ///< of which acts have come
  /// Parameters that stations set: station and time.
  std::map<std::string, std::pair<std::string, std::int64_t>> wishes_;
  FlightChanges changes_;
};

}  // namespace

std::optional<OutsideCall> forgotten_calls(const json& journal, const std::string& port) {
  const std::uint64_t number = journal.at("forgotten").get<std::uint64_t>();
  if (number == 0) return std::nullopt;
  return OutsideCall{.client = "somebody",
                     .method = fmt::format("calls that are no longer listed: {}", number),
                     .params = "{}",
                     .port = port,
                     .sim_s = 0};
}

std::vector<OutsideCall> outside_calls(const json& journal, const std::string& own,
                                       const std::string& port) {
  std::vector<OutsideCall> calls;
  for (const json& call : journal.at("calls")) {
    const auto client = call.at("client").get<std::string>();
    if (client == own) continue;
    calls.push_back(
        {.log_us = call.at("unix_us").get<std::int64_t>(),
         .client = client,
         .method = call.at("method").get<std::string>(),
         .params = call.at("params").dump(-1, ' ', false, json::error_handler_t::replace),
         .system = call.value("vehicle", std::uint8_t{0}),
         .accepted = !call.contains("refusal"),
         .port = port,
         .sim_s = {}});
    if (call.contains("time_s")) calls.back().sim_s = call["time_s"].get<double>();
  }
  return calls;
}

bool is_act(const OutsideCall& call) {
  if (call.method == "vehicle.message_interval") return false;
  if (call.method != "vehicle.command") return true;
  const json params = json::parse(call.params, nullptr, false);
  return !params.is_object() || !casd::only_asks(static_cast<MavCmd>(params.value("command", 0)));
}

bool FlightChanges::from_outside() const {
  return !acts.empty() || std::ranges::any_of(parameters, &ParameterChange::from_outside);
}

FlightChanges flight_changes(const RunRecord& record, const casd::GainMap& gains,
                             bool own_station) {
  ChangeReader reader(record, gains, own_station);
  casd::for_each_tlog_packet(record.flight_tlog, table(),
                             [&](std::uint64_t unix_us, const mav::PacketView& packet) {
                               reader.on_packet(static_cast<std::int64_t>(unix_us), packet);
                             });
  reader.add_calls();
  return reader.finish();
}

}  // namespace cas::hils
